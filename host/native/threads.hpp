// threads.hpp: a range of work in equal parts, one per processor.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace gonio::sphere {

// Calls work(begin, end) for parts of 0 to n, at once; what one of them throws is thrown here.
template <typename Work> void in_threads(std::size_t n, const Work &work) {
    constexpr std::size_t LEAST = 4096;
    constexpr std::size_t MOST_THREADS = 16;
    const std::size_t processors = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, MOST_THREADS);
    const std::size_t count = std::clamp<std::size_t>(n / LEAST, 1, processors);
    std::vector<std::exception_ptr> failed(count);
    const auto part = [&](std::size_t k) {
        try {
            work(n * k / count, n * (k + 1) / count);
        } catch (...) {
            failed[k] = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t k = 1; k < count; ++k) {
        threads.emplace_back(part, k);
    }
    part(0);
    for (std::thread &one : threads) {
        one.join();
    }
    for (const std::exception_ptr &one : failed) {
        if (one) {
            std::rethrow_exception(one);
        }
    }
}

} // namespace gonio::sphere
