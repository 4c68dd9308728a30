// test_log_stream.cpp: the log: lines whole and in order, from several threads, and never a wait when nobody reads.
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include <gtest/gtest.h>

extern "C" {
#include "log_stream.h"
}

namespace {

class Log_stream : public testing::Test {
protected:
    int ends[2] = {-1, -1};
    gn_log_stream *log = nullptr;
    gn_log_port port{};

    void SetUp() override {
        ASSERT_EQ(pipe(ends), 0);
        log = gn_log_stream_open(ends[1]);
        ASSERT_NE(log, nullptr);
        gn_log_stream_port(log, &port);
    }
    void write(gn_log_level level, const std::string &text) { port.write(port.context, level, text.c_str()); }
    // Closes the log while a reader takes all that comes.
    std::vector<std::string> finish() {
        std::string all;
        std::thread reader([&] {
            char bytes[4096];
            for (ssize_t length = 0; (length = read(ends[0], bytes, sizeof bytes)) > 0;) {
                all.append(bytes, static_cast<std::size_t>(length));
            }
        });
        gn_log_stream_close(log);
        close(ends[1]);
        reader.join();
        close(ends[0]);
        std::vector<std::string> lines;
        std::istringstream stream(all);
        for (std::string line; std::getline(stream, line);) {
            lines.push_back(line);
        }
        return lines;
    }
};

TEST_F(Log_stream, levels_stand_before_the_lines) {
    write(GN_LOG_INFO, "one");
    write(GN_LOG_ERROR, "two");
    write(GN_LOG_WARNING, std::string(1000, 'x'));
    EXPECT_EQ(finish(), (std::vector<std::string>{"<6>one", "<3>two", "<4>" + std::string(247, 'x')}));
}

TEST_F(Log_stream, lines_of_several_threads_come_whole_and_each_in_order) {
    constexpr int writers = 4;
    constexpr int lines = 60; // all of them fit in the ring
    std::vector<std::thread> threads;
    for (int i = 0; i < writers; ++i) {
        threads.emplace_back([this, i] {
            for (int k = 0; k < lines; ++k) {
                write(GN_LOG_INFO, std::to_string(i) + " " + std::to_string(k));
            }
        });
    }
    for (auto &thread : threads) {
        thread.join();
    }
    std::map<int, int> next;
    for (const std::string &line : finish()) {
        std::istringstream stream(line.substr(3));
        int writer = -1;
        int number = -1;
        stream >> writer >> number;
        EXPECT_EQ(next[writer]++, number) << line;
    }
    for (int i = 0; i < writers; ++i) {
        EXPECT_EQ(next[i], lines);
    }
}

TEST_F(Log_stream, a_reader_that_does_not_read_makes_nobody_wait_and_what_was_dropped_is_told) {
    ASSERT_EQ(fcntl(ends[1], F_SETPIPE_SZ, 4096), 4096);
    constexpr int written = 2000; // far more than pipe and ring hold
    for (int i = 0; i < written; ++i) {
        write(GN_LOG_INFO, std::string(200, 'y')); // would hang here
    }
    auto const lines = finish();
    int kept = 0;
    int dropped = 0;
    for (const std::string &line : lines) {
        if (line == "<6>" + std::string(200, 'y')) {
            ++kept;
        } else {
            int count = 0;
            ASSERT_EQ(std::sscanf(line.c_str(), "<4>log: %d lines dropped", &count), 1) << line;
            dropped += count;
        }
    }
    EXPECT_GE(kept, 256);
    EXPECT_GT(dropped, 0);
    EXPECT_EQ(kept + dropped, written);
}

} // namespace
