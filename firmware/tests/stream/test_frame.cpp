// test_frame.cpp: frames are found in any chunking of the stream, and refused as soon as their bytes are wrong.
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "frame.h"
}

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes frame(std::uint32_t kind, std::uint32_t sequence, const Bytes &payload) {
    Bytes bytes(GN_FRAME_HEADER_SIZE);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    gn_frame_begin(bytes.data(), kind, sequence, static_cast<std::uint32_t>(payload.size()));
    gn_frame_seal(bytes.data(), 77);
    return bytes;
}

struct Decoded {
    std::vector<Bytes> frames;
    gn_frame_error error = GN_FRAME_GOOD;
    std::size_t taken = 0; // bytes before the refusal
};

Decoded decode(const Bytes &stream, std::size_t chunk) {
    auto decoder = std::make_unique<gn_frame_decoder>();
    gn_frame_decoder_reset(decoder.get());
    Decoded result;
    while (result.taken < stream.size()) {
        std::size_t taken = 0;
        std::size_t const length = std::min(chunk, stream.size() - result.taken);
        auto const progress = gn_frame_decode(decoder.get(), stream.data() + result.taken, length, &taken);
        result.taken += taken;
        if (progress == GN_FRAME_COMPLETE) {
            result.frames.emplace_back(decoder->bytes, decoder->bytes + decoder->filled);
        } else if (progress == GN_FRAME_REFUSED) {
            result.error = decoder->error;
            break;
        }
    }
    return result;
}

TEST(Frame, every_chunking_gives_the_same_frames) {
    std::vector<Bytes> const sent = {frame(GN_FRAME_REQUEST, 1, {1, 2, 3}), frame(GN_FRAME_ALIVE, 0, {}),
                                     frame(GN_FRAME_KNOTS, 2, Bytes(1000, 0xA5)),
                                     frame(GN_FRAME_REQUEST, 3, Bytes(GN_FRAME_PAYLOAD_MAX, 0x11))};
    Bytes stream;
    for (auto const &bytes : sent) {
        stream.insert(stream.end(), bytes.begin(), bytes.end());
    }
    for (std::size_t const chunk : {1u, 2u, 3u, 19u, 20u, 21u, 1023u, 70000u}) {
        Decoded const decoded = decode(stream, chunk);
        EXPECT_EQ(decoded.error, GN_FRAME_GOOD);
        EXPECT_EQ(decoded.frames, sent) << chunk;
    }
}

TEST(Frame, each_error_is_named_and_found_where_it_shows) {
    Bytes const good = frame(GN_FRAME_REQUEST, 1, {1, 2, 3, 4});
    struct Case {
        std::size_t byte;
        std::uint8_t value;
        gn_frame_error error;
        std::size_t found_after;
    };
    for (Case const &one :
         {Case{0, 0x48, GN_FRAME_BAD_MAGIC, 4}, Case{1, 0, GN_FRAME_BAD_MAGIC, 4}, Case{2, 2, GN_FRAME_BAD_VERSION, 4},
          Case{3, 0, GN_FRAME_BAD_KIND, 4}, Case{3, 10, GN_FRAME_BAD_KIND, 4}, Case{14, 2, GN_FRAME_BAD_LENGTH, 20},
          Case{16, static_cast<std::uint8_t>(good[16] ^ 1), GN_FRAME_BAD_CRC, 24}, Case{4, 2, GN_FRAME_BAD_CRC, 24},
          Case{23, 5, GN_FRAME_BAD_CRC, 24}}) {
        Bytes bytes = good;
        bytes[one.byte] = one.value;
        for (std::size_t const chunk : {1u, 100u}) {
            Decoded const decoded = decode(bytes, chunk);
            EXPECT_EQ(decoded.error, one.error) << "byte " << one.byte;
            EXPECT_EQ(decoded.taken, one.found_after) << "byte " << one.byte;
            EXPECT_TRUE(decoded.frames.empty());
        }
    }
}

TEST(Frame, every_single_bit_flip_is_refused_or_waits_for_more) {
    Bytes const good = frame(GN_FRAME_EVENT, 9, {10, 20, 30});
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1u << (bit % 8)));
        EXPECT_TRUE(decode(bytes, 7).frames.empty()) << bit;
    }
}

TEST(Frame, a_refused_stream_stays_refused) {
    gn_frame_decoder decoder;
    gn_frame_decoder_reset(&decoder);
    Bytes const bad = {'G', 'E', 'T', ' '};
    std::size_t taken = 0;
    EXPECT_EQ(gn_frame_decode(&decoder, bad.data(), bad.size(), &taken), GN_FRAME_REFUSED);
    Bytes const good = frame(GN_FRAME_ALIVE, 0, {});
    EXPECT_EQ(gn_frame_decode(&decoder, good.data(), good.size(), &taken), GN_FRAME_REFUSED);
    EXPECT_EQ(taken, 0u);
    gn_frame_decoder_reset(&decoder);
    EXPECT_EQ(gn_frame_decode(&decoder, good.data(), good.size(), &taken), GN_FRAME_COMPLETE);
}

} // namespace
