/* can_interface.c: sysfs and netlink. */
#include "can_interface.h"

#include <fcntl.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* The number in a file of sysfs; -1: no such file. */
static long number_in(const char *folder, const char *name, const char *file) {
    char path[128];
    char text[32];
    if (snprintf(path, sizeof path, "%s/%s/%s", folder, name, file) >= (int)sizeof path) {
        return -1;
    }
    int const fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return -1;
    }
    ssize_t const length = read(fd, text, sizeof text - 1u);
    (void)close(fd);
    if (length <= 0) {
        return -1;
    }
    text[length] = 0;
    return strtol(text, NULL, 0);
}

struct gn_can_look gn_can_interface_look(const char *folder, const char *name) {
    long const index = number_in(folder, name, "ifindex");
    long const flags = number_in(folder, name, "flags");
    return (struct gn_can_look){
        .index = index > 0 ? (int)index : 0,
        .is_can = number_in(folder, name, "type") == ARPHRD_CAN,
        .up = flags > 0 && (flags & IFF_UP) != 0,
    };
}

/* The attribute of this type among those in [attribute, + length), or NULL. */
static const struct rtattr *find(const struct rtattr *attribute, size_t length, unsigned short type) {
    unsigned int left = (unsigned int)length;
    for (; RTA_OK(attribute, left); attribute = RTA_NEXT(attribute, left)) {
        if ((attribute->rta_type & NLA_TYPE_MASK) == type) {
            return attribute;
        }
    }
    return NULL;
}

static const struct rtattr *within(const struct rtattr *outer, unsigned short type) {
    return outer == NULL ? NULL : find(RTA_DATA(outer), RTA_PAYLOAD(outer), type);
}

static enum gn_can_bus_state state_of(const struct nlmsghdr *answer) {
    if (answer->nlmsg_type != RTM_NEWLINK || answer->nlmsg_len < NLMSG_LENGTH(sizeof(struct ifinfomsg))) {
        return GN_CAN_ERROR_ACTIVE;
    }
    const struct rtattr *first = IFLA_RTA(NLMSG_DATA(answer));
    const struct rtattr *info = find(first, IFLA_PAYLOAD(answer), IFLA_LINKINFO);
    const struct rtattr *state = within(within(info, IFLA_INFO_DATA), IFLA_CAN_STATE);
    uint32_t value = CAN_STATE_ERROR_ACTIVE;
    if (state != NULL && RTA_PAYLOAD(state) >= sizeof value) {
        memcpy(&value, RTA_DATA(state), sizeof value);
    }
    switch (value) {
    case CAN_STATE_ERROR_WARNING:
        return GN_CAN_ERROR_WARNING;
    case CAN_STATE_ERROR_PASSIVE:
        return GN_CAN_ERROR_PASSIVE;
    case CAN_STATE_BUS_OFF:
        return GN_CAN_BUS_OFF;
    default:
        return GN_CAN_ERROR_ACTIVE;
    }
}

enum gn_can_bus_state gn_can_interface_state(int index) {
    struct {
        struct nlmsghdr header;
        struct ifinfomsg info;
    } const question = {
        .header = {.nlmsg_len = sizeof question, .nlmsg_type = RTM_GETLINK, .nlmsg_flags = NLM_F_REQUEST},
        .info = {.ifi_index = index},
    };
    union {
        struct nlmsghdr header;
        char bytes[8192]; /* a link's attributes take about 2 kB */
    } answer;
    enum gn_can_bus_state state = GN_CAN_ERROR_ACTIVE;
    int const fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    if (fd < 0) {
        return state;
    }
    if (send(fd, &question, sizeof question, 0) == (ssize_t)sizeof question) {
        ssize_t const length = recv(fd, &answer, sizeof answer, 0); /* the kernel answers within send() */
        if (length >= (ssize_t)sizeof answer.header && NLMSG_OK(&answer.header, (size_t)length)) {
            state = state_of(&answer.header);
        }
    }
    (void)close(fd);
    return state;
}
