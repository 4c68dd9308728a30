"""can_faults.py: the bus itself: bus-off, error passive, an interface that goes down; on the simulated CAN pair."""

from guest.bench import Bench
from guest.interfaces import CAN_PAIRS, can_details, can_down, can_error_state, can_up
from scenarios.registry import scenario
from scenarios.steps import BRIEF_PLAN, fault_in_scan, home_again

INTERFACE = CAN_PAIRS["sim"].firmware


@scenario(can="sim")
def bus_off(bench: Bench) -> None:
    fault_in_scan(bench, lambda: can_error_state(INTERFACE, "bus-off"))
    bench.values["interface"] = can_details(INTERFACE)
    home_again(bench)


@scenario(can="sim")
def error_passive(bench: Bench) -> None:
    """A bus that still works: the scan goes on, with a warning."""

    def passive() -> None:
        can_error_state(INTERFACE, "error-passive")
        bench.values["interface"] = can_details(INTERFACE)

    fault_in_scan(bench, passive, plan=BRIEF_PLAN)
    can_error_state(INTERFACE, "error-active")
    home_again(bench)


@scenario(can="sim")
def interface_down(bench: Bench) -> None:
    fault_in_scan(bench, lambda: can_down(INTERFACE))
    bench.gonio("home-while-down", "home")
    can_up(INTERFACE)
    home_again(bench)
