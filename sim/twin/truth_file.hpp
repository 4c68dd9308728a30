// truth_file.hpp: the twin's truth, one packed little-endian record per sample, in the order of conversion.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "instrument.hpp"

namespace gonio::sim {

// What was at the centre of the sample's window on the digitiser (the time of its strobe edge if it had one). A channel
// with a delay shows the light of time_ns - delay: interpolate the records for it.
struct __attribute__((packed)) Truth_record {
    std::uint64_t sample; // since START
    std::int64_t time_ns;
    std::array<double, axis_count> q_deg;
    double signal_counts; // noise-free low-gain counts, dark not included
};
static_assert(sizeof(Truth_record) == 56);

class Truth_file {
public:
    // An empty path: nothing is kept. Throws Input_error when it cannot be written.
    explicit Truth_file(const std::filesystem::path &path);
    ~Truth_file();
    Truth_file(const Truth_file &) = delete;
    Truth_file &operator=(const Truth_file &) = delete;
    Truth_file(Truth_file &&) = delete;
    Truth_file &operator=(Truth_file &&) = delete;

    void add(const Truth_record &record);
    [[nodiscard]] bool wanted() const { return file_.is_open(); }

private:
    void flush();

    std::ofstream file_;
    std::vector<Truth_record> waiting_;
};

} // namespace gonio::sim
