// scripted_drive.hpp: a drive made of a dictionary and a few rules. It has no inertia and no delays: those are the
// twin's.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "scripted_can.hpp"

namespace gonio::test {

enum class Access { read_write, read_only };

struct Object {
    std::uint32_t value = 0;
    int size = 4;
    Access access = Access::read_write;
    bool sticks = true;                 // false: writes are accepted and ignored
    std::uint32_t refusal = 0x06010002; // abort code of a refused write
};

class Scripted_drive {
public:
    explicit Scripted_drive(std::uint32_t node_id) : node(node_id) {
        auto add = [this](int index, int sub, std::uint32_t value, int size) { objects[{index, sub}] = {value, size}; };
        add(0x1000, 0, 0x00040192, 4);
        for (int sub = 1; sub <= 4; sub++) {
            add(0x1018, sub, 0x1000u * static_cast<std::uint32_t>(sub) + node, 4);
        }
        add(0x608F, 1, 400000, 4);
        add(0x608F, 2, 1, 4);
        for (auto [index, sub, size] : std::initializer_list<std::array<int, 3>>{
                 {0x1017, 0, 2}, {0x1016, 1, 4}, {0x1029, 1, 1}, {0x1400, 2, 1}, {0x1400, 5, 2}, {0x1600, 0, 1},
                 {0x1600, 1, 4}, {0x1600, 2, 4}, {0x1800, 2, 1}, {0x1A00, 0, 1}, {0x1A00, 1, 4}, {0x1A00, 2, 4},
                 {0x1007, 0, 4}, {0x1019, 0, 1}, {0x6007, 0, 2}, {0x605A, 0, 2}, {0x6085, 0, 4}, {0x607D, 1, 4},
                 {0x607D, 2, 4}, {0x6066, 0, 2}, {0x60C2, 1, 1}, {0x60C2, 2, 1}, {0x6081, 0, 4}, {0x6083, 0, 4},
                 {0x6084, 0, 4}, {0x607C, 0, 4}, {0x6098, 0, 1}, {0x6099, 1, 4}, {0x6099, 2, 4}, {0x609A, 0, 4},
                 {0x60FE, 1, 4}, {0x60FE, 2, 4}, {0x6060, 0, 1}, {0x6061, 0, 1}}) {
            add(index, sub, 0, size);
        }
        add(0x1400, 1, 0x200 + node, 4);
        add(0x1800, 1, 0x40000180 + node, 4);
        add(0x6065, 0, 0xFFFFFFFF, 4); // off by default
    }

    // Second personality: no 0x6007, no 0x1029, 0x60C2 read only.
    void make_plain(std::uint32_t units, int exponent) {
        objects.erase({0x6007, 0});
        objects.erase({0x1029, 1});
        objects[{0x60C2, 1}] = {units, 1, Access::read_only};
        objects[{0x60C2, 2}] = {static_cast<std::uint8_t>(exponent), 1, Access::read_only};
    }
    // Third personality: the maps cannot be written.
    void make_fixed(const std::vector<std::uint32_t> &rpdo, const std::vector<std::uint32_t> &tpdo,
                    std::uint32_t refusal) {
        for (const auto &[index, map] : {std::pair{0x1600, rpdo}, std::pair{0x1A00, tpdo}}) {
            objects[{index, 0}] = {static_cast<std::uint32_t>(map.size()), 1, Access::read_only, true, refusal};
            for (std::size_t i = 0; i < map.size(); i++) {
                objects[{index, static_cast<int>(i) + 1}] = {map[i], 4, Access::read_only, true, refusal};
            }
        }
    }

    // What the drive says to one frame on the bus.
    std::vector<gn_can_frame> on_frame(const gn_can_frame &frame) {
        if (silent) {
            return {};
        }
        if (frame.id == 0x000 && frame.data[1] == node) {
            return on_nmt(frame.data[0]);
        }
        if (frame.id == 0x600 + node) {
            return {on_sdo(frame)};
        }
        if (frame.id == 0x200 + node && operational) {
            on_rpdo(frame);
        }
        if (frame.id == 0x080 && operational) {
            return on_sync();
        }
        return {};
    }
    gn_can_frame heartbeat() const { return frame_of(0x700 + node, {operational ? 0x05 : 0x7F}); }
    gn_can_frame emergency(int code) const {
        return frame_of(0x080 + node, {code & 0xFF, code >> 8, 0x20, 0, 0, 0, 0, 0});
    }

    std::uint32_t node;
    std::map<std::pair<int, int>, Object> objects;
    bool silent = false;
    bool operational = false;
    bool blocked = false;       // does not follow
    bool homing_fails = false;  // statusword bit 13
    bool homing_stalls = false; // never attained
    bool torque = true;
    std::uint16_t controlword = 0;
    std::uint16_t status = 0x0040;
    std::int32_t position = 5000;
    std::vector<std::uint16_t> controlwords; // each change
    int homing_cycles = 0;

private:
    std::vector<gn_can_frame> on_nmt(int command) {
        if (command == 0x82 || command == 0x81) {
            operational = false;
            status = torque ? 0x0040 : 0x0008;
            return {frame_of(0x700 + node, {0x00})};
        }
        operational = command == 0x01;
        return {heartbeat()};
    }

