// test_realtime.cpp: what is said of the kernel, and that a machine which refuses real time is told how to grant it.
#include <gtest/gtest.h>

#include <cstring>
#include <sched.h>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>

extern "C" {
#include "realtime.h"
#include "threads.h"
}

namespace {

struct Prepared {
    char kernel[96] = "";
    char problem[400] = "";
    bool preempt_rt = false;
    bool good = false;

    explicit Prepared(gn_thread_settings const &settings) {
        good = gn_realtime_prepare(&settings, kernel, sizeof kernel, &preempt_rt, problem, sizeof problem);
    }
};

TEST(Realtime, names_the_kernel) {
    utsname name{};
    ASSERT_EQ(uname(&name), 0);
    Prepared const prepared({0, 0, -1});
    munlockall();
    EXPECT_EQ(std::string(prepared.kernel), std::string(name.sysname) + " " + name.release + " " + name.machine);
    if (access("/sys/kernel/realtime", F_OK) != 0 && std::strstr(name.version, "PREEMPT_RT") == nullptr) {
        EXPECT_FALSE(prepared.preempt_rt);
    }
    EXPECT_EQ(prepared.good, std::strlen(prepared.problem) == 0);
    EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER); // only the loops change it
}

// In a process of its own, without the rights: runs nevertheless, and says each thing that is missing.
TEST(Realtime, without_rights_says_what_is_missing) {
    int report[2];
    ASSERT_EQ(pipe(report), 0);
    pid_t const child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        rlimit const none = {0, 0};
        if (setrlimit(RLIMIT_RTPRIO, &none) != 0 || setrlimit(RLIMIT_MEMLOCK, &none) != 0 ||
            (geteuid() == 0 && setuid(65534) != 0)) {
            _exit(2);
        }
        Prepared const prepared({80, 40, 100000});
        (void)!write(report[1], prepared.problem, std::strlen(prepared.problem));
        gn_realtime_enter(80, -1); // refused; goes on
        _exit(prepared.good ? 1 : 0);
    }
    close(report[1]);
    char text[500] = "";
    ssize_t const length = read(report[0], text, sizeof text - 1);
    close(report[0]);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    std::string const problem(text, length > 0 ? static_cast<std::size_t>(length) : 0);
#ifndef __SANITIZE_ADDRESS__ // which makes mlockall do nothing, and say it went well
    EXPECT_NE(problem.find("LimitMEMLOCK"), std::string::npos) << problem;
#endif
    EXPECT_NE(problem.find("LimitRTPRIO"), std::string::npos) << problem;
    EXPECT_NE(problem.find("realtime.motion_cpu"), std::string::npos) << problem;
}

TEST(Realtime, a_thread_gets_its_priority_where_that_is_allowed) {
    pid_t const child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        sched_param const wanted = {10};
        if (sched_setscheduler(0, SCHED_FIFO, &wanted) != 0) {
            _exit(77);
        }
        gn_realtime_enter(20, -1);
        sched_param got{};
        sched_getparam(0, &got);
        _exit(sched_getscheduler(0) == SCHED_FIFO && got.sched_priority == 20 ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    if (WEXITSTATUS(status) == 77) {
        GTEST_SKIP() << "no right to SCHED_FIFO here";
    }
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

} // namespace
