/* check_config.c: looks for the devices where the kernel lists them; lines are not requested and no bus is touched, so
 * that it may be asked while goniod runs. */
#include "check_config.h"

#include <dirent.h>
#include <gpiod.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#define PATH_SIZE 320u
#define ARPHRD_CAN 280 /* <linux/if_arp.h>, which does not go together with <net/if.h> */

struct report {
    int missing;
};

static void print(struct report *report, const char *key, const char *value, bool good, const char *found) {
    printf("%-26s %-34s %s%s\n", key, value, good ? "" : "MISSING: ", found);
    report->missing += good ? 0 : 1;
}

/* The first line of a file, without its end; false: unreadable. */
static bool read_line(const char *path, char *text, size_t size) {
    FILE *stream = fopen(path, "re");
    if (stream == NULL) {
        return false;
    }
    bool const read = fgets(text, (int)size, stream) != NULL;
    (void)fclose(stream);
    if (read) {
        text[strcspn(text, "\n")] = '\0';
    }
    return read;
}

static void check_can(struct report *report, const struct gn_can_settings *can) {
    char path[PATH_SIZE];
    char text[32];
    (void)snprintf(path, sizeof path, "/sys/class/net/%s/type", can->interface);
    if (!read_line(path, text, sizeof text)) {
        print(report, "can.interface", can->interface, false, "no such interface; ip link shows what there is");
    } else if (atoi(text) != ARPHRD_CAN) {
        print(report, "can.interface", can->interface, false, "this is no CAN interface");
    } else {
        (void)snprintf(path, sizeof path, "/sys/class/net/%s/flags", can->interface);
        bool const up = read_line(path, text, sizeof text) && (strtoul(text, NULL, 0) & IFF_UP) != 0u;
        print(report, "can.interface", can->interface, up,
              up ? "up" : "there, but down; see docs/controller.md for its set-up");
    }
    (void)snprintf(text, sizeof text, "%g", (double)can->sync_stamp_sigma_us);
    print(report, "can.sync_stamp_sigma_us", text, true, "");
}

/* The chip by path, or by the label that it gives itself. */
static struct gpiod_chip *open_chip(const char *name) {
    if (name[0] == '/') {
        return gpiod_chip_open(name);
    }
    struct gpiod_chip *found = NULL;
    DIR *folder = opendir("/dev");
    const struct dirent *entry = NULL;
    while (folder != NULL && found == NULL && (entry = readdir(folder)) != NULL) {
        char path[PATH_SIZE];
        (void)snprintf(path, sizeof path, "/dev/%s", entry->d_name);
        struct gpiod_chip *chip = strncmp(entry->d_name, "gpiochip", 8) == 0 ? gpiod_chip_open(path) : NULL;
        struct gpiod_chip_info *info = chip == NULL ? NULL : gpiod_chip_get_info(chip);
        if (info != NULL && strcmp(gpiod_chip_info_get_label(info), name) == 0) {
            found = chip;
        } else if (chip != NULL) {
            gpiod_chip_close(chip);
        }
        if (info != NULL) {
            gpiod_chip_info_free(info);
        }
    }
    if (folder != NULL) {
        (void)closedir(folder);
    }
    return found;
}

static void check_line(struct report *report, const char *key, const struct gn_gpio_line *line) {
    char value[96];
    if (!line->used) {
        print(report, key, "none", true, "not wired");
        return;
    }
    (void)snprintf(value, sizeof value, "%s:%u%s", line->chip, (unsigned)line->offset,
                   line->active_low ? " active-low" : "");
    struct gpiod_chip *chip = open_chip(line->chip);
    if (chip == NULL) {
        print(report, key, value, false, "no such chip, or no right to open it; gpiodetect shows what there is");
        return;
    }
    struct gpiod_line_info *info = gpiod_chip_get_line_info(chip, line->offset);
    char found[PATH_SIZE] = "the chip has no such line";
    if (info != NULL) {
        const char *name = gpiod_line_info_get_name(info);
        const char *user = gpiod_line_info_get_consumer(info);
        bool const used = gpiod_line_info_is_used(info);
        (void)snprintf(found, sizeof found, "there, %s%s%s", name == NULL ? "without a name" : name,
                       used ? ", in use by " : "", used ? (user == NULL ? "the kernel" : user) : "");
        gpiod_line_info_free(info);
    }
    print(report, key, value, info != NULL, found);
    gpiod_chip_close(chip);
}

