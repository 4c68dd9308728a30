"""session.py: brings an instrument from power-up to ready: configuration, boot, homing, acquisition, outputs."""

from gonio.link.client import Client
from gonio.protocol.configuration import axis_message, configure_message, homing_timeout_ms, zone_messages
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.messages import state_name
from gonio.units.errors import InstrumentFault
from gonio.units.instrument import Instrument

SECOND_NS = 1_000_000_000
# Boot: the slowest drive's power-up, then some sixty objects per drive, written and read back.
BOOT_EXTRA_NS = 20 * SECOND_NS
CLOCK_EXTRA_NS = 3 * SECOND_NS
AFTERGLOW_NS = SECOND_NS // 10  # poses that the interpolation of the last samples needs
OUTPUT_TIMEOUT_NS = SECOND_NS  # the next Status shows it
STOP_TIMEOUT_NS = 10 * SECOND_NS


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

    def info(self) -> pb.Info:
        """What the instrument is: controller, drives, and what is said about them."""
        return self.client.request(get_info=pb.GetInfo()).info

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
