"""values.py: what the firmware writes into a drive, or expects there, for one axis of an instrument."""

from gonio.protocol.configuration import axis_message
from gonio.units.instrument import Axis, Cycle

FIRMWARE_NODE = 127  # firmware/core/canopen/nmt.h
RPDO_DEADLINE_FLOOR_MS = 5
SYNC_COUNTER_OVERFLOW = 240
MAP_CONTROLWORD = 0x60400010
MAP_TARGET = 0x607A0020
MAP_STATUSWORD = 0x60410010
MAP_POSITION = 0x60640020
ABORT_CONNECTION_QUICK_STOP = 3
QUICK_STOP_AND_STAY = 6


def decimal_period(period_us: int) -> tuple[int, int]:
    """0x60C2: a period as units * 10^exponent seconds, with the fewest digits."""
    units, exponent = period_us, -6
    while units and units % 10 == 0:
        units //= 10
        exponent += 1
    return units, exponent


def same_period(units: int, exponent: int, period_us: int) -> bool:
    """Whether units * 10^exponent seconds are period_us, exactly."""
    shift = exponent + 6
    left, right = (10**shift, 1) if shift >= 0 else (1, 10**-shift)
    return bool(units * left == period_us * right)


def rpdo_deadline_ms(cycle: Cycle) -> int:
    """0x1400:05: the SYNCs of the instrument file in whole milliseconds, not below the floor."""
    return max(RPDO_DEADLINE_FLOOR_MS, -(-cycle.rpdo_deadline_syncs * cycle.sync_period_us // 1000))


def values_of(cycle: Cycle, axis: Axis, node: int) -> dict[str, int]:
    """Every rule of objects.toml with its value; `node` is where the drive is."""
    message = axis_message(0, axis)
    units, exponent = decimal_period(cycle.sync_period_us)
    return {
        "zero": 0,
        "one": 1,
        "two": 2,
        "counts_per_turn": message.counts_per_turn,
        "drive_heartbeat": cycle.drive_heartbeat_ms,
        "firmware_heartbeat": FIRMWARE_NODE << 16 | cycle.heartbeat_timeout_ms,
        "to_pre_operational": 0,
        "rpdo_cob_id": 0x200 + node,
        "tpdo_cob_id": 0x180 + node,
        "map_controlword": MAP_CONTROLWORD,
        "map_target": MAP_TARGET,
        "map_statusword": MAP_STATUSWORD,
        "map_position": MAP_POSITION,
        "rpdo_deadline": rpdo_deadline_ms(cycle),
        "sync_window": cycle.sync_window_us,
        "counter_overflow": SYNC_COUNTER_OVERFLOW,
        "abort_connection": ABORT_CONNECTION_QUICK_STOP,
        "quick_stop_and_stay": QUICK_STOP_AND_STAY,
        "quick_stop_deceleration": message.quick_stop_deceleration_counts_per_s2,
        "min_limit": _nearest(message.min_counts),
        "max_limit": _nearest(message.max_counts),
        "following_window": message.following_error_counts,
        "following_timeout": message.following_error_timeout_ms,
        "period_units": units,
        "period_exponent": exponent,
        "max_velocity": _nearest(message.max_velocity_counts_per_s),
        "max_acceleration": _nearest(message.max_acceleration_counts_per_s2),
        "home_offset": message.home_offset_counts,
        "homing_method": message.homing_method,
        "homing_fast": message.homing_fast_counts_per_s,
        "homing_slow": message.homing_slow_counts_per_s,
        "homing_acceleration": message.homing_acceleration_counts_per_s2,
    }


def _nearest(value: float) -> int:
    """C's lround: halves away from zero."""
    return int(value + 0.5) if value >= 0 else -int(-value + 0.5)
