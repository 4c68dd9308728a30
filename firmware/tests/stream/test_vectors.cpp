// test_vectors.cpp: the golden bytes of protocol/vectors, decoded and, where they are frames, made again.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "bench_client.hpp"

extern "C" {
#include "digitiser_packets.h"
}

namespace {

using gonio::test::Bytes;
using gonio::test::Frame;

const toml::table &file(const std::string &name) {
    static std::map<std::string, toml::table> files;
    auto found = files.find(name);
    if (found == files.end()) {
        auto const root = std::filesystem::path(__FILE__).parent_path() / "../../..";
        found = files.emplace(name, toml::parse_file((root / "protocol/vectors" / name).string())).first;
    }
    return found->second;
}

std::vector<const toml::table *> vectors(const std::string &name) {
    std::vector<const toml::table *> found;
    for (auto const &node : *file(name)["vector"].as_array()) {
        found.push_back(node.as_table());
    }
    return found;
}

template <typename Value> Value value(const toml::table &table, std::string_view key) {
    std::optional<Value> const found = table[key].value<Value>();
    if (!found) {
        throw std::runtime_error("no such field: " + std::string(key));
    }
    return *found;
}

Bytes bytes_of(const toml::table &vector) {
    Bytes bytes;
    std::istringstream words(value<std::string>(vector, "hex"));
    for (std::string word; words >> word;) {
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
    }
    return bytes;
}

template <typename Number> void expect(const toml::table &fields, const char *key, Number found) {
    if constexpr (std::is_floating_point_v<Number>) {
        EXPECT_EQ(value<double>(fields, key), static_cast<double>(found)) << key;
    } else {
        EXPECT_EQ(value<std::int64_t>(fields, key), static_cast<std::int64_t>(found)) << key;
    }
}

// An unaligned array of a packed record, element by element.
template <typename Number> void expect_four(const toml::table &fields, const char *key, const void *found) {
    const toml::array &array = *fields[key].as_array();
    ASSERT_EQ(array.size(), 4u) << key;
    for (std::size_t i = 0; i < 4; ++i) {
        Number number{};
        std::memcpy(&number, static_cast<const char *>(found) + i * sizeof number, sizeof number);
        EXPECT_EQ(array[i].value<Number>(), number) << key << " " << i;
    }
}

void expect_sample(const toml::table &fields, const gn_sample &sample) {
    expect(fields, "high_counts", std::int32_t{sample.high_counts});
    expect(fields, "low_counts", std::int32_t{sample.low_counts});
    expect(fields, "monitor_counts", std::int32_t{sample.monitor_counts});
    expect(fields, "temperature_centi_c", std::int16_t{sample.temperature_centi_c});
    expect(fields, "flags", std::uint16_t{sample.flags});
}

void expect_samples(const toml::table &fields, const Frame &frame) {
    auto const block = frame.record<gn_sample_block>();
    expect(fields, "first_sample", std::uint64_t{block.first_sample});
    expect(fields, "first_time_ns", std::int64_t{block.first_time_ns});
    expect(fields, "period_ns", double{block.period_ns});
    expect(fields, "block", std::uint32_t{block.block});
    expect(fields, "count", std::uint32_t{block.count});
    expect(fields, "samples_lost", std::uint32_t{block.samples_lost});
    expect(fields, "strobes_lost", std::uint32_t{block.strobes_lost});
    expect(fields, "residual_ns", float{block.residual_ns});
    expect(fields, "window", std::uint32_t{block.window});
    expect(fields, "flags", std::uint32_t{block.flags});
    const toml::array &samples = *fields["samples"].as_array();
    ASSERT_EQ(frame.payload.size(), GN_SAMPLE_BLOCK_SIZE + samples.size() * GN_SAMPLE_SIZE);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        expect_sample(*samples[i].as_table(), frame.record<gn_sample>(GN_SAMPLE_BLOCK_SIZE + i * GN_SAMPLE_SIZE));
    }
}

