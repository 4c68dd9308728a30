/* boot_steps.c: what boot writes into a drive, in order: guards first, then PDOs, limits, homing, brake. */
#include "boot_steps.h"

#include <math.h>
#include <stddef.h>

#include "nmt.h"
#include "pdo.h"
#include "sync.h"

#define PDO_OFF 0x80000000u
#define NO_RTR 0x40000000u /* a drive may insist on this bit of a COB-id */
#define ABORT_CONNECTION_QUICK_STOP 3u
#define QUICK_STOP_AND_STAY 6u
#define TO_PRE_OPERATIONAL 0u
#define RPDO_DEADLINE_FLOOR_MS 5u

#define VALUE(name, expression)                                                                                        \
    static uint32_t name(const gonio_AxisConfig *axis, const gonio_Configure *cycle) {                                 \
        (void)axis;                                                                                                    \
        (void)cycle;                                                                                                   \
        return (uint32_t)(expression);                                                                                 \
    }

static uint32_t deadline_ms(uint32_t syncs, uint32_t period_us) {
    uint32_t const ms = (syncs * period_us + 999u) / 1000u;
    return ms < RPDO_DEADLINE_FLOOR_MS ? RPDO_DEADLINE_FLOOR_MS : ms;
}

/* 0x60C2: period = units * 10^exponent seconds, with the fewest digits. */
static uint32_t period_units(uint32_t period_us) {
    while (period_us % 10u == 0u) {
        period_us /= 10u;
    }
    return period_us;
}

static int32_t period_exponent(uint32_t period_us) {
    int32_t exponent = -6;
    for (; period_us % 10u == 0u; exponent++) {
        period_us /= 10u;
    }
    return exponent;
}

VALUE(zero, 0)
VALUE(one, 1)
VALUE(two, 2)
VALUE(counts_per_turn, axis->counts_per_turn)
VALUE(drive_heartbeat, cycle->drive_heartbeat_ms)
VALUE(firmware_heartbeat, GN_FIRMWARE_NODE << 16 | cycle->heartbeat_timeout_ms)
VALUE(error_behaviour, TO_PRE_OPERATIONAL)
VALUE(rpdo_off, PDO_OFF | (GN_RPDO1 + axis->node))
VALUE(rpdo_on, GN_RPDO1 + axis->node)
VALUE(tpdo_off, PDO_OFF | (GN_TPDO1 + axis->node))
VALUE(tpdo_on, GN_TPDO1 + axis->node)
VALUE(map_controlword, GN_MAP_CONTROLWORD)
VALUE(map_target, GN_MAP_TARGET)
VALUE(map_statusword, GN_MAP_STATUSWORD)
VALUE(map_position, GN_MAP_POSITION)
VALUE(rpdo_deadline, deadline_ms(cycle->rpdo_deadline_syncs, cycle->sync_period_us))
VALUE(sync_window, cycle->sync_window_us)
VALUE(counter_overflow, GN_SYNC_COUNTER_OVERFLOW)
VALUE(abort_connection, ABORT_CONNECTION_QUICK_STOP)
VALUE(quick_stop_option, QUICK_STOP_AND_STAY)
VALUE(quick_stop_deceleration, axis->quick_stop_deceleration_counts_per_s2)
VALUE(min_limit, (int32_t)lround(axis->min_counts))
VALUE(max_limit, (int32_t)lround(axis->max_counts))
VALUE(following_window, axis->following_error_counts)
VALUE(following_timeout, axis->following_error_timeout_ms)
VALUE(interpolation_units, period_units(cycle->sync_period_us))
VALUE(interpolation_exponent, period_exponent(cycle->sync_period_us))
VALUE(max_velocity, lround(axis->max_velocity_counts_per_s))
VALUE(max_acceleration, lround(axis->max_acceleration_counts_per_s2))
VALUE(home_offset, axis->home_offset_counts)
VALUE(homing_method, axis->homing_method)
VALUE(homing_fast, axis->homing_fast_counts_per_s)
VALUE(homing_slow, axis->homing_slow_counts_per_s)
VALUE(homing_acceleration, axis->homing_acceleration_counts_per_s2)