    gn_can_frame on_sdo(const gn_can_frame &request) {
        const std::uint8_t *d = request.data;
        int const index = d[1] | d[2] << 8;
        auto answer = [&](int command, std::uint32_t value) {
            return frame_of(0x580 + node, {command, d[1], d[2], d[3], static_cast<int>(value & 0xFF),
                                           static_cast<int>(value >> 8 & 0xFF), static_cast<int>(value >> 16 & 0xFF),
                                           static_cast<int>(value >> 24)});
        };
        auto const found = objects.find({index, d[3]});
        if (found == objects.end()) {
            bool const known = objects.lower_bound({index, 0}) != objects.end() &&
                               objects.lower_bound({index, 0})->first.first == index;
            return answer(0x80, known ? 0x06090011 : 0x06020000);
        }
        Object &object = found->second;
        if (d[0] == 0x40) {
            return answer(0x43 | (4 - object.size) << 2, object.value);
        }
        if (object.access == Access::read_only) {
            return answer(0x80, object.refusal);
        }
        if ((d[0] >> 2 & 3) != 4 - object.size) {
            return answer(0x80, 0x06070010);
        }
        if (object.sticks) {
            object.value = d[4] | d[5] << 8 | d[6] << 16 | static_cast<std::uint32_t>(d[7]) << 24;
        }
        objects[{0x6061, 0}].value = objects[{0x6060, 0}].value;
        return answer(0x60, 0);
    }

    // Byte offset of a mapped object, or -1.
    int offset(int map, int index) const {
        int at = 0;
        for (std::uint32_t sub = 1; sub <= objects.at({map, 0}).value; sub++) {
            std::uint32_t const entry = objects.at({map, static_cast<int>(sub)}).value;
            if (static_cast<int>(entry >> 16) == index) {
                return at;
            }
            at += static_cast<int>(entry & 0xFF) / 8;
        }
        return -1;
    }

    void on_rpdo(const gn_can_frame &frame) {
        const std::uint8_t *c = frame.data + offset(0x1600, 0x6040);
        const std::uint8_t *t = frame.data + offset(0x1600, 0x607A);
        pending_control_ = static_cast<std::uint16_t>(c[0] | c[1] << 8);
        pending_target_ =
            static_cast<std::int32_t>(t[0] | t[1] << 8 | t[2] << 16 | static_cast<std::uint32_t>(t[3]) << 24);
        if (offset(0x1600, 0x6060) >= 0) {
            objects[{0x6061, 0}].value = frame.data[offset(0x1600, 0x6060)];
        }
    }

    // Synchronous: the last RPDO takes effect, then the TPDO is latched.
    std::vector<gn_can_frame> on_sync() {
        step_state();
        int const mode = static_cast<std::int8_t>(objects[{0x6061, 0}].value);
        bool const enabled = (status & 0x6F) == 0x27;
        status &= 0x00FF;
        if (mode == 6 && enabled) {
            home();
        } else if (mode == 8 && enabled && !blocked) {
            position = pending_target_;
        } else if (mode == 8 && enabled &&
                   std::abs(position - pending_target_) > static_cast<std::int64_t>(objects[{0x6065, 0}].value)) {
            status |= 0x2000;
        }
        gn_can_frame frame = frame_of(0x180 + node, {});
        for (std::uint32_t sub = 1; sub <= objects[{0x1A00, 0}].value; sub++) {
            std::uint32_t const entry = objects[{0x1A00, static_cast<int>(sub)}].value;
            std::uint32_t value = 0;
            value = entry >> 16 == 0x6041 ? status : value;
            value = entry >> 16 == 0x6064 ? static_cast<std::uint32_t>(position) : value;
            value = entry >> 16 == 0x6061 ? objects[{0x6061, 0}].value : value;
            for (std::uint32_t i = 0; i < (entry & 0xFF) / 8; i++) {
                frame.data[frame.length++] = static_cast<std::uint8_t>(value >> 8 * i);
            }
        }
        return {frame};
    }

    void home() {
        if (!(pending_control_ & 0x10)) {
            homing_cycles = 0;
        } else if (++homing_cycles < 20 || homing_stalls) {
            position -= 50;
        } else if (homing_fails) {
            status |= 0x2000;
        } else {
            position = homing_cycles == 20 ? 0 : position;
            status |= 0x1400;
        }
    }

    void step_state() {
        std::uint16_t const word = pending_control_;
        if (word != controlword) {
            controlwords.push_back(word);
        }
        bool const reset = (word & 0x80) != 0 && (controlword & 0x80) == 0;
        controlword = word;
        std::uint16_t const state = status & 0x6F;
        if (!torque) {
            status = state == 0x27 || state == 0x07 ? 0x0008 : status;
        }
        if ((status & 0x4F) == 0x08) {
            status = reset && torque ? 0x0040 : status;
        } else if ((word & 0x02) == 0) {
            status = 0x0040; // disable voltage
        } else if ((word & 0x04) == 0) {
            status = state == 0x27 || state == 0x07 ? 0x0007 : 0x0040; // quick stop, 0x605A = 6
        } else if (state == 0x40 || state == 0x60) {
            status = (word & 0x07) == 0x06 ? 0x0021 : 0x0040;
        } else if (state == 0x21) {
            status = (word & 0x0F) == 0x07 ? 0x0023 : 0x0021;
        } else if (state == 0x23) {
            status = (word & 0x0F) == 0x0F ? 0x0027 : (word & 0x07) == 0x06 ? 0x0021 : 0x0023;
        } else if (state == 0x27) {
            status = (word & 0x07) == 0x06 ? 0x0021 : (word & 0x08) == 0 ? 0x0023 : 0x0027;
        }
    }

    std::uint16_t pending_control_ = 0;
    std::int32_t pending_target_ = 0;
};

} // namespace gonio::test
