/* realtime.c: locks memory, tries what real time needs before it is needed, and says what the kernel is. */
#include "realtime.h"

#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "threads.h"

/* The stream thread's stack is the process's own and grows: this much of it is touched, then it is locked. */
#define PREFAULT_BYTES (128u * 1024u)

static void prefault_stack(void) {
    volatile char stack[PREFAULT_BYTES];
    for (size_t i = 0; i < sizeof stack; i += 1024u) {
        stack[i] = 0;
    }
}

static bool says_realtime(void) {
    char text[2] = "";
    int const fd = open("/sys/kernel/realtime", O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return false;
    }
    bool const yes = read(fd, text, 1) == 1 && text[0] == '1';
    (void)close(fd);
    return yes;
}

static void describe_kernel(char *kernel, size_t size, bool *preempt_rt) {
    struct utsname name;
    if (uname(&name) != 0) {
        (void)snprintf(kernel, size, "unknown");
        *preempt_rt = false;
        return;
    }
    (void)snprintf(kernel, size, "%s %s %s", name.sysname, name.release, name.machine);
    *preempt_rt = says_realtime() || strstr(name.version, "PREEMPT_RT") != NULL;
}

/* Adds a sentence; true where there was nothing to add. */
static bool note(bool good, char *problem, size_t size, const char *sentence, int why) {
    if (!good) {
        size_t const used = strlen(problem);
        (void)snprintf(problem + used, size - used, "%s%s (%s)", used > 0u ? "; " : "", sentence, strerror(why));
    }
    return good;
}

/* Whether a thread would get this priority; the caller's is put back. */
static bool may_have_priority(int priority) {
    struct sched_param before;
    int const policy = sched_getscheduler(0);
    struct sched_param const wanted = {.sched_priority = priority};
    if (policy < 0 || sched_getparam(0, &before) != 0 || sched_setscheduler(0, SCHED_FIFO, &wanted) != 0) {
        return false;
    }
    return sched_setscheduler(0, policy, &before) == 0;
}

static bool may_have_cpu(int cpu) {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    errno = EINVAL;
    return sched_getaffinity(0, sizeof allowed, &allowed) == 0 && cpu < CPU_SETSIZE && CPU_ISSET(cpu, &allowed);
}

bool gn_realtime_prepare(const struct gn_thread_settings *settings, char *kernel, size_t kernel_size, bool *preempt_rt,
                         char *problem, size_t problem_size) {
    int const highest =
        settings->motion_priority > settings->stream_priority ? settings->motion_priority : settings->stream_priority;
    bool good = true;
    problem[0] = 0;
    describe_kernel(kernel, kernel_size, preempt_rt);
    /* Memory that was freed stays with the process: giving it back and faulting it in again takes time. */
    (void)mallopt(M_TRIM_THRESHOLD, -1);
    prefault_stack();
    good = note(mlockall(MCL_CURRENT | MCL_FUTURE) == 0, problem, problem_size,
                "memory is not locked: run goniod as its service does, or raise LimitMEMLOCK", errno) &&
           good;
    if (highest > 0) {
        good = note(may_have_priority(highest), problem, problem_size,
                    "no SCHED_FIFO: run goniod as its service does, or raise LimitRTPRIO", errno) &&
               good;
    }
    if (settings->motion_cpu >= 0) {
        good = note(may_have_cpu(settings->motion_cpu), problem, problem_size,
                    "realtime.motion_cpu is no processor that goniod may use: choose another, or -1", errno) &&
               good;
    }
    return good;
}

void gn_realtime_enter(int priority, int cpu) {
    if (priority > 0) {
        struct sched_param const wanted = {.sched_priority = priority};
        (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
    }
    if (cpu >= 0 && cpu < CPU_SETSIZE) {
        cpu_set_t only;
        CPU_ZERO(&only);
        CPU_SET(cpu, &only);
        (void)pthread_setaffinity_np(pthread_self(), sizeof only, &only);
    }
    (void)prctl(PR_SET_TIMERSLACK, 1ul); /* for a thread that did not get SCHED_FIFO: wake in time all the same */
}
