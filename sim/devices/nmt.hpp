// nmt.hpp: network management of one node: its state, the heartbeat it produces and the heartbeats it watches.
#pragma once

#include <array>
#include <cstdint>

#include "can.h"
#include "object_dictionary.hpp"

namespace gonio::sim {

enum class Nmt_state : std::uint8_t { initialising = 0, stopped = 4, operational = 5, pre_operational = 127 };

enum class Nmt_command : std::uint8_t {
    start = 0x01,
    stop = 0x02,
    enter_pre_operational = 0x80,
    reset_node = 0x81,
    reset_communication = 0x82,
};

class Heartbeat_producer {
public:
    Heartbeat_producer(Object_dictionary &dictionary, std::uint8_t node);
    // Whether one is due (0x1017; 0 = none); the first comes one period after the boot-up or the change of 0x1017.
    bool due(std::int64_t now_ns);
    void restart(std::int64_t now_ns) { last_ns_ = now_ns; }
    [[nodiscard]] gn_can_frame frame(Nmt_state state) const;

private:
    const Od_entry &period_ms_;
    std::uint8_t node_;
    std::int64_t last_ns_ = 0;
};

// Consumer (0x1016): watching begins with a producer's first heartbeat.
class Heartbeat_consumer {
public:
    explicit Heartbeat_consumer(Object_dictionary &dictionary);
    // 0x0604 0043 if the same producer is watched twice.
    static std::uint32_t check_write(Object_dictionary &dictionary, const Od_entry &entry, std::int64_t value);
    void refresh();

    // A heartbeat came; true if its producer had been lost.
    bool receive(std::uint8_t producer, std::int64_t now_ns);
    // The node id of a producer that is silent for too long, once per loss; 0: none.
    std::uint8_t lost(std::int64_t now_ns);

private:
    struct Watched {
        std::uint8_t producer = 0;
        std::int64_t timeout_ns = 0;
        std::int64_t last_ns = 0;
        bool alive = false;
        bool lost = false;
    };
    Object_dictionary &dictionary_;
    std::array<Watched, 2> watched_{};
};

} // namespace gonio::sim
