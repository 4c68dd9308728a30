// commands.cpp: the control socket's commands.
#include "commands.hpp"

#include <algorithm>
#include <sstream>

#include "journal.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr const char *known = "state, fault KIND key=value ..., clear, mount on|off, quit";

template <typename Show> std::string per_axis(Show show) {
    std::ostringstream text;
    text.precision(10);
    for (std::size_t i = 0; i < axis_count; ++i) {
        text << (i == 0 ? "[" : ", ") << show(i);
    }
    return text.str() + "]";
}

std::string error(const std::string &text) {
    return "{\"error\": " + json_text(text) + "}";
}

std::string yes_no(bool value) {
    return value ? "true" : "false";
}

} // namespace

void Furthest::see(const std::array<double, axis_count> &q_deg) {
    for (std::size_t i = 0; i < axis_count; ++i) {
        least_deg_.at(i) = std::min(least_deg_.at(i), q_deg.at(i));
        most_deg_.at(i) = std::max(most_deg_.at(i), q_deg.at(i));
    }
}

std::string Furthest::json() const {
    return per_axis([this](std::size_t i) {
        std::ostringstream pair;
        if (least_deg_.at(i) > most_deg_.at(i)) {
            return std::string("null"); // nobody has looked yet
        }
        pair.precision(10);
        pair << "[" << least_deg_.at(i) << ", " << most_deg_.at(i) << "]";
        return pair.str();
    });
}

std::string Commands::obey(const std::string &line) {
    std::istringstream words(line);
    std::string verb;
    words >> verb;
    std::string rest;
    std::getline(words >> std::ws, rest);
    if (verb == "state") {
        return state();
    }
    if (verb == "fault") {
        return fault(rest);
    }
    if (verb == "clear") {
        apparatus_.faults().clear();
    } else if (verb == "mount" && (rest == "on" || rest == "off")) {
        apparatus_.mount_sample(rest == "on");
    } else if (verb == "quit") {
        ended_ = true;
    } else {
        return error("'" + line + "' is not known; " + known);
    }
    return "{\"ok\": true}";
}

std::string Commands::state() const {
    auto const q_deg = apparatus_.position_deg(apparatus_.scheduler().now_ns());
    auto const speed = apparatus_.speed_deg_per_s();
    std::string injected;
    for (const auto &[name, count] : apparatus_.faults().injected()) {
        injected += (injected.empty() ? "" : ", ") + json_text(name) + ": " + std::to_string(count);
    }
    return "{\"time_ns\": " + std::to_string(apparatus_.scheduler().now_ns()) +
           ", \"position_deg\": " + per_axis([&](std::size_t i) { return q_deg.at(i); }) +
           ", \"speed_deg_per_s\": " + per_axis([&](std::size_t i) { return speed.at(i); }) +
           ", \"at_rest\": " + yes_no(apparatus_.at_rest()) + ", \"shutter_open\": " + yes_no(!apparatus_.dark()) +
           ", \"lamp_on\": " + yes_no(apparatus_.lamp_on()) +
           ", \"nmt_state\": " + per_axis([&](std::size_t i) { return +apparatus_.drive(i).nmt_state(); }) +
           ", \"statusword\": " + per_axis([&](std::size_t i) { return apparatus_.drive(i).statusword(); }) +
           ", \"samples\": " + std::to_string(apparatus_.digitiser().samples()) +
           ", \"packets_lost\": " + std::to_string(apparatus_.digitiser().packets_lost()) +
           ", \"strobes\": " + std::to_string(apparatus_.strobe().edges() / 2) +
           ", \"watchdog_trips\": " + std::to_string(apparatus_.shutter().watchdog_trips()) +
           ", \"can_frames\": " + std::to_string(apparatus_.bus().frames()) +
           ", \"can_frames_dropped\": " + std::to_string(wire_ == nullptr ? 0 : wire_->frames_dropped()) +
           ", \"furthest_deg\": " + furthest_.json() + ", \"injected\": {" + injected + "}}";
}

// The scenario's own reader takes them: "emcy axis=1 code=0x4310" is a table of three keys.
std::string Commands::fault(const std::string &arguments) {
    std::istringstream words(arguments);
    std::string kind;
    words >> kind;
    std::string text = "kind = " + json_text(kind) + "\n";
    for (std::string word; words >> word;) {
        text += word + "\n";
    }
    try {
        Fault const fault = read_fault(toml::parse(text), "fault " + kind);
        if (fault.kind == Fault_kind::host_silent || fault.kind == Fault_kind::packet_counter_start ||
            fault.after_path != 0) {
            return error("fault " + kind + ": only the virtual run's twin can do that");
        }
        apparatus_.faults().inject(fault);
    } catch (const Input_error &wrong) {
        return error(wrong.what());
    } catch (const toml::parse_error &) {
        return error("fault " + arguments + ": write it as KIND key=value key=value");
    }
    return "{\"ok\": true}";
}

} // namespace gonio::sim