static void check_lines(struct report *report, const struct gn_gpio_settings *gpio) {
    static const char *const inputs[GN_LINE_COUNT] = {"input.strobe", "input.door", "input.emergency_stop", "input.sto",
                                                      "input.limit"};
    static const char *const outputs[GN_GPIO_OUTPUTS] = {"output.shutter", "output.lamp", "output.watchdog"};
    for (int i = 0; i < GN_LINE_COUNT; ++i) {
        check_line(report, inputs[i], &gpio->inputs[i]);
    }
    for (int i = 0; i < GN_GPIO_OUTPUTS; ++i) {
        check_line(report, outputs[i], &gpio->outputs[i]);
    }
    char text[16];
    (void)snprintf(text, sizeof text, "%u", (unsigned)gpio->event_buffer);
    print(report, "gpio.event_buffer", text, true, "");
}

static bool attribute_is(const char *device, const char *attribute, const char *wanted) {
    char path[PATH_SIZE];
    char text[80];
    (void)snprintf(path, sizeof path, "/sys/bus/usb/devices/%s/%s", device, attribute);
    return read_line(path, text, sizeof text) && strcmp(text, wanted) == 0;
}

static void check_digitiser(struct report *report, const struct gn_digitiser_settings *digitiser) {
    char vendor[8];
    char product[8];
    char id[24];
    (void)snprintf(vendor, sizeof vendor, "%04x", digitiser->vendor_id);
    (void)snprintf(product, sizeof product, "%04x", digitiser->product_id);
    (void)snprintf(id, sizeof id, "%s:%s", vendor, product);
    bool there = false;
    DIR *folder = opendir("/sys/bus/usb/devices");
    const struct dirent *entry = NULL;
    while (folder != NULL && !there && (entry = readdir(folder)) != NULL) {
        there = attribute_is(entry->d_name, "idVendor", vendor) && attribute_is(entry->d_name, "idProduct", product) &&
                (digitiser->serial[0] == '\0' || attribute_is(entry->d_name, "serial", digitiser->serial));
    }
    if (folder != NULL) {
        (void)closedir(folder);
    }
    print(report, "digitiser.usb_id", id, there, there ? "plugged in" : "not plugged in, or another serial number");
    print(report, "digitiser.serial", digitiser->serial[0] == '\0' ? "any" : digitiser->serial, true, "");
}

static void check_link(struct report *report, const struct gn_link_settings *link) {
    char text[PATH_SIZE] = "none";
    bool there = true;
    if (link->functionfs[0] != '\0') {
        (void)snprintf(text, sizeof text, "%s/ep0", link->functionfs);
        there = access(text, R_OK | W_OK) == 0;
        (void)snprintf(text, sizeof text, "%s", link->functionfs);
    }
    print(report, "link.functionfs", text, there,
          there ? "" : "no endpoint that may be opened; see goniod-gadget.service, or set none");
    (void)snprintf(text, sizeof text, "%u", (unsigned)link->tcp_port);
    print(report, "link.tcp_port",
          !link->tcp             ? "none"
          : link->tcp_port == 0u ? "any"
                                 : text,
          true, link->tcp ? "on 127.0.0.1 only" : "");
}

static void check_threads(struct report *report, const struct gn_thread_settings *threads) {
    char text[16];
    (void)snprintf(text, sizeof text, "%d", threads->motion_priority);
    print(report, "realtime.motion_priority", text, true, "");
    (void)snprintf(text, sizeof text, "%d", threads->stream_priority);
    print(report, "realtime.stream_priority", text, true, "");
    (void)snprintf(text, sizeof text, "%d", threads->motion_cpu);
    bool const there = threads->motion_cpu < sysconf(_SC_NPROCESSORS_CONF);
    print(report, "realtime.motion_cpu", threads->motion_cpu < 0 ? "any" : text, there,
          there ? "" : "this machine has fewer processors");
    struct utsname kernel;
    bool const rt = access("/sys/kernel/realtime", F_OK) == 0 ||
                    (uname(&kernel) == 0 && strstr(kernel.version, "PREEMPT_RT") != NULL);
    printf("%-26s %-34s %s\n", "(kernel)", rt ? "PREEMPT_RT" : "without PREEMPT_RT",
           rt ? "" : "wake-ups may be late; see the latency of each scan");
}

int gn_check_config(const struct gn_config *config, const char *file) {
    struct report report = {0};
    printf("%s is good. What it names:\n", file);
    print(&report, "device.name", config->device_name, true, "");
    check_can(&report, &config->can);
    check_lines(&report, &config->gpio);
    check_digitiser(&report, &config->digitiser);
    check_link(&report, &config->link);
    check_threads(&report, &config->threads);
    const char *watchdog = config->watchdog_device;
    bool const there = watchdog[0] == '\0' || access(watchdog, W_OK) == 0;
    print(&report, "watchdog.device", watchdog[0] == '\0' ? "none" : watchdog, there,
          there ? "" : "not there, or no right to write to it");
    return report.missing == 0 ? 0 : 1;
}
