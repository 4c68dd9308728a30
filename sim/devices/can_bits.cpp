// can_bits.cpp: the length of a classic CAN frame on the wire, by tables over whole bytes.
#include "can_bits.hpp"

#include <array>
#include <cstdint>

namespace gonio::sim {
namespace {

// CRC-15 of CAN: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
constexpr unsigned crc_polynomial = 0x4599;

constexpr std::array<std::uint16_t, 256> make_crc_table() {
    std::array<std::uint16_t, 256> table{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned crc = byte << 7U;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 0x4000U) != 0 ? (crc << 1U) ^ crc_polynomial : crc << 1U;
        }
        table[byte] = static_cast<std::uint16_t>(crc & 0x7FFFU);
    }
    return table;
}

// After five equal bits a stuff bit of the other sort follows, and counts as the first of the next run.
// State: bit value * 5 + (run length - 1), run length 1..4 after a bit and its stuff bit.
struct Stuffing {
    std::uint8_t state;
    std::uint8_t stuff_bits;
};

constexpr Stuffing stuff_bit(std::uint8_t state, unsigned bit) {
    const unsigned last = state / 5U;
    const unsigned run = bit == last ? state % 5U + 2U : 1U;
    if (run == 5) {
        return {static_cast<std::uint8_t>((1U - bit) * 5U), 1};
    }
    return {static_cast<std::uint8_t>(bit * 5U + run - 1U), 0};
}

using Stuffing_table = std::array<std::array<Stuffing, 256>, 10>;

constexpr Stuffing_table make_stuffing_table() {
    Stuffing_table table{};
    for (std::uint8_t start = 0; start < 10; ++start) {
        for (unsigned byte = 0; byte < 256; ++byte) {
            Stuffing total{start, 0};
            for (int bit = 7; bit >= 0; --bit) {
                const Stuffing next = stuff_bit(total.state, (byte >> bit) & 1U);
                total = {next.state, static_cast<std::uint8_t>(total.stuff_bits + next.stuff_bits)};
            }
            table[start][byte] = total;
        }
    }
    return table;
}

constexpr std::array<std::uint16_t, 256> crc_table = make_crc_table();
constexpr Stuffing_table stuffing_table = make_stuffing_table();

} // namespace

unsigned can_frame_bits(const gn_can_frame &frame) {
    // Start of frame, identifier, RTR, IDE, r0 (all dominant), data length code: 19 bits.
    const std::uint32_t header = (frame.id & 0x7FFU) << 7U | (frame.length & 0xFU);
    unsigned crc = 0;
    const auto feed = [&crc](unsigned byte) {
        crc = ((crc << 8U) ^ crc_table[((crc >> 7U) ^ byte) & 0xFFU]) & 0x7FFFU;
    };
    feed(header >> 16U); // the leading zero bits do not change the CRC
    feed((header >> 8U) & 0xFFU);
    feed(header & 0xFFU);
    for (unsigned k = 0; k < frame.length; ++k) {
        feed(frame.data[k]);
    }

    // The first two bits by themselves; the other 17 + 8 n + 15 are whole bytes.
    Stuffing run{0, 0}; // start of frame: one dominant bit
    run = stuff_bit(run.state, (header >> 17U) & 1U);
    unsigned stuff_bits = 0;
    const auto pass = [&](unsigned byte) {
        const Stuffing next = stuffing_table[run.state][byte & 0xFFU];
        run.state = next.state;
        stuff_bits += next.stuff_bits;
    };
    pass(header >> 9U);
    pass(header >> 1U);
    unsigned carried = header & 1U;
    for (unsigned k = 0; k < frame.length; ++k) {
        pass(carried << 7U | frame.data[k] >> 1U);
        carried = frame.data[k] & 1U;
    }
    pass(carried << 7U | crc >> 8U);
    pass(crc);

    constexpr unsigned fixed_bits = 19 + 15 + 1 + 2 + 7; // header, CRC, its delimiter, acknowledge, end of frame
    return fixed_bits + 8U * frame.length + stuff_bits;
}

} // namespace gonio::sim
