"""configuration.py: an instrument file as the firmware's requests, in counts: cycle, axes, zones."""

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.units.instrument import Axis, Instrument

# The plan keeps to the instrument's limits; rounding and the quintic between two knots may pass them a little.
LIMIT_MARGIN = 1.05
HOMING_EXTRA_MS = 10_000  # acceleration, the slow search of the switch's edge, changes of mode


def configure_message(instrument: Instrument) -> pb.Configure:
    """The Configure request of an instrument: its cycle, field by field."""
    cycle = instrument.cycle
    return pb.Configure(
        axis_count=len(instrument.axes),
        sync_period_us=cycle.sync_period_us,
        sync_window_us=cycle.sync_window_us,
        firmware_heartbeat_ms=cycle.firmware_heartbeat_ms,
        drive_heartbeat_ms=cycle.drive_heartbeat_ms,
        heartbeat_timeout_ms=cycle.heartbeat_timeout_ms,
        rpdo_deadline_syncs=cycle.rpdo_deadline_syncs,
        sdo_timeout_ms=cycle.sdo_timeout_ms,
        boot_timeout_ms=cycle.boot_timeout_ms,
        expiry_ms=cycle.expiry_ms,
        sample_period_us=cycle.sample_period_us,
        samples_per_strobe=cycle.samples_per_strobe,
        clock_settle_ms=cycle.clock_settle_ms,
        edge_tolerance_percent=cycle.edge_tolerance_percent,
    )


def homing_timeout_ms(axis: Axis) -> int:
    """Time-out of one axis's homing: the whole travel at the fast speed, and what comes on top."""
    travel_deg = abs(axis.max_deg - axis.homing.switch_deg) + abs(axis.homing.switch_deg - axis.min_deg)
    return round(1000.0 * travel_deg / axis.homing.fast_deg_per_s) + HOMING_EXTRA_MS


def axis_message(index: int, axis: Axis) -> pb.AxisConfig:
    """The AxisConfig request of axis `index` (from 0), in counts."""
    per_deg = axis.counts_per_deg
    size = abs(per_deg)
    limits = sorted((axis.min_deg * per_deg, axis.max_deg * per_deg))
    return pb.AxisConfig(
        axis=index,
        name=axis.name,
        node=axis.node,
        counts_per_deg=per_deg,
        min_counts=limits[0],
        max_counts=limits[1],
        max_velocity_counts_per_s=LIMIT_MARGIN * axis.max_velocity_deg_per_s * size,
        max_acceleration_counts_per_s2=LIMIT_MARGIN * axis.max_acceleration_deg_per_s2 * size,
        homing_method=axis.homing.method,
        homing_fast_counts_per_s=round(axis.homing.fast_deg_per_s * size),
        homing_slow_counts_per_s=round(axis.homing.slow_deg_per_s * size),
        homing_acceleration_counts_per_s2=round(axis.homing.acceleration_deg_per_s2 * size),
        home_offset_counts=round(axis.homing.switch_deg * per_deg),
        homing_timeout_ms=homing_timeout_ms(axis),
        homing_order=axis.homing.order,
        following_error_counts=round(axis.following_error_deg * size),
        following_error_timeout_ms=axis.following_error_timeout_ms,
        counts_per_turn=axis.counts_per_turn,
        quick_stop_deceleration_counts_per_s2=round(axis.quick_stop_deg_per_s2 * size),
        brake=axis.brake,
        gravity=axis.gravity,
    )


def zone_messages(instrument: Instrument) -> list[pb.Zone]:
    """The Zone requests of an instrument: a . q_deg <= b becomes (a / counts_per_deg) . q_counts <= b."""
    return [
        pb.Zone(
            index=index,
            name=zone.name,
            half_spaces=[
                pb.HalfSpace(
                    a=[a / axis.counts_per_deg for a, axis in zip(line.a, instrument.axes, strict=True)], b=line.b
                )
                for line in zone.half_spaces
            ],
        )
        for index, zone in enumerate(instrument.zones)
    ]
