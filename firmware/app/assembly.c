/* assembly.c: opens what the settings name, in the order in which it must be safe: outputs first (they begin low), the
 * way in for hosts last. */
#include "assembly.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

#include "notify.h"
#include "null_port.h"
#include "watchdog_device.h"

#define MESSAGE_SIZE 240u

__attribute__((format(printf, 3, 4))) static void say(struct gn_assembly *assembly, enum gn_log_level level,
                                                      const char *format, ...) {
    char text[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    assembly->port.log.write(assembly->port.log.context, level, text);
}

uint64_t gn_session_number(void) {
    uint64_t number = 0;
    while (number == 0u) { /* 0 means "no session" on the link */
        if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) {
            number = (uint64_t)gn_monotonic_ns(); /* no random numbers in this kernel: at least not the last one */
        }
    }
    return number;
}

static bool any_line(const struct gn_gpio_settings *gpio) {
    bool used = false;
    for (int i = 0; i < GN_LINE_COUNT; ++i) {
        used = used || gpio->inputs[i].used;
    }
    for (int i = 0; i < GN_GPIO_OUTPUTS; ++i) {
        used = used || gpio->outputs[i].used;
    }
    return used;
}

/* What the firmware cannot know because no wire tells it. */
static void tell_of_missing_wires(struct gn_assembly *assembly) {
    static const char *const told[GN_LINE_COUNT] = {
        "input.strobe is none: samples get no time, a fly scan is not possible",
        "input.door is none: the door counts as closed",
        "input.emergency_stop is none: the emergency stop counts as released; a stop shows as a drive fault",
        "input.sto is none: torque off shows only as a drive fault",
        NULL, /* not every instrument has a limit line */
    };
    for (int i = 0; i < GN_LINE_COUNT; ++i) {
        if (!assembly->config->gpio.inputs[i].used && told[i] != NULL) {
            say(assembly, GN_LOG_WARNING, "%s", told[i]);
        }
    }
    if (!assembly->config->gpio.outputs[GN_GPIO_SHUTTER].used) {
        say(assembly, GN_LOG_WARNING, "output.shutter is none: dark readings will not be dark");
    }
}

static bool open_devices(struct gn_assembly *assembly, char *error, size_t error_size) {
    const struct gn_config *config = assembly->config;
    struct gn_threads *threads = &assembly->threads;
    if (any_line(&config->gpio)) {
        threads->gpio = gn_gpio_open(&config->gpio, error, error_size);
        if (threads->gpio == NULL) {
            return false;
        }
        gn_gpio_ports(threads->gpio, &assembly->port.edge, &assembly->port.out);
    }
    threads->can = gn_can_socket_open(&config->can, error, error_size);
    if (threads->can == NULL) {
        return false;
    }
    gn_can_socket_port(threads->can, &assembly->port.can);
    threads->digitiser = gn_digitiser_usb_open(&config->digitiser, error, error_size);
    if (threads->digitiser == NULL) {
        return false;
    }
    gn_digitiser_usb_port(threads->digitiser, &assembly->port.digitiser);
    threads->link = gn_link_linux_open(&config->link, error, error_size);
    if (threads->link == NULL) {
        return false;
    }
    gn_link_linux_port(threads->link, &assembly->port.link);
    error[0] = '\0';
    assembly->watchdog_fd = gn_watchdog_open(config->watchdog_device, error, error_size);
    return error[0] == '\0';
}

/* Info tells of a real-time system only if all of it could be had. */
static void prepare_realtime(struct gn_assembly *assembly) {
    char problem[MESSAGE_SIZE] = "";
    bool preempt_rt = false;
    const struct gn_thread_settings *threads = &assembly->config->threads;
    bool const whole =
        gn_realtime_prepare(threads, assembly->kernel, sizeof assembly->kernel, &preempt_rt, problem, sizeof problem);
    if (!whole) {
        say(assembly, GN_LOG_WARNING, "%s", problem);
    }
    if (!preempt_rt) {
        say(assembly, GN_LOG_WARNING, "%s is no PREEMPT_RT kernel: wake-ups may be late; see the latency of each scan",
            assembly->kernel);
    }
    assembly->shared.kernel = assembly->kernel;
    assembly->shared.realtime = whole && preempt_rt && threads->motion_priority > 0 && threads->stream_priority > 0;
}

bool gn_assembly_open(struct gn_assembly *assembly, const struct gn_config *config, struct gn_log_stream *log,
                      char *error, size_t error_size) {
    memset(assembly, 0, sizeof *assembly);
    assembly->config = config;
    assembly->log = log;
    assembly->watchdog_fd = -1;
    gn_null_port(&assembly->port);
    gn_log_stream_port(log, &assembly->port.log);
    gn_shared_init(&assembly->shared);
    if (!open_devices(assembly, error, error_size)) {
        gn_assembly_close(assembly);
        return false;
    }
    tell_of_missing_wires(assembly);
    prepare_realtime(assembly);
    assembly->threads.shared = &assembly->shared;
    assembly->threads.motion = gn_motion_init(&assembly->port, &assembly->shared);
    assembly->threads.stream =
        gn_stream_init(&assembly->port, &assembly->shared, config->device_name, gn_session_number());
    /* Twice as often as systemd must hear from us, the least its manual asks for, and twice again. */
    assembly->notify_every_ns = gn_notify_watchdog_ns() / 4;
    return true;
}

static void announce(struct gn_assembly *assembly) {
    const struct gn_link_settings *link = &assembly->config->link;
    if (link->tcp) {
        printf("listening 127.0.0.1:%u\n", (unsigned)gn_link_linux_tcp_port(assembly->threads.link));
    }
    if (link->functionfs[0] != '\0') {
        printf("listening %s\n", link->functionfs);
    }
    (void)fflush(stdout);
    (void)gn_notify("READY=1\nSTATUS=Both threads run; hosts may connect.");
}

/* Both threads are alive: this alone keeps the watchdogs quiet. */
static void on_alive(void *context) {
    struct gn_assembly *assembly = context;
    if (!assembly->ready) {
        assembly->ready = true;
        announce(assembly);
    }
    gn_watchdog_keep_alive(assembly->watchdog_fd);
    int64_t const now_ns = gn_monotonic_ns();
    if (assembly->notify_every_ns > 0 && now_ns >= assembly->notify_due_ns) {
        assembly->notify_due_ns = now_ns + assembly->notify_every_ns;
        (void)gn_notify("WATCHDOG=1");
    }
}

int gn_assembly_run(struct gn_assembly *assembly, int stop_fd, char *error, size_t error_size) {
    assembly->threads.alive = on_alive;
    assembly->threads.alive_context = assembly;
    assembly->threads.stop_fd = stop_fd;
    int const result = gn_threads_run(&assembly->threads, &assembly->config->threads, error, error_size);
    (void)gn_notify("STOPPING=1");
    return result;
}

void gn_assembly_close(struct gn_assembly *assembly) {
    struct gn_threads *threads = &assembly->threads;
    if (threads->link != NULL) {
        gn_link_linux_close(threads->link);
    }
    if (threads->digitiser != NULL) {
        gn_digitiser_usb_close(threads->digitiser);
    }
    if (threads->can != NULL) {
        gn_can_socket_close(threads->can);
    }
    if (threads->gpio != NULL) {
        gn_gpio_close(threads->gpio);
    }
    gn_watchdog_close(assembly->watchdog_fd);
}
