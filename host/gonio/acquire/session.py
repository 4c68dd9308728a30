"""session.py: brings an instrument from power-up to ready: configuration, boot, homing, acquisition, outputs."""

from gonio.link.client import Client
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.messages import state_name
from gonio.units.errors import InstrumentFault
from gonio.units.instrument import Axis, Instrument

SECOND_NS = 1_000_000_000
# The plan keeps to the instrument's limits; rounding and the quintic between two knots may pass them a little.
LIMIT_MARGIN = 1.05
# Boot: the slowest drive's power-up, then some sixty objects per drive, written and read back.
BOOT_EXTRA_NS = 20 * SECOND_NS
HOMING_EXTRA_MS = 10_000  # acceleration, the slow search of the switch's edge, changes of mode
CLOCK_EXTRA_NS = 3 * SECOND_NS
AFTERGLOW_NS = SECOND_NS // 10  # poses that the interpolation of the last samples needs
OUTPUT_TIMEOUT_NS = SECOND_NS  # the next Status shows it
STOP_TIMEOUT_NS = 10 * SECOND_NS


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


class Session:
    """An instrument behind a client. Every method waits until the firmware says that it is done."""

    def __init__(self, client: Client, instrument: Instrument) -> None:
        self.client = client
        self.instrument = instrument

    def status(self) -> pb.Status:
        """The last Status; waits for the first."""
        while self.client.status is None:
            self.client.step()
        return self.client.status

    def configure(self) -> None:
        """Send the instrument: cycle, axes, zones."""
        for axis in self.instrument.axes:
            if not axis.driven:
                raise InstrumentFault(f"axis {axis.name} is set by hand: this version moves driven axes only")
        self.client.request(configure=configure_message(self.instrument))
        for index, axis in enumerate(self.instrument.axes):
            self.client.request(configure_axis=axis_message(index, axis))
        for zone in zone_messages(self.instrument):
            self.client.request(configure_zone=zone)

    def boot(self) -> None:
        """Configure and enable the drives, if the firmware has not done so for an earlier session."""
        if self.status().state == pb.STATE_CONFIGURED:
            timeout_ns = self.instrument.cycle.boot_timeout_ms * 1_000_000 + BOOT_EXTRA_NS
            self.client.operation(timeout_ns, boot=pb.Boot())

    def home(self) -> None:
        """Home all axes whose position is not known; then the instrument must be ready."""
        every = (1 << len(self.instrument.axes)) - 1
        mask = every & ~self.status().position_known_mask
        if mask:
            total_ms = sum(homing_timeout_ms(axis) for axis in self.instrument.axes)
            self.client.operation(total_ms * 1_000_000, home=pb.Home(axis_mask=mask))
        self.client.wait_until(
            lambda: self.status().position_known_mask & every == every and self.status().state == pb.STATE_READY,
            OUTPUT_TIMEOUT_NS,
            "homing",
        )

    def make_ready(self) -> None:
        """Configure, boot and home, whatever the state was."""
        status = self.status()
        if status.acquiring:
            self.acquire(False)
        if status.state == pb.STATE_FAULT:
            self.client.operation(BOOT_EXTRA_NS, clear_fault=pb.ClearFault())
        self.configure()
        self._next_status()
        self.boot()
        self.home()

    def _next_status(self) -> None:
        """Wait for a Status that was made after the last reply."""
        before = self.client.status
        self.client.wait_until(lambda: self.client.status is not before, OUTPUT_TIMEOUT_NS, "status")

    def acquire(self, on: bool) -> None:
        """Start the digitiser and wait until the sample clock is settled; or stop it, once the last samples have poses
        after them."""
        if on:
            self.client.request(acquire=pb.Acquire(on=True))
            settle_ns = self.instrument.cycle.clock_settle_ms * 1_000_000 + CLOCK_EXTRA_NS
            self.client.wait_until(lambda: self.status().clock_locked, settle_ns, "sample clock (no strobe?)")
            return
        end_ns = self.client.link_time_ns + AFTERGLOW_NS
        self.client.wait_until(
            lambda: self.client.link_time_ns >= end_ns, OUTPUT_TIMEOUT_NS, "last samples", despite_fault=True
        )
        self.client.request(acquire=pb.Acquire(on=False), despite_fault=True)
        self.client.wait_until(
            lambda: not self.status().acquiring, OUTPUT_TIMEOUT_NS, "digitiser stop", despite_fault=True
        )

    def shutter(self, is_open: bool) -> None:
        """Open or close the shutter; waits until the firmware shows it."""
        self.client.request(set_output=pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=is_open))
        self.client.wait_until(lambda: self.status().shutter_open == is_open, OUTPUT_TIMEOUT_NS, "shutter")

    def lamp_on(self) -> None:
        """Enable the lamp."""
        self.client.request(set_output=pb.SetOutput(output=pb.OUTPUT_LAMP, on=True))

    def stop(self, reason: str) -> None:
        """Controlled stop; waits until the axes stand and the shutter is closed. A fault on the way is no news."""
        self.client.request(stop=pb.Stop(reason=reason), despite_fault=True)
        moving = (pb.STATE_MOVING, pb.STATE_STOPPING, pb.STATE_HOMING, pb.STATE_BOOTING)
        self.client.wait_until(
            lambda: self.status().state not in moving and not self.status().shutter_open,
            STOP_TIMEOUT_NS,
            f"stop (state {state_name(self.status().state)})",
            despite_fault=True,
        )
