// bench.hpp: a test bench: a bus, drives, and a commissioning tool that speaks SDO, NMT, SYNC and PDOs to them.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "drive.hpp"
#include "object_dictionary.hpp"

namespace gonio::sim {

constexpr std::int64_t ns_per_ms = 1'000'000;

inline gn_can_frame make_frame(std::uint32_t id, const std::vector<std::uint8_t> &data) {
    gn_can_frame frame{};
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data);
    return frame;
}

class Recorder : public Can_node {
public:
    void on_frame(const gn_can_frame &frame) override { frames.push_back(frame); }
    std::vector<gn_can_frame> frames;
};

class Bench {
public:
    static Drive_config standard(std::uint8_t node = 1, const std::string &personality = "full") {
        Drive_config config;
        config.node = node;
        config.personality = personality;
        config.eds_directory = GONIO_SOURCE_DIR "/protocol/eds";
        return config;
    }

    Bench() : bus(scheduler, 1'000'000), tool_(bus.attach(recorder)) {}
    explicit Bench(const Drive_config &config) : Bench() {
        add(config);
        run_ms(100);
    }

    Drive &add(const Drive_config &config) {
        drives.push_back(std::make_unique<Drive>(scheduler, bus, config));
        return *drives.back();
    }
    Drive &drive() { return *drives.front(); }

    void run_until(std::int64_t time_ns) {
        while (scheduler.run_one(time_ns)) {
        }
    }
    void run_ms(double duration_ms) {
        run_until(scheduler.now_ns() + static_cast<std::int64_t>(duration_ms * ns_per_ms));
    }
    void send(std::uint32_t id, const std::vector<std::uint8_t> &data) { bus.send(tool_, make_frame(id, data)); }
    void nmt(std::uint8_t command, std::uint8_t node = 0) {
        send(0, {command, node});
        run_ms(1);
    }

