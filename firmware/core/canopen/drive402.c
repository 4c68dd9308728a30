/* drive402.c: CiA 402 power state machine: statusword masks, transitions by goal, controlword of each cycle. */
#include "drive402.h"

#include <stddef.h>

static const struct {
    uint16_t mask, value;
    enum gn_drive_state state;
    const char *words;
} states[] = {
    {0x4F, 0x00, GN_DRIVE_NOT_READY, "not ready to switch on"},
    {0x4F, 0x40, GN_DRIVE_SWITCH_ON_DISABLED, "switch on disabled"},
    {0x6F, 0x21, GN_DRIVE_READY_TO_SWITCH_ON, "ready to switch on"},
    {0x6F, 0x23, GN_DRIVE_SWITCHED_ON, "switched on"},
    {0x6F, 0x27, GN_DRIVE_OPERATION_ENABLED, "operation enabled"},
    {0x6F, 0x07, GN_DRIVE_QUICK_STOP_ACTIVE, "quick stop active"},
    {0x4F, 0x0F, GN_DRIVE_FAULT_REACTION, "fault reaction active"},
    {0x4F, 0x08, GN_DRIVE_FAULT, "fault"},
};
#define STATES (sizeof states / sizeof states[0])

#define DISABLE_VOLTAGE 0x00u
#define QUICK_STOP 0x02u
#define SHUTDOWN 0x06u
#define SWITCH_ON 0x07u /* and disable operation */
#define ENABLE_OPERATION 0x0Fu

static const struct gn_drive_transition transitions[] = {
    {GN_GOAL_ENABLED, GN_DRIVE_SWITCH_ON_DISABLED, 2, SHUTDOWN},
    {GN_GOAL_ENABLED, GN_DRIVE_READY_TO_SWITCH_ON, 3, SWITCH_ON},
    {GN_GOAL_ENABLED, GN_DRIVE_SWITCHED_ON, 4, ENABLE_OPERATION},
    {GN_GOAL_ENABLED, GN_DRIVE_QUICK_STOP_ACTIVE, 16, ENABLE_OPERATION},
    {GN_GOAL_ENABLED, GN_DRIVE_FAULT, 15, GN_CONTROL_FAULT_RESET},

    {GN_GOAL_QUICK_STOP, GN_DRIVE_READY_TO_SWITCH_ON, 7, QUICK_STOP},
    {GN_GOAL_QUICK_STOP, GN_DRIVE_SWITCHED_ON, 10, QUICK_STOP},
    {GN_GOAL_QUICK_STOP, GN_DRIVE_OPERATION_ENABLED, 11, QUICK_STOP},

    {GN_GOAL_RELEASED, GN_DRIVE_OPERATION_ENABLED, 5, SWITCH_ON},
    {GN_GOAL_RELEASED, GN_DRIVE_SWITCHED_ON, 6, SHUTDOWN},
    {GN_GOAL_RELEASED, GN_DRIVE_READY_TO_SWITCH_ON, 7, DISABLE_VOLTAGE},
    {GN_GOAL_RELEASED, GN_DRIVE_QUICK_STOP_ACTIVE, 12, DISABLE_VOLTAGE},
    {GN_GOAL_RELEASED, GN_DRIVE_FAULT, 15, GN_CONTROL_FAULT_RESET},

    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_OPERATION_ENABLED, 11, QUICK_STOP},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_QUICK_STOP_ACTIVE, 12, DISABLE_VOLTAGE},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_SWITCHED_ON, 10, DISABLE_VOLTAGE},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_READY_TO_SWITCH_ON, 7, DISABLE_VOLTAGE},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_FAULT, 15, GN_CONTROL_FAULT_RESET},
};

enum gn_drive_state gn_drive_state_of(uint16_t statusword) {
    for (size_t i = 0; i < STATES; i++) {
        if ((statusword & states[i].mask) == states[i].value) {
            return states[i].state;
        }
    }
    return GN_DRIVE_UNKNOWN;
}

const char *gn_drive_state_words(enum gn_drive_state state) {
    for (size_t i = 0; i < STATES; i++) {
        if (states[i].state == state) {
            return states[i].words;
        }
    }
    return "in no state of the standard";
}

const struct gn_drive_transition *gn_drive_transition_to(enum gn_drive_goal goal, enum gn_drive_state from) {
    for (size_t i = 0; i < sizeof transitions / sizeof transitions[0]; i++) {
        if (transitions[i].goal == goal && transitions[i].from == from) {
            return &transitions[i];
        }
    }
    return NULL;
}

bool gn_drive_at_goal(const struct gn_drive *drive) {
    enum gn_drive_state const state = gn_drive_state_of(drive->statusword);
    switch (drive->goal) {
    case GN_GOAL_NONE:
        return true;
    case GN_GOAL_ENABLED:
        return drive->seen && state == GN_DRIVE_OPERATION_ENABLED;
    case GN_GOAL_QUICK_STOP:
        return drive->seen && (state == GN_DRIVE_QUICK_STOP_ACTIVE || state == GN_DRIVE_SWITCH_ON_DISABLED);
    case GN_GOAL_RELEASED:
    case GN_GOAL_RELEASED_BY_STOP:
        return drive->seen && state == GN_DRIVE_SWITCH_ON_DISABLED;
    }
    return false;
}

uint16_t gn_drive_command(struct gn_drive *drive) {
    if (!drive->seen || drive->goal == GN_GOAL_NONE) {
        return drive->controlword;
    }
    enum gn_drive_state const state = gn_drive_state_of(drive->statusword);
    const struct gn_drive_transition *transition = gn_drive_transition_to(drive->goal, state);
    if (transition != NULL) {
        uint16_t word = transition->controlword;
        /* A fault is reset by the rising edge of bit 7. */
        if (word == GN_CONTROL_FAULT_RESET && (drive->controlword & GN_CONTROL_FAULT_RESET)) {
            word = DISABLE_VOLTAGE;
        }
        drive->controlword = word;
    } else if (drive->goal == GN_GOAL_ENABLED && state == GN_DRIVE_OPERATION_ENABLED) {
        drive->controlword = (uint16_t)(ENABLE_OPERATION | drive->operation_bits);
    } else if (drive->goal == GN_GOAL_QUICK_STOP && state == GN_DRIVE_QUICK_STOP_ACTIVE) {
        drive->controlword = QUICK_STOP; /* it may have come here by itself: an old "enable" would let it go on */
    } else if (drive->goal != GN_GOAL_QUICK_STOP && state == GN_DRIVE_SWITCH_ON_DISABLED) {
        drive->controlword = DISABLE_VOLTAGE;
    }
    return drive->controlword;
}