void expect_poses(const toml::table &fields, const Frame &frame) {
    auto const block = frame.record<gn_pose_block>();
    expect(fields, "block", std::uint32_t{block.block});
    expect(fields, "count", std::uint32_t{block.count});
    expect(fields, "axis_count", std::uint32_t{block.axis_count});
    expect(fields, "sync_stamp_sigma_us", float{block.sync_stamp_sigma_us});
    const toml::array &poses = *fields["poses"].as_array();
    ASSERT_EQ(frame.payload.size(), GN_POSE_BLOCK_SIZE + poses.size() * GN_POSE_SIZE);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        auto const pose = frame.record<gn_pose>(GN_POSE_BLOCK_SIZE + i * GN_POSE_SIZE);
        const toml::table &one = *poses[i].as_table();
        expect(one, "sync_time_ns", std::int64_t{pose.sync_time_ns});
        expect(one, "sync_number", std::uint32_t{pose.sync_number});
        expect_four<std::int32_t>(one, "position_counts", pose.position_counts);
        expect(one, "valid", pose.valid);
        expect(one, "flags", pose.flags);
    }
}

void expect_knots(const toml::table &fields, const Frame &frame) {
    auto const block = frame.record<gn_knot_block>();
    expect(fields, "path_id", std::uint32_t{block.path_id});
    expect(fields, "first_knot", std::uint32_t{block.first_knot});
    expect(fields, "count", std::uint32_t{block.count});
    const toml::array &knots = *fields["knots"].as_array();
    ASSERT_EQ(frame.payload.size(), GN_KNOT_BLOCK_SIZE + knots.size() * GN_KNOT_SIZE);
    for (std::size_t i = 0; i < knots.size(); ++i) {
        auto const knot = frame.record<gn_knot>(GN_KNOT_BLOCK_SIZE + i * GN_KNOT_SIZE);
        const toml::table &one = *knots[i].as_table();
        expect(one, "time_ns", std::int64_t{knot.time_ns});
        expect_four<double>(one, "position_counts", knot.position_counts);
        expect_four<double>(one, "velocity_counts_per_s", knot.velocity_counts_per_s);
        expect_four<double>(one, "acceleration_counts_per_s2", knot.acceleration_counts_per_s2);
    }
}

void expect_hello(const toml::table &fields, const Frame &frame) {
    gonio_Hello const hello = frame.hello();
    EXPECT_EQ(hello.schema_hash, std::stoull(value<std::string>(fields, "schema_hash"), nullptr, 16));
    EXPECT_EQ(hello.session_id, std::stoull(value<std::string>(fields, "session_id"), nullptr, 16));
    EXPECT_EQ(value<std::string>(fields, "software"), hello.software);
    EXPECT_EQ(fields["refusal"].value_or(std::string()), hello.refusal);
    expect(fields, "role", static_cast<int>(hello.role));
    expect(fields, "last_sequence", hello.last_sequence);
    EXPECT_EQ(gonio::test::Client::encoded(gonio_Hello_fields, hello), frame.payload);
}

void expect_request(const toml::table &fields, const Frame &frame) {
    auto const request = frame.as<gonio_Request>(gonio_Request_fields);
    auto const body = value<std::string>(fields, "body");
    expect(fields, "id", request.id);
    if (body == "acquire") {
        ASSERT_EQ(request.which_body, gonio_Request_acquire_tag);
        EXPECT_EQ(value<bool>(fields, "on"), request.body.acquire.on);
    } else if (body == "motion_begin") {
        ASSERT_EQ(request.which_body, gonio_Request_motion_begin_tag);
        expect(fields, "path_id", request.body.motion_begin.path_id);
        expect(fields, "knot_count", request.body.motion_begin.knot_count);
        EXPECT_EQ(value<bool>(fields, "start"), request.body.motion_begin.start);
    } else {
        EXPECT_EQ(body, "get_info");
        EXPECT_EQ(request.which_body, gonio_Request_get_info_tag);
    }
    EXPECT_EQ(gonio::test::Client::encoded(gonio_Request_fields, request), frame.payload);
}

