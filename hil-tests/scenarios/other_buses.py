"""other_buses.py: home and a brief scan on the kernel's virtual CAN bus and on two emulated PCI cards."""

from guest.bench import Bench
from scenarios.registry import scenario


def _home_and_scan(bench: Bench) -> None:
    bench.gonio("home", "home")
    bench.end(bench.scan("brief.toml"))
    bench.until_safe()


@scenario(can="vcan")
def on_virtual_bus(bench: Bench) -> None:
    """One interface for all: no bit times, no error frames."""
    _home_and_scan(bench)


@scenario(can="card")
def on_pci_cards(bench: Bench) -> None:
    """SJA1000 chips behind the kernel's kvaser_pci driver.

    A chip keeps 64 bytes of received frames, and emulated frames take no bit times: a machine that is busy with other
    work loses some there (counted: can_overflow), and an SDO that is lost ends homing with "no answer".
    """
    _home_and_scan(bench)
