// over_threads.hpp: numbered pieces of work, shared out among threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace gonio::sim {

// Calls work(0) ... work(pieces - 1), each once, on `threads` threads (this one is one of them). `work` must not throw.
template <typename Work> void over_threads(std::size_t pieces, unsigned threads, const Work &work) {
    std::atomic<std::size_t> next{0};
    auto const take_turns = [&] {
        for (std::size_t piece = next++; piece < pieces; piece = next++) {
            work(piece);
        }
    };
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < std::min<std::size_t>(threads, pieces); ++i) {
        others.emplace_back(take_turns);
    }
    take_turns();
}

} // namespace gonio::sim