void expect_reply(const toml::table &fields, const Frame &frame) {
    gonio_Reply const reply = frame.reply();
    expect(fields, "id", reply.id);
    expect(fields, "code", static_cast<int>(reply.code));
    EXPECT_EQ(value<std::string>(fields, "text"), reply.text);
    EXPECT_EQ(gonio::test::Client::encoded(gonio_Reply_fields, reply), frame.payload);
}

void expect_status(const toml::table &fields, const Frame &frame) {
    gonio_Event const event = frame.event();
    ASSERT_EQ(event.which_body, gonio_Event_status_tag);
    gonio_Status const &status = event.body.status;
    expect(fields, "time_ns", event.time_ns);
    expect(fields, "state", static_cast<int>(status.state));
    expect(fields, "path_id", status.path_id);
    expect(fields, "path_time_ns", status.path_time_ns);
    expect(fields, "knots_used", status.knots_used);
    expect(fields, "knot_credit", status.knot_credit);
    ASSERT_EQ(status.position_counts_count, 4u);
    expect_four<std::int32_t>(fields, "position_counts", status.position_counts);
    expect(fields, "position_known_mask", status.position_known_mask);
    expect(fields, "inputs", status.inputs);
    expect(fields, "feed", status.feed);
    EXPECT_EQ(value<bool>(fields, "clock_locked"), status.clock_locked);
    EXPECT_EQ(value<bool>(fields, "shutter_open"), status.shutter_open);
    EXPECT_EQ(value<bool>(fields, "lamp_on"), status.lamp_on);
    EXPECT_EQ(value<bool>(fields, "acquiring"), status.acquiring);
    EXPECT_EQ(gonio::test::Client::encoded(gonio_Event_fields, event), frame.payload);
}

void expect_latency(const toml::table &fields, const Frame &frame) {
    gonio_Event const event = frame.event();
    ASSERT_EQ(event.which_body, gonio_Event_latency_tag);
    gonio_Latency const &latency = event.body.latency;
    expect(fields, "time_ns", event.time_ns);
    expect(fields, "thread", static_cast<int>(latency.thread));
    expect(fields, "wakeups", latency.wakeups);
    expect(fields, "max_us", latency.max_us);
    const toml::array &bins = *fields["bins"].as_array();
    ASSERT_EQ(latency.bins_count, bins.size());
    for (std::size_t i = 0; i < bins.size(); ++i) {
        EXPECT_EQ(bins[i].value<std::int64_t>(), std::int64_t{latency.bins[i]}) << i;
    }
    EXPECT_EQ(gonio::test::Client::encoded(gonio_Event_fields, event), frame.payload);
}

void expect_event(const toml::table &fields, const Frame &frame) {
    fields.contains("bins") ? expect_latency(fields, frame) : expect_status(fields, frame);
}

struct Kind {
    const char *name;
    std::uint8_t number;
    void (*expect_fields)(const toml::table &, const Frame &);
};

constexpr Kind kinds[] = {
    {"HELLO", GN_FRAME_HELLO, expect_hello},
    {"REQUEST", GN_FRAME_REQUEST, expect_request},
    {"REPLY", GN_FRAME_REPLY, expect_reply},
    {"EVENT", GN_FRAME_EVENT, expect_event},
    {"SAMPLES", GN_FRAME_SAMPLES, expect_samples},
    {"POSES", GN_FRAME_POSES, expect_poses},
    {"KNOTS", GN_FRAME_KNOTS, expect_knots},
    {"IDLE", GN_FRAME_IDLE, nullptr},
    {"ALIVE", GN_FRAME_ALIVE, nullptr},
};

