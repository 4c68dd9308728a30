"""test_used_objects.py: protocol/objects.toml against the firmware's own table, and the values against arithmetic."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from virtual_drives import VirtualDrive

from gonio.drives.objects import TYPES, used_objects
from gonio.drives.values import decimal_period, rpdo_deadline_ms, same_period, values_of
from gonio.units.instrument import load_instrument

ROOT = Path(__file__).parents[3]
CANOPEN = ROOT / "firmware" / "core" / "canopen"
STEP = re.compile(r"\{GN_BOOT_(\w+), (0x[0-9A-F]{4}), (\d+), (\d+), GN_(\w+), \w+, (\w+), ")
# The firmware switches PDOs off and empties maps before it sets them: the table holds what stays.
PASSING = {"zero", "rpdo_off", "tpdo_off"}
NAMES = {
    "error_behaviour": "to_pre_operational",
    "rpdo_on": "rpdo_cob_id",
    "tpdo_on": "tpdo_cob_id",
    "quick_stop_option": "quick_stop_and_stay",
    "interpolation_units": "period_units",
    "interpolation_exponent": "period_exponent",
    "NULL": "",
}
LACKING = {"NOTE_ABSENT", "SKIP_ABSENT", "DEADLINE", "PERIOD", "BRAKE_ONLY"}
READ_ONLY = {"EQUAL_READ_ONLY", "PERIOD", "FIXED_MAP"}


def boot_steps() -> list[tuple[str, int, int, int, str, str]]:
    text = (CANOPEN / "boot_steps.c").read_text(encoding="utf-8")
    rows = [(a, int(i, 16), int(s), int(n), fallback, value) for a, i, s, n, fallback, value in STEP.findall(text)]
    assert len(rows) > 50
    return rows


def test_the_table_is_the_firmwares_boot() -> None:
    table = {(used.index, used.subindex): used for used in used_objects()}
    booted = {}
    for action, index, subindex, size, fallback, value in boot_steps():
        name = NAMES.get(value, value)
        if (value in PASSING and index != 0x60FE) or (fallback == "FIXED_MAP" and value == "zero"):
            continue
        used = table[index, subindex]
        booted[index, subindex] = used
        assert used.use == ("write" if action == "WRITE" else "read"), used.name
        assert used.bytes == size, used.name
        assert used.value == name, used.name
        assert bool(used.lacking) == (fallback in LACKING), used.name
        assert (used.only == "brake") == (fallback == "BRAKE_ONLY"), used.name
        if index not in (0x1600, 0x1A00):  # there the step that empties the map carries the fallback
            assert bool(used.read_only) == (fallback in READ_ONLY), used.name
        else:
            assert used.read_only, used.name
    rest = {used.name: used.use for key, used in table.items() if key not in booted}
    assert rest == {"0x6060": "write", "0x6061": "read", "0x6040": "rpdo", "0x607A": "rpdo", "0x6041": "tpdo",
                    "0x6064": "tpdo"}  # fmt: skip


def test_no_other_object_is_touched_by_sdo() -> None:
    touched = set()
    for file in CANOPEN.glob("*.c"):
        for words in re.findall(r"gn_sdo_(?:read|write)\(([^;]*);", file.read_text(encoding="utf-8")):
            touched |= set(re.findall(r"0x[0-9A-F]{4}", words))
    assert touched == {"0x6060", "0x6061"}  # all others come out of the table, or from the host's SdoRead


def test_types_are_the_sheets() -> None:
    od = VirtualDrive(1, "full").object_dictionary
    for used in used_objects():
        if used.index not in od:
            assert used.lacking, used.name
            continue
        entry = od[used.index]
        variable = entry[used.subindex] if hasattr(entry, "subindices") else entry
        assert variable.data_type == TYPES[used.type][0], used.name


def test_values_are_those_of_the_instrument_file() -> None:
    instrument = load_instrument(None)
    arm = values_of(instrument.cycle, instrument.axes[2], 3)
    assert arm["counts_per_turn"] == 400000
    assert (arm["min_limit"], arm["max_limit"]) == (-222222, 222222)  # 200 deg of 400000 / 360 counts
    assert arm["quick_stop_deceleration"] == 222222  # 200 deg/s2
    assert arm["following_window"] == 556  # 0.5 deg
    assert (arm["period_units"], arm["period_exponent"]) == (2, -3)
    assert arm["rpdo_cob_id"] == 0x203
    assert arm["firmware_heartbeat"] == 0x007F012C  # node 127, 300 ms
    assert rpdo_deadline_ms(instrument.cycle) == 6
    assert rpdo_deadline_ms(replace(instrument.cycle, sync_period_us=1000)) == 5  # the floor
    assert rpdo_deadline_ms(replace(instrument.cycle, sync_period_us=1700)) == 6  # 5.1 ms
    assert {used.value for used in used_objects() if used.value} <= set(arm)


@pytest.mark.parametrize(
    ("period_us", "expected"), [(2000, (2, -3)), (1250, (125, -5)), (10000, (1, -2)), (7, (7, -6))]
)
def test_periods_are_exact(period_us: int, expected: tuple[int, int]) -> None:
    assert decimal_period(period_us) == expected
    assert same_period(*expected, period_us)
    assert same_period(*(period_us, -6), period_us)
    assert not same_period(expected[0] + 1, expected[1], period_us)
    assert not same_period(period_us * 10 + 1, -7, period_us)
