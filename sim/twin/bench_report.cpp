// bench_report.cpp: writes a flight's result.
#include "bench_report.hpp"

#include <array>
#include <iomanip>
#include <sstream>
#include <utility>

#include "journal.hpp"

namespace gonio::sim {

std::string flight_members(const Bench_result &result) {
    std::ostringstream text;
    text << "\"samples\": " << result.flight_samples
         << ", \"virtual_s\": " << 1e-9 * static_cast<double>(result.end_ns - result.flight_start_ns)
         << ", \"poses\": " << result.poses << ", \"poses_valid\": " << result.poses_valid
         << ", \"link_frames\": " << result.frames << ", \"payload_hash\": \"" << std::hex << std::setw(16)
         << std::setfill('0') << result.payload_hash << "\", \"trouble\": " << json_text(result.trouble);
    return text.str();
}

std::string counters_json(const gonio_Counters &counters) {
    const std::array<std::pair<const char *, std::uint64_t>, 21> all = {{
        {"samples", counters.samples},
        {"samples_lost", counters.samples_lost},
        {"packets_lost", counters.packets_lost},
        {"strobes", counters.strobes},
        {"strobes_lost", counters.strobes_lost},
        {"strobes_rejected", counters.strobes_rejected},
        {"strobe_realigned", counters.strobe_realigned},
        {"syncs", counters.syncs},
        {"sync_echoes_lost", counters.sync_echoes_lost},
        {"cycles_missed", counters.cycles_missed},
        {"tpdo_late", counters.tpdo_late},
        {"tpdo_missing", counters.tpdo_missing},
        {"tpdo_duplicate", counters.tpdo_duplicate},
        {"poses_dropped", counters.poses_dropped},
        {"can_overflow", counters.can_overflow},
        {"can_error_frames", counters.can_error_frames},
        {"can_setpoints_dropped", counters.can_setpoints_dropped},
        {"can_bus_offs", counters.can_bus_offs},
        {"clock_steps", counters.clock_steps},
        {"edges_lost", counters.edges_lost},
        {"link_gap_frames", counters.link_gap_frames},
    }};
    std::string text;
    for (const auto &[name, value] : all) {
        text += (text.empty() ? "{\"" : ", \"") + std::string(name) + "\": " + std::to_string(value);
    }
    return text + "}";
}

std::string latency_json(const std::map<int, gonio_Latency> &latency) {
    std::string text;
    for (const auto &[thread, histogram] : latency) {
        std::string bins;
        for (pb_size_t i = 0; i < histogram.bins_count; ++i) {
            bins += (bins.empty() ? "" : ", ") + std::to_string(histogram.bins[i]);
        }
        text += std::string(text.empty() ? "" : ", ") + "\"" +
                (thread == gonio_Thread_THREAD_MOTION ? "motion" : "stream") +
                "\": {\"wakeups\": " + std::to_string(histogram.wakeups) +
                ", \"max_us\": " + std::to_string(histogram.max_us) + ", \"bins\": [" + bins + "]}";
    }
    return "{" + text + "}";
}

} // namespace gonio::sim
