/* main.c: goniod: the firmware of the controller, as a service of Linux. */
#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "assembly.h"
#include "check_config.h"
#include "selftest.h"
#include "session.h"

#define DEFAULT_FILE "/etc/gonio/goniod.conf"
#define EXIT_USE 2   /* wrong use, unreadable settings, a device that is not there */
#define EXIT_FAULT 3 /* it ran, and had to give up */
#define ERROR_SIZE 320u

static const char usage[] =
    "usage: goniod [--config FILE] [--check-config | --self-test | --version]\n"
    "  --config FILE    settings (" DEFAULT_FILE ")\n"
    "  --check-config   say what is set and which of the devices are there; 0: all, 1: some are not, 2: unreadable\n"
    "  --self-test      check this program on this processor without any device; 0: good, 3: not\n"
    "  --version        name, version and the hash of the link's schema\n";

enum task { TASK_RUN, TASK_CHECK_CONFIG, TASK_SELF_TEST, TASK_VERSION, TASK_HELP };

static int complain(const char *error) {
    (void)fprintf(stderr, "goniod: %s\n", error);
    return EXIT_USE;
}

/* The signals that ask for a controlled end, as a file descriptor. Before any thread starts: all of them inherit it. */
static int catch_signals(void) {
    sigset_t asked;
    (void)sigemptyset(&asked);
    (void)sigaddset(&asked, SIGTERM);
    (void)sigaddset(&asked, SIGINT);
    (void)sigaddset(&asked, SIGHUP);
    (void)signal(SIGPIPE, SIG_IGN); /* a reader of the log that is gone is no reason to stop */
    if (sigprocmask(SIG_BLOCK, &asked, NULL) != 0) {
        return -1;
    }
    return signalfd(-1, &asked, SFD_CLOEXEC | SFD_NONBLOCK);
}

static int run(const struct gn_config *config) {
    static struct gn_assembly assembly;
    char error[ERROR_SIZE] = "";
    int const stop_fd = catch_signals();
    if (stop_fd < 0) {
        return complain(strerror(errno));
    }
    struct gn_log_stream *log = gn_log_stream_open(STDERR_FILENO);
    if (log == NULL) {
        return complain("no thread for the log; raise the limit of processes (TasksMax, ulimit -u)");
    }
    int status = EXIT_USE;
    if (gn_assembly_open(&assembly, config, log, error, sizeof error)) {
        bool const ended = gn_assembly_run(&assembly, stop_fd, error, sizeof error) == 0;
        gn_assembly_close(&assembly);
        status = ended ? 0 : assembly.ready ? EXIT_FAULT : EXIT_USE;
    }
    gn_log_stream_close(log);
    (void)close(stop_fd);
    if (status != 0) {
        (void)complain(error);
    }
    return status;
}

int main(int argc, char **argv) {
    static const struct option options[] = {
        {"config", required_argument, NULL, 'c'},         {"check-config", no_argument, NULL, TASK_CHECK_CONFIG},
        {"self-test", no_argument, NULL, TASK_SELF_TEST}, {"version", no_argument, NULL, TASK_VERSION},
        {"help", no_argument, NULL, TASK_HELP},           {NULL, 0, NULL, 0},
    };
    const char *file = DEFAULT_FILE;
    int task = TASK_RUN;
    for (int option = 0; (option = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        if (option == 'c') {
            file = optarg;
        } else if (option == '?') {
            (void)fputs(usage, stderr);
            return EXIT_USE;
        } else {
            task = option;
        }
    }
    if (optind < argc) {
        (void)fprintf(stderr, "goniod: '%s' is not known\n%s", argv[optind], usage);
        return EXIT_USE;
    }
    if (task == TASK_HELP) {
        (void)fputs(usage, stdout);
        return 0;
    }
    if (task == TASK_VERSION) {
        printf("goniod, %s, schema %016llx\n", GN_FIRMWARE_NAME, (unsigned long long)GN_SCHEMA_HASH);
        return 0;
    }
    if (task == TASK_SELF_TEST) {
        return gn_selftest() ? 0 : EXIT_FAULT;
    }
    struct gn_config config;
    char error[ERROR_SIZE] = "";
    gn_config_defaults(&config);
    if (!gn_config_load(&config, file, error, sizeof error)) {
        return complain(error);
    }
    return task == TASK_CHECK_CONFIG ? gn_check_config(&config, file) : run(&config);
}
