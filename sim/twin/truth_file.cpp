// truth_file.cpp: writes the truth records in large pieces.
#include "truth_file.hpp"

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::size_t records_per_write = 1024;

} // namespace

Truth_file::Truth_file(const std::filesystem::path &path) {
    if (path.empty()) {
        return;
    }
    file_.open(path, std::ios::binary | std::ios::trunc);
    if (!file_) {
        throw Input_error(path.string() + ": the truth file cannot be written; name a place that can be");
    }
}

Truth_file::~Truth_file() {
    flush();
}

void Truth_file::add(const Truth_record &record) {
    if (!wanted()) {
        return;
    }
    waiting_.push_back(record);
    if (waiting_.size() >= records_per_write) {
        flush();
    }
}

void Truth_file::flush() {
    if (!waiting_.empty()) {
        file_.write(reinterpret_cast<const char *>(waiting_.data()),
                    static_cast<std::streamsize>(waiting_.size() * sizeof(Truth_record)));
        waiting_.clear();
    }
}

} // namespace gonio::sim
