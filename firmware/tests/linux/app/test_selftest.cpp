// test_selftest.cpp: the self-test's golden bytes are the protocol's; its checks pass here, and goniod says so.
#include <array>
#include <cstdint>
#include <cstdio>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <toml++/toml.h>

extern "C" {
#include "selftest.h"
#include "selftest_vectors.h"
}

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes golden(const std::string &name) {
    static const toml::table file = toml::parse_file(GONIO_SOURCE_DIR "/protocol/vectors/frames.toml");
    for (const toml::node &vector : *file["vector"].as_array()) {
        const toml::table &table = *vector.as_table();
        if (table["name"].value_or(std::string()) == name) {
            std::string const hex = table["hex"].value_or(std::string());
            Bytes bytes;
            for (std::size_t i = 0; i + 1 < hex.size(); ++i) {
                if (std::isxdigit(static_cast<unsigned char>(hex[i])) != 0) {
                    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
                    ++i;
                }
            }
            return bytes;
        }
    }
    return {};
}

struct Ran {
    int status;
    std::string output;
};

Ran run(const std::string &arguments) {
    Ran ran{-1, {}};
    std::ostringstream command;
    command << GONIOD << ' ' << arguments << " 2>&1";
    FILE *pipe = popen(command.str().c_str(), "r");
    std::array<char, 512> bytes{};
    while (std::fgets(bytes.data(), static_cast<int>(bytes.size()), pipe) != nullptr) {
        ran.output += bytes.data();
    }
    int const status = pclose(pipe);
    ran.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ran;
}

TEST(Selftest, golden_bytes_are_those_of_the_protocol) {
    EXPECT_EQ(Bytes(std::begin(gn_vector_hello_driver), std::end(gn_vector_hello_driver)), golden("hello-driver"));
    EXPECT_EQ(Bytes(std::begin(gn_vector_event_status), std::end(gn_vector_event_status)), golden("event-status"));
    EXPECT_EQ(Bytes(std::begin(gn_vector_poses_block), std::end(gn_vector_poses_block)), golden("poses-block"));
}

TEST(Selftest, goniod_checks_itself) {
    Ran const ran = run("--self-test");
    EXPECT_EQ(ran.status, 0) << ran.output;
    for (const char *line :
         {"good   records: sizes and byte order\n", "good   CRC-32C: known answers\n", "good   frames: golden bytes\n",
          "good   messages: there and back\n", "good   ring between two threads\n",
          "good   firmware and a host over loopback TCP: woken "}) {
        EXPECT_NE(ran.output.find(line), std::string::npos) << line << ran.output;
    }
}

TEST(Goniod, wrong_use_is_refused_with_the_usage) {
    Ran const unknown = run("--selftest");
    EXPECT_EQ(unknown.status, 2);
    EXPECT_NE(unknown.output.find("usage: goniod"), std::string::npos);
    Ran const word = run("now");
    EXPECT_EQ(word.status, 2);
    EXPECT_NE(word.output.find("goniod: 'now' is not known"), std::string::npos);
    Ran const missing = run("--config /nonexistent/goniod.conf");
    EXPECT_EQ(missing.status, 2);
    EXPECT_EQ(missing.output, "goniod: /nonexistent/goniod.conf: No such file or directory; name the settings file "
                              "with --config FILE\n");
}

TEST(Goniod, a_device_that_is_not_there_ends_the_start_with_one_line) {
    std::string const file = testing::TempDir() + "gn_no_can.conf";
    FILE *stream = std::fopen(file.c_str(), "w");
    std::fputs("can.interface = nocan7\nlink.functionfs = none\nlink.tcp_port = any\nrealtime.motion_priority = 0\n"
               "realtime.stream_priority = 0\n",
               stream);
    std::fclose(stream);
    Ran const ran = run("--config " + file);
    EXPECT_EQ(ran.status, 2);
    EXPECT_EQ(ran.output.rfind("goniod: ", 0), 0u) << ran.output;
    EXPECT_NE(ran.output.find("nocan7"), std::string::npos) << ran.output;
    EXPECT_EQ(ran.output.find('\n'), ran.output.size() - 1) << ran.output;
    Ran const checked = run("--check-config --config " + file);
    EXPECT_EQ(checked.status, 1) << checked.output;
    EXPECT_NE(checked.output.find("MISSING: no such interface"), std::string::npos) << checked.output;
    std::remove(file.c_str());
}

} // namespace