TEST(Vectors, frames_hold_what_is_said_of_them_and_are_made_byte_for_byte) {
    std::size_t kinds_seen = 0;
    auto decoder = std::make_unique<gn_frame_decoder>();
    for (const toml::table *vector : vectors("frames.toml")) {
        SCOPED_TRACE(value<std::string>(*vector, "name"));
        Bytes const bytes = bytes_of(*vector);
        std::size_t taken = 0;
        gn_frame_decoder_reset(decoder.get());
        ASSERT_EQ(gn_frame_decode(decoder.get(), bytes.data(), bytes.size(), &taken), GN_FRAME_COMPLETE);
        ASSERT_EQ(taken, bytes.size());
        Frame const frame = {gn_frame_header_at(decoder->bytes),
                             Bytes(bytes.begin() + GN_FRAME_HEADER_SIZE, bytes.end())};
        auto const name = value<std::string>(*vector, "kind");
        auto const kind =
            std::find_if(std::begin(kinds), std::end(kinds), [&](const Kind &one) { return one.name == name; });
        ASSERT_NE(kind, std::end(kinds));
        kinds_seen |= std::size_t{1} << kind->number;
        EXPECT_EQ(frame.header.kind, kind->number);
        expect(*vector, "sequence", std::uint32_t{frame.header.sequence});
        expect(*vector, "acknowledged", std::uint32_t{frame.header.acknowledged});
        if (kind->expect_fields != nullptr) {
            kind->expect_fields(*(*vector)["fields"].as_table(), frame);
        } else {
            EXPECT_TRUE(frame.payload.empty());
        }
        Bytes again = bytes;
        std::fill(again.begin(), again.begin() + GN_FRAME_HEADER_SIZE, std::uint8_t{0});
        gn_frame_begin(again.data(), kind->number, frame.header.sequence,
                       static_cast<std::uint32_t>(frame.payload.size()));
        gn_frame_seal(again.data(), frame.header.acknowledged);
        EXPECT_EQ(again, bytes);
    }
    EXPECT_EQ(kinds_seen, 0x3FEu) << "every kind has a vector";
}

TEST(Vectors, refused_frames_are_refused_for_the_stated_reason) {
    auto decoder = std::make_unique<gn_frame_decoder>();
    for (const toml::table *vector : vectors("refused_frames.toml")) {
        SCOPED_TRACE(value<std::string>(*vector, "name"));
        Bytes const bytes = bytes_of(*vector);
        std::size_t taken = 0;
        gn_frame_decoder_reset(decoder.get());
        ASSERT_EQ(gn_frame_decode(decoder.get(), bytes.data(), bytes.size(), &taken), GN_FRAME_REFUSED);
        constexpr const char *fields[] = {"none", "magic", "version", "kind", "length", "crc"}; // as in gn_frame_error
        EXPECT_EQ(value<std::string>(*vector, "refusal"), fields[decoder->error]);
    }
}

TEST(Vectors, digitiser_packets) {
    for (const toml::table *vector : vectors("digitiser.toml")) {
        SCOPED_TRACE(value<std::string>(*vector, "name"));
        Bytes const bytes = bytes_of(*vector);
        gn_digitiser_packets packets{};
        gn_sample_run run{};
        bool refused = (*vector)["refused"].value_or(false);
        if (refused) {
            EXPECT_FALSE(gn_digitiser_packets_parse(&packets, bytes.data(), bytes.size(), &run));
            continue;
        }
        const toml::table &fields = *(*vector)["fields"].as_table();
        packets.started = true;
        packets.next_packet = static_cast<std::uint16_t>(value<std::int64_t>(fields, "packet"));
        packets.next_sample = static_cast<std::uint64_t>(value<std::int64_t>(fields, "first_sample"));
        ASSERT_TRUE(gn_digitiser_packets_parse(&packets, bytes.data(), bytes.size(), &run));
        EXPECT_EQ(packets.packets_lost + packets.samples_lost, 0u);
        expect(fields, "first_sample", run.first_sample);
        EXPECT_EQ(value<std::int64_t>(fields, "flags") == 1, run.gap_before);
        const toml::array &samples = *fields["samples"].as_array();
        ASSERT_EQ(run.count, samples.size());
        for (std::size_t i = 0; i < samples.size(); ++i) {
            gn_sample sample{};
            std::memcpy(&sample, run.records + i * GN_SAMPLE_SIZE, sizeof sample);
            expect_sample(*samples[i].as_table(), sample);
        }
    }
}

} // namespace