const struct gn_boot_step gn_boot_steps[] = {
    {GN_BOOT_RESET, 0, 0, 0, GN_REQUIRED, 0, NULL, "reset"},
    {GN_BOOT_WAIT_BOOT_UP, 0, 0, 0, GN_REQUIRED, 0, NULL, "boot-up"},
    {GN_BOOT_DEVICE_TYPE, 0x1000, 0, 4, GN_REQUIRED, 0, NULL, "device type"},
    {GN_BOOT_IDENTITY, 0x1018, 1, 4, GN_REQUIRED, 0, NULL, "vendor"},
    {GN_BOOT_IDENTITY, 0x1018, 2, 4, GN_SKIP_ABSENT, 0, NULL, "product"},
    {GN_BOOT_IDENTITY, 0x1018, 3, 4, GN_SKIP_ABSENT, 0, NULL, "revision"},
    {GN_BOOT_IDENTITY, 0x1018, 4, 4, GN_SKIP_ABSENT, 0, NULL, "serial number"},
    {GN_BOOT_CHECK, 0x608F, 1, 4, GN_REQUIRED, 0, counts_per_turn, "encoder increments"},
    {GN_BOOT_CHECK, 0x608F, 2, 4, GN_REQUIRED, 0, one, "motor revolutions"},
    {GN_BOOT_UNITS, 0x6091, 1, 4, GN_SKIP_ABSENT, 0, NULL, "gear ratio, motor revolutions"},
    {GN_BOOT_UNITS, 0x6091, 2, 4, GN_SKIP_ABSENT, 0, NULL, "gear ratio, shaft revolutions"},
    {GN_BOOT_UNITS, 0x6092, 1, 4, GN_SKIP_ABSENT, 0, NULL, "feed"},
    {GN_BOOT_UNITS, 0x6092, 2, 4, GN_SKIP_ABSENT, 0, NULL, "feed, shaft revolutions"},
    {GN_BOOT_UNITS, 0x60A9, 0, 4, GN_SKIP_ABSENT, 0, NULL, "velocity unit"},

    {GN_BOOT_WRITE, 0x1017, 0, 2, GN_REQUIRED, 0, drive_heartbeat, "heartbeat period"},
    {GN_BOOT_MONITOR, 0, 0, 0, GN_REQUIRED, 0, NULL, "heartbeat"},
    {GN_BOOT_WRITE, 0x1016, 1, 4, GN_REQUIRED, 0, firmware_heartbeat, "heartbeat consumer"},
    {GN_BOOT_WRITE, 0x1029, 1, 1, GN_NOTE_ABSENT, 0, error_behaviour, "error behaviour"},

    {GN_BOOT_WRITE, 0x1400, 1, 4, GN_SKIP_READ_ONLY, NO_RTR, rpdo_off, "RPDO1 COB-id"},
    {GN_BOOT_WRITE, 0x1600, 0, 1, GN_FIXED_MAP, 0, zero, "RPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1600, 1, 4, GN_REQUIRED, 0, map_controlword, "RPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1600, 2, 4, GN_REQUIRED, 0, map_target, "RPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1600, 0, 1, GN_REQUIRED, 0, two, "RPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1400, 2, 1, GN_EQUAL_READ_ONLY, 0, one, "RPDO1 transmission type"},
    {GN_BOOT_WRITE, 0x1400, 5, 2, GN_DEADLINE, 0, rpdo_deadline, "RPDO1 deadline"},
    {GN_BOOT_WRITE, 0x1400, 1, 4, GN_EQUAL_READ_ONLY, NO_RTR, rpdo_on, "RPDO1 COB-id"},
    {GN_BOOT_WRITE, 0x1800, 1, 4, GN_SKIP_READ_ONLY, NO_RTR, tpdo_off, "TPDO1 COB-id"},
    {GN_BOOT_WRITE, 0x1A00, 0, 1, GN_FIXED_MAP, 0, zero, "TPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1A00, 1, 4, GN_REQUIRED, 0, map_statusword, "TPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1A00, 2, 4, GN_REQUIRED, 0, map_position, "TPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1A00, 0, 1, GN_REQUIRED, 0, two, "TPDO1 mapping"},
    {GN_BOOT_WRITE, 0x1800, 2, 1, GN_EQUAL_READ_ONLY, 0, one, "TPDO1 transmission type"},
    {GN_BOOT_WRITE, 0x1800, 1, 4, GN_EQUAL_READ_ONLY, NO_RTR, tpdo_on, "TPDO1 COB-id"},
    {GN_BOOT_WRITE, 0x1007, 0, 4, GN_NOTE_ABSENT, 0, sync_window, "synchronous window"},
    {GN_BOOT_WRITE, 0x1019, 0, 1, GN_NOTE_ABSENT, 0, counter_overflow, "SYNC counter overflow"},

    {GN_BOOT_WRITE, 0x6007, 0, 2, GN_NOTE_ABSENT, 0, abort_connection, "abort connection option"},
    {GN_BOOT_WRITE, 0x605A, 0, 2, GN_REQUIRED, 0, quick_stop_option, "quick stop option"},
    {GN_BOOT_WRITE, 0x6085, 0, 4, GN_REQUIRED, 0, quick_stop_deceleration, "quick stop deceleration"},
    {GN_BOOT_WRITE, 0x607D, 1, 4, GN_REQUIRED, 0, min_limit, "lower position limit"},
    {GN_BOOT_WRITE, 0x607D, 2, 4, GN_REQUIRED, 0, max_limit, "upper position limit"},
    {GN_BOOT_WRITE, 0x6065, 0, 4, GN_REQUIRED, 0, following_window, "following error window"},
    {GN_BOOT_WRITE, 0x6066, 0, 2, GN_REQUIRED, 0, following_timeout, "following error time-out"},
    {GN_BOOT_WRITE, 0x60C2, 1, 1, GN_PERIOD, 0, interpolation_units, "interpolation period"},
    {GN_BOOT_WRITE, 0x60C2, 2, 1, GN_PERIOD, 0, interpolation_exponent, "interpolation period"},
    {GN_BOOT_WRITE, 0x6081, 0, 4, GN_NOTE_ABSENT, 0, max_velocity, "profile velocity"},
    {GN_BOOT_WRITE, 0x6083, 0, 4, GN_NOTE_ABSENT, 0, max_acceleration, "profile acceleration"},
    {GN_BOOT_WRITE, 0x6084, 0, 4, GN_NOTE_ABSENT, 0, max_acceleration, "profile deceleration"},

    {GN_BOOT_WRITE, 0x607C, 0, 4, GN_REQUIRED, 0, home_offset, "home offset"},
    {GN_BOOT_WRITE, 0x6098, 0, 1, GN_REQUIRED, 0, homing_method, "homing method"},
    {GN_BOOT_WRITE, 0x6099, 1, 4, GN_REQUIRED, 0, homing_fast, "homing speed to the switch"},
    {GN_BOOT_WRITE, 0x6099, 2, 4, GN_REQUIRED, 0, homing_slow, "homing speed to the zero"},
    {GN_BOOT_WRITE, 0x609A, 0, 4, GN_NOTE_ABSENT, 0, homing_acceleration, "homing acceleration"},
    {GN_BOOT_WRITE, 0x60FE, 2, 4, GN_BRAKE_ONLY, 0, one, "digital output mask"},
    {GN_BOOT_WRITE, 0x60FE, 1, 4, GN_BRAKE_ONLY, 0, zero, "brake left to the drive"},

    {GN_BOOT_WAIT_FOR_OTHERS, 0, 0, 0, GN_REQUIRED, 0, NULL, "other nodes"},
    {GN_BOOT_START, 0, 0, 0, GN_REQUIRED, 0, NULL, "start"},
    {GN_BOOT_WAIT_OPERATIONAL, 0, 0, 0, GN_REQUIRED, 0, NULL, "operational"},
};

const uint32_t gn_boot_step_count = sizeof gn_boot_steps / sizeof gn_boot_steps[0];
