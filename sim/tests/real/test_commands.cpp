// test_commands.cpp: the control socket and what can be asked through it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include <sys/un.h>

#include "commands.hpp"
#include "control.hpp"
#include "real_bench.hpp"

namespace gonio::sim {
namespace {

constexpr const char *done = "{\"ok\": true}";

struct Asked {
    std::string ask(const std::string &line) { return commands.obey(line); }
    [[nodiscard]] bool says(const std::string &line, const std::string &part) {
        return commands.obey(line).find(part) != std::string::npos;
    }
    Real_bench bench;
    Furthest furthest;
    std::atomic<bool> ended{false};
    Commands commands{bench.apparatus, nullptr, furthest, ended};
};

} // namespace

TEST(Furthest, IsNullBeforeTheFirstLook) {
    EXPECT_EQ(Furthest().json(), "[null, null, null, null]"); // infinities are no JSON
}

TEST(Commands, StateTellsWhereTheAxesAreAndWhatTheDrivesSay) {
    Asked asked;
    asked.bench.run_ms(100);
    asked.furthest.see({3, 10, -25, 5});
    asked.furthest.see({3, -10, -25, 7});
    std::string const state = asked.ask("state");
    EXPECT_NE(state.find("\"time_ns\": 1100000000,"), std::string::npos) << state;
    EXPECT_NE(state.find("\"position_deg\": [3, 10, -25, 5]"), std::string::npos) << state;
    EXPECT_NE(state.find("\"nmt_state\": [127, 127, 127, 127]"), std::string::npos) << state;
    EXPECT_NE(state.find("\"furthest_deg\": [[3, 3], [-10, 10], [-25, -25], [5, 7]]"), std::string::npos) << state;
    EXPECT_EQ(state.find('\n'), std::string::npos);
}

TEST(Commands, FaultsHappenAtOnceAndClearUndoesThem) {
    Asked asked;
    asked.bench.run_ms(100);
    for (const char *fault : {"fault door_open", "fault limit", "fault strobe_stuck", "fault node_missing axis=2",
                              "fault node_silent axis=1", "fault strobe_doubled count=5"}) {
        EXPECT_EQ(asked.ask(fault), done) << fault;
    }
    asked.bench.run_ms(1);
    EXPECT_EQ(asked.bench.lines,
              (std::vector<std::pair<std::uint32_t, bool>>{
                  {GN_LINE_DOOR, false}, {GN_LINE_STO, false}, {GN_LINE_LIMIT, false}, {GN_LINE_STROBE, true}}));
    EXPECT_TRUE(asked.says("state", "\"nmt_state\": [127, 127, 0, 127]"));
    EXPECT_TRUE(asked.says("state", "\"door_open\": 1, \"limit\": 1, \"node_missing\": 1, \"node_silent\": 1, "
                                    "\"strobe_doubled\": 5, \"strobe_stuck\": 1"));
    asked.bench.lines.clear();
    EXPECT_EQ(asked.ask("clear"), done);
    asked.bench.run_ms(100);
    EXPECT_EQ(asked.bench.lines,
              (std::vector<std::pair<std::uint32_t, bool>>{
                  {GN_LINE_DOOR, true}, {GN_LINE_STO, true}, {GN_LINE_LIMIT, true}, {GN_LINE_STROBE, false}}));
    EXPECT_TRUE(asked.says("state", "\"nmt_state\": [127, 127, 127, 127]")) << "it has booted again";
}

TEST(Commands, AFaultMayBeGivenItsTime) {
    Asked asked;
    EXPECT_EQ(asked.ask("fault emcy axis=1 code=0x4310 at_s=0.5"), done);
    asked.bench.run_ms(400);
    EXPECT_TRUE(asked.says("state", "\"injected\": {}"));
    asked.bench.run_ms(200);
    EXPECT_TRUE(asked.says("state", "\"emcy\": 1"));
    EXPECT_EQ(asked.bench.apparatus.drive(1).counters().emergencies, 1U);
}

TEST(Commands, WhatIsWrongIsSaidInOneLine) {
    Asked asked;
    for (const auto &[line, part] : {std::pair{"", "fault KIND"},
                                     {"wibble", "'wibble' is not known"},
                                     {"fault wibble", "must be one of"},
                                     {"fault emcy axis", "KIND key=value"},
                                     {"fault emcy axis=9", "must be 0 to 3"},
                                     {"fault emcy colour=1", "is not a key"},
                                     {"fault host_silent", "virtual"},
                                     {"fault door_open after_path=1", "virtual"},
                                     {"mount maybe", "is not known"},
                                     {"dance", "is not known"}}) {
        std::string const answer = asked.ask(line);
        EXPECT_EQ(answer.rfind("{\"error\": \"", 0), 0U) << answer;
        EXPECT_NE(answer.find(part), std::string::npos) << answer;
        EXPECT_EQ(answer.find('\n'), std::string::npos);
    }
}

TEST(Commands, QuitEnds) {
    Asked asked;
    EXPECT_EQ(asked.ask("quit"), done);
    EXPECT_TRUE(asked.ended);
}

TEST(Control_socket, AnswersEachLineWithALineAndForgetsWhoHangsUp) {
    std::filesystem::path const path =
        std::filesystem::path(testing::TempDir()) / ("control_" + std::to_string(getpid()));
    Control_socket control(path, [](const std::string &line) { return "<" + line + ">"; });
    int const descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    ASSERT_EQ(connect(descriptor, reinterpret_cast<const sockaddr *>(&address), sizeof address), 0);
    Peer peer(descriptor);
    peer.say("one\ntwo\nthr");
    control.serve();
    EXPECT_EQ(peer.hear(), "<one>\n<two>\n");
    peer.say("ee\n");
    control.serve();
    EXPECT_EQ(peer.hear(), "<three>\n");
    peer.hang_up();
    control.serve();
    std::vector<pollfd> waited;
    control.wait_for(waited);
    EXPECT_EQ(waited.size(), 1U);
}

} // namespace gonio::sim
