/* drive402.h: the CiA 402 power state machine of a drive, as tables with the standard's transition numbers. */
#ifndef GONIO_DRIVE402_H
#define GONIO_DRIVE402_H

#include <stdbool.h>
#include <stdint.h>

enum gn_drive_state {
    GN_DRIVE_UNKNOWN = 0,
    GN_DRIVE_NOT_READY = 1,
    GN_DRIVE_SWITCH_ON_DISABLED = 2,
    GN_DRIVE_READY_TO_SWITCH_ON = 3,
    GN_DRIVE_SWITCHED_ON = 4,
    GN_DRIVE_OPERATION_ENABLED = 5,
    GN_DRIVE_QUICK_STOP_ACTIVE = 6,
    GN_DRIVE_FAULT_REACTION = 7,
    GN_DRIVE_FAULT = 8,
};

enum gn_drive_goal {
    GN_GOAL_NONE = 0,             /* the last controlword stays */
    GN_GOAL_ENABLED = 1,          /* operation enabled, faults reset on the way */
    GN_GOAL_QUICK_STOP = 2,       /* stop on the drive's own ramp and hold */
    GN_GOAL_RELEASED = 3,         /* down to switch-on disabled, state by state */
    GN_GOAL_RELEASED_BY_STOP = 4, /* the same with a quick stop first: torque until the brake is on */
};

enum gn_drive_mode { GN_MODE_HOMING = 6, GN_MODE_CSP = 8 };

/* Statusword bits. */
#define GN_STATUS_TARGET_REACHED 0x0400u
#define GN_STATUS_HOMING_ATTAINED 0x1000u
#define GN_STATUS_HOMING_ERROR 0x2000u
#define GN_STATUS_FOLLOWING_ERROR 0x2000u /* in CSP */
/* Controlword bits. */
#define GN_CONTROL_HOMING_START 0x0010u
#define GN_CONTROL_FAULT_RESET 0x0080u
#define GN_CONTROL_HALT 0x0100u

struct gn_drive_transition {
    enum gn_drive_goal goal;
    enum gn_drive_state from;
    uint32_t number; /* of the standard */
    uint16_t controlword;
};

struct gn_drive {
    bool seen; /* a statusword came */
    uint16_t statusword;
    uint16_t controlword; /* last one sent */
    enum gn_drive_goal goal;
    uint16_t operation_bits; /* homing start or halt, while operation is enabled */
    int8_t mode;             /* for drives that take the mode by RPDO */
};

enum gn_drive_state gn_drive_state_of(uint16_t statusword);
const char *gn_drive_state_words(enum gn_drive_state state);
/* The transition to command on the way to a goal; NULL: nothing to command from here. */
const struct gn_drive_transition *gn_drive_transition_to(enum gn_drive_goal goal, enum gn_drive_state from);
bool gn_drive_at_goal(const struct gn_drive *drive);
/* The controlword of the next RPDO. */
uint16_t gn_drive_command(struct gn_drive *drive);

#endif
