// journal.cpp: writes the journal.
#include "journal.hpp"

#include <cstdio>
#include <fstream>
#include <sstream>

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

template <typename Values, typename Show> std::string list(const Values &values, Show show) {
    std::string text = "[";
    for (const auto &value : values) {
        text += (text.size() > 1 ? ", " : "") + show(value);
    }
    return text + "]";
}

std::string number(double value) {
    std::ostringstream text;
    text.precision(12);
    text << value;
    return text.str();
}

std::string yes_no(bool value) {
    return value ? "true" : "false";
}

double seconds(std::int64_t ns) {
    return 1e-9 * static_cast<double>(ns);
}

std::string drives_json(const Apparatus &apparatus) {
    std::string text = "[";
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Drive &drive = apparatus.drive(i);
        text += i == 0 ? "\n" : ",\n";
        text += "    {\"node\": " + std::to_string(drive.config().node) +
                ", \"statusword\": " + std::to_string(drive.statusword()) +
                ", \"nmt_state\": " + std::to_string(drive.nmt_state()) +
                ", \"energised\": " + yes_no(drive.energised()) + ", \"homed\": " + yes_no(drive.homed()) +
                ", \"brake_closed\": " + yes_no(drive.brake_closed()) +
                ", \"syncs\": " + std::to_string(drive.counters().syncs) +
                ", \"rpdos\": " + std::to_string(drive.counters().rpdos) +
                ", \"tpdos\": " + std::to_string(drive.counters().tpdos) +
                ", \"sdo_aborts\": " + std::to_string(drive.counters().sdo_aborts) +
                ", \"emergencies\": " + std::to_string(drive.counters().emergencies) + "}";
    }
    return text + "\n  ]";
}

std::string standstill_json(const Standstill &s) {
    if (!s.watching) {
        return "null";
    }
    std::string const dark = s.dark_ns == 0 ? "null" : number(seconds(s.dark_ns - s.since_ns));
    return "{\"lost_at_s\": " + number(seconds(s.since_ns)) +
           ", \"standstill_after_s\": " + (s.reached ? number(seconds(s.standstill_ns - s.since_ns)) : "null") +
           ", \"dark_after_s\": " + dark + ", \"max_speed_deg_per_s\": " + number(s.max_speed_deg_per_s) +
           ", \"max_speed_after_standstill_deg_per_s\": " + number(s.max_speed_after_deg_per_s) + "}";
}

} // namespace

std::string json_text(const std::string &text) {
    std::string quoted = "\"";
    for (char const c : text) {
        if (c == '"' || c == '\\') {
            quoted += '\\';
            quoted += c;
        } else if (static_cast<unsigned char>(c) < 0x20U) {
            quoted += ' ';
        } else {
            quoted += c;
        }
    }
    return quoted + '"';
}

std::string apparatus_members(const Apparatus &apparatus) {
    std::int64_t const now_ns = apparatus.scheduler().now_ns();
    std::string faults = "{";
    for (const auto &[name, count] : apparatus.faults().injected()) {
        faults += (faults.size() > 1 ? ", " : "") + json_text(name) + ": " + std::to_string(count);
    }
    double const bit_times = seconds(apparatus.running_ns()) * 1e6 + 1e-9;
    std::ostringstream out;
    out << "  \"position_deg\": " << list(apparatus.position_deg(now_ns), number)
        << ",\n  \"speed_deg_per_s\": " << list(apparatus.speed_deg_per_s(), number)
        << ",\n  \"at_rest\": " << yes_no(apparatus.at_rest()) << ",\n  \"shutter_open\": " << yes_no(!apparatus.dark())
        << ",\n  \"watchdog_trips\": " << apparatus.shutter().watchdog_trips()
        << ",\n  \"torque_allowed\": " << yes_no(apparatus.interlocks().torque_allowed())
        << ",\n  \"samples\": " << apparatus.digitiser().samples()
        << ",\n  \"optics\": " << json_text(apparatus.optics().account())
        << ",\n  \"packets_lost\": " << apparatus.digitiser().packets_lost()
        << ",\n  \"strobe_edges\": " << apparatus.strobe().edges()
        << ",\n  \"strobe_edges_lost\": " << apparatus.strobe().edges_lost()
        << ",\n  \"can_frames\": " << apparatus.bus().frames()
        << ",\n  \"can_load\": " << number(static_cast<double>(apparatus.bus().busy_bits()) / bit_times)
        << ",\n  \"faults\": " << faults << "},\n  \"drives\": " << drives_json(apparatus);
    return out.str();
}

namespace {

void write_whole(const std::filesystem::path &path, const std::string &text) {
    std::filesystem::path const beside = path.string() + ".part";
    std::ofstream out(beside);
    out << text;
    out.close();
    if (!out || std::rename(beside.c_str(), path.c_str()) != 0) {
        throw Input_error(path.string() + ": the journal cannot be written; name a place that can be");
    }
}

std::string head(const Apparatus &apparatus, const std::string &end_reason) {
    return "{\n  \"scenario\": " + json_text(apparatus.scenario().path.string()) +
           ",\n  \"end_reason\": " + json_text(end_reason);
}

} // namespace

void write_journal(const std::filesystem::path &path, const World &world, const std::string &end_reason,
                   double wall_s) {
    const Apparatus &apparatus = world.apparatus();
    std::ostringstream out;
    out << head(apparatus, end_reason) << ",\n  \"virtual_s\": " << number(seconds(apparatus.running_ns()))
        << ",\n  \"wall_s\": " << number(wall_s) << ",\n  \"last_told_state\": " << world.last_status().state
        << ",\n  \"last_fault\": " << json_text(world.last_fault())
        << ",\n  \"host_lost\": " << standstill_json(world.standstill()) << ",\n  \"paths\": " << world.paths() << ",\n"
        << apparatus_members(apparatus) << ",\n  \"log\": " << list(world.log_lines(), json_text) << "\n}\n";
    write_whole(path, out.str());
}

void write_journal(const std::filesystem::path &path, const Apparatus &apparatus, const std::string &end_reason) {
    write_whole(path, head(apparatus, end_reason) + ",\n  \"wall_s\": " + number(seconds(apparatus.running_ns())) +
                          ",\n" + apparatus_members(apparatus) + "\n}\n");
}

} // namespace gonio::sim
