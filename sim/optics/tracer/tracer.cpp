// tracer.cpp: shares the photons of a range among threads, in chunks, and adds up their accounts.
#include "tracer.hpp"

#include <algorithm>
#include <exception>
#include <thread>

#include "photon_walk.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint64_t chunk_photons = 4096;

// Hands out the chunks of a range; whoever fails stops all.
struct Chunks {
    Photon_range range;
    std::atomic<std::uint64_t> next{0};
    std::atomic<bool> failed{false};
};

template <bool polarised>
Balance work(const Trace_scene &run, Chunks &chunks, Hit_sink &sink, unsigned worker, Watch &watch) {
    Photon_walk<polarised> walk(run, sink, worker);
    while (!watch.cancelled.load(std::memory_order_relaxed) && !chunks.failed.load(std::memory_order_relaxed)) {
        std::uint64_t const begin = chunks.next.fetch_add(chunk_photons, std::memory_order_relaxed);
        if (begin >= chunks.range.count) {
            break;
        }
        std::uint64_t const end = std::min(begin + chunk_photons, chunks.range.count);
        for (std::uint64_t photon = begin; photon < end; ++photon) {
            walk.trace(chunks.range.first + photon);
        }
        watch.photons.fetch_add(end - begin, std::memory_order_relaxed);
    }
    walk.flush();
    return walk.balance();
}

} // namespace

Balance &Balance::operator+=(const Balance &other) {
    photons += other.photons;
    emitted += other.emitted;
    stored += other.stored;
    stored_front += other.stored_front;
    front_square += other.front_square;
    back_square += other.back_square;
    absorbed += other.absorbed;
    lost += other.lost;
    roulette += other.roulette;
    return *this;
}

Tracer::Tracer(const Scene &scene, std::span<const Surface> surfaces, const Source &source, const Frame &lab_axes,
               const Trace_settings &settings)
    : scene_(scene), surfaces_(surfaces), source_(source), lab_axes_(lab_axes), settings_(settings) {}

Balance Tracer::trace(const Photon_range &range, unsigned threads, Hit_sink &sink, Watch &watch) const {
    Trace_scene const run{scene_, surfaces_, source_, lab_axes_, settings_};
    Chunks chunks{range};
    struct Outcome {
        Balance balance;
        std::exception_ptr failure;
    };
    std::vector<Outcome> outcomes(std::max(threads, 1U));
    auto const worker = [&](unsigned number) {
        try {
            outcomes[number].balance = settings_.polarised ? work<true>(run, chunks, sink, number, watch)
                                                           : work<false>(run, chunks, sink, number, watch);
        } catch (...) {
            outcomes[number].failure = std::current_exception();
            chunks.failed = true;
        }
    };
    {
        // The caller's thread is worker 0; the others are joined at the end of this block.
        std::vector<std::jthread> others;
        for (unsigned number = 1; number < outcomes.size(); ++number) {
            others.emplace_back(worker, number);
        }
        worker(0);
    }
    Balance balance;
    for (const Outcome &outcome : outcomes) {
        if (outcome.failure) {
            std::rethrow_exception(outcome.failure);
        }
        balance += outcome.balance;
    }
    return balance;
}

} // namespace gonio::sim