    // One raw exchange; an empty vector if no answer came within 20 ms.
    std::vector<std::uint8_t> exchange(const std::vector<std::uint8_t> &request, std::uint8_t node = 1) {
        const std::size_t before = recorder.frames.size();
        send(0x600U + node, request);
        run_ms(20);
        for (std::size_t k = before; k < recorder.frames.size(); ++k) {
            if (recorder.frames[k].id == 0x580U + node) {
                return {recorder.frames[k].data, recorder.frames[k].data + 8};
            }
        }
        return {};
    }
    static std::uint32_t abort_of(const std::vector<std::uint8_t> &answer) {
        if (answer.size() != 8) {
            throw std::runtime_error("no answer from the SDO server");
        }
        return answer[0] == 0x80 ? static_cast<std::uint32_t>(value_from_bytes(&answer[4], 4, false)) : 0;
    }
    // Expedited download; the abort code, or 0.
    std::uint32_t write(std::uint16_t index, std::uint8_t subindex, std::int64_t value, unsigned size,
                        std::uint8_t node = 1) {
        std::vector<std::uint8_t> request{static_cast<std::uint8_t>(0x23U | (4U - size) << 2U),
                                          static_cast<std::uint8_t>(index),
                                          static_cast<std::uint8_t>(index >> 8U),
                                          subindex,
                                          0,
                                          0,
                                          0,
                                          0};
        value_to_bytes(value, &request[4], size);
        return abort_of(exchange(request, node));
    }
    std::vector<std::uint8_t> upload(std::uint16_t index, std::uint8_t subindex, std::uint8_t node = 1) {
        return exchange(
            {0x40, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8U), subindex, 0, 0, 0, 0},
            node);
    }
    std::uint32_t read_abort(std::uint16_t index, std::uint8_t subindex, std::uint8_t node = 1) {
        return abort_of(upload(index, subindex, node));
    }
    std::int64_t read(std::uint16_t index, std::uint8_t subindex = 0, std::uint8_t node = 1) {
        const auto answer = upload(index, subindex, node);
        if (abort_of(answer) != 0 || (answer[0] & 0xE3U) != 0x43U) {
            throw std::runtime_error("no expedited upload of object " + std::to_string(index));
        }
        return value_from_bytes(&answer[4], 4U - (answer[0] >> 2U & 3U), true);
    }

    // The cycle of the firmware: RPDO 1 = controlword + target, TPDO 1 = statusword + position, both at every SYNC.
    void map_cycle(std::uint8_t node = 1) {
        const std::array<std::uint32_t, 8> codes{write(0x1400, 1, 0x80000200 + node, 4, node),
                                                 write(0x1600, 0, 0, 1, node),
                                                 write(0x1600, 1, 0x60400010, 4, node),
                                                 write(0x1600, 2, 0x607A0020, 4, node),
                                                 write(0x1600, 0, 2, 1, node),
                                                 write(0x1400, 2, 1, 1, node),
                                                 write(0x1400, 1, 0x200 + node, 4, node),
                                                 write(0x1800, 1, 0xC0000180 + node, 4, node)};
        const std::array<std::uint32_t, 6> more{
            write(0x1A00, 0, 0, 1, node),          write(0x1A00, 1, 0x60410010, 4, node),
            write(0x1A00, 2, 0x60640020, 4, node), write(0x1A00, 0, 2, 1, node),
            write(0x1800, 2, 1, 1, node),          write(0x1800, 1, 0x40000180 + node, 4, node)};
        for (const std::uint32_t code : codes) {
            if (code != 0) {
                throw std::runtime_error("the drive refuses the cycle's RPDO");
            }
        }
        for (const std::uint32_t code : more) {
            if (code != 0) {
                throw std::runtime_error("the drive refuses the cycle's TPDO");
            }
        }
    }
    void set_point(std::uint16_t controlword, std::int32_t target_counts, std::uint8_t node = 1) {
        std::vector<std::uint8_t> data(6);
        value_to_bytes(controlword, data.data(), 2);
        value_to_bytes(target_counts, &data[2], 4);
        send(0x200U + node, data);
    }
    // SYNC (and what the drives answer) takes up the cycle of 2 ms.
    void cycle(std::uint16_t controlword, std::int32_t target_counts, std::uint8_t node = 1) {
        send(0x80, {});
        set_point(controlword, target_counts, node);
        run_ms(2);
    }
    // Pre-operational to operation enabled in mode 8 at the position where the axis stands.
    void enable(std::uint8_t node = 1) {
        map_cycle(node);
        write(0x6060, 0, 8, 1, node);
        nmt(0x01, node);
        const auto here = static_cast<std::int32_t>(read(0x6064, 0, node));
        for (const std::uint16_t controlword : {0x06, 0x07, 0x0F}) {
            for (int k = 0; k < 3; ++k) {
                cycle(controlword, here, node);
            }
        }
    }
    std::uint16_t statusword(std::uint8_t node = 1) { return static_cast<std::uint16_t>(read(0x6041, 0, node)); }

    // Emergency codes sent by the node so far, oldest first.
    std::vector<std::uint16_t> emergencies(std::uint8_t node = 1) const {
        std::vector<std::uint16_t> codes;
        for (const gn_can_frame &frame : recorder.frames) {
            if (frame.id == 0x80U + node) {
                codes.push_back(static_cast<std::uint16_t>(value_from_bytes(frame.data, 2, false)));
            }
        }
        return codes;
    }
    std::vector<gn_can_frame> frames_with(std::uint32_t id) const {
        std::vector<gn_can_frame> found;
        for (const gn_can_frame &frame : recorder.frames) {
            if (frame.id == id) {
                found.push_back(frame);
            }
        }
        return found;
    }

    Scheduler scheduler;
    Can_bus bus;
    Recorder recorder;
    std::vector<std::unique_ptr<Drive>> drives;

private:
    int tool_;
};

// Statusword without the mode's own bits.
inline std::uint16_t state_bits(std::uint16_t statusword) {
    return statusword & 0x6FU;
}

} // namespace gonio::sim
