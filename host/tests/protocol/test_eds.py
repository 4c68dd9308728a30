"""The twin's electronic data sheets, read by an independent program (python-canopen)."""

from pathlib import Path

import canopen
import pytest

EDS_DIRECTORY = Path(__file__).parents[3] / "protocol" / "eds"
PERSONALITIES = ("full", "basic", "fixed")
# What the firmware and a commissioning tool meet in every personality.
COMMON = (
    *(0x1000, 0x1001, 0x1003, 0x1005, 0x1006, 0x1007, 0x1008, 0x1014, 0x1016, 0x1017, 0x1018, 0x1019, 0x1200),
    *(0x1400, 0x1401, 0x1600, 0x1601, 0x1800, 0x1801, 0x1A00, 0x1A01),
    *(0x603F, 0x6040, 0x6041, 0x605A, 0x605C, 0x605E, 0x6060, 0x6061, 0x6062, 0x6064, 0x6065, 0x6066, 0x606C),
    *(0x607A, 0x607C, 0x607D, 0x6081, 0x6083, 0x6084, 0x6085, 0x608F, 0x6091, 0x6092, 0x6098, 0x6099, 0x609A),
    *(0x60B0, 0x60C2, 0x60C5, 0x60F4, 0x60FD, 0x60FE, 0x6502),
)


def dictionary(personality: str, node: int = 3) -> canopen.ObjectDictionary:
    return canopen.import_od(str(EDS_DIRECTORY / f"gonio_{personality}.eds"), node_id=node)


def mapping(od: canopen.ObjectDictionary, index: int) -> list[int]:
    return [od[index][k].default for k in range(1, od[index][0].default + 1)]


@pytest.mark.parametrize("personality", PERSONALITIES)
def test_every_common_object_is_there_with_a_value_inside_its_limits(personality: str) -> None:
    od = dictionary(personality)
    assert set(COMMON) <= set(od)
    entries = [entry for index, entry in od.items() if index >= 0x1000]  # below are the dummies for gaps in PDOs
    variables = [v for entry in entries for v in (entry.values() if hasattr(entry, "values") else [entry])]
    assert len(variables) > 100
    for variable in variables:
        assert variable.default is not None, variable.name
        if isinstance(variable.default, int):
            assert variable.min is None or variable.default >= variable.min, variable.name
            assert variable.max is None or variable.default <= variable.max, variable.name


@pytest.mark.parametrize("personality", PERSONALITIES)
def test_sub_object_0_counts_the_entries(personality: str) -> None:
    od = dictionary(personality)
    for index in (0x1016, 0x1018, 0x1200, 0x1400, 0x1800, 0x607D, 0x608F, 0x6091, 0x6092, 0x6099, 0x60C2, 0x60FE):
        assert od[index][0].default == max(od[index]), hex(index)


@pytest.mark.parametrize("personality", PERSONALITIES)
def test_identifiers_follow_the_node(personality: str) -> None:
    for node in (1, 4, 127):
        od = dictionary(personality, node)
        assert od[0x1014].default == 0x80 + node
        assert od[0x1200][1].default == 0x600 + node
        assert od[0x1400][1].default == 0x200 + node
        assert od[0x1800][1].default & 0x7FF == 0x180 + node


@pytest.mark.parametrize("personality", PERSONALITIES)
def test_default_mappings_are_of_mappable_objects_with_their_lengths(personality: str) -> None:
    od = dictionary(personality)
    for index in (0x1600, 0x1601, 0x1A00, 0x1A01):
        total_bits = 0
        for entry in mapping(od, index):
            mapped = od[entry >> 16]
            variable = mapped if isinstance(mapped, canopen.objectdictionary.ODVariable) else mapped[entry >> 8 & 0xFF]
            assert variable.pdo_mappable, variable.name
            assert variable.writable if index < 0x1A00 else variable.readable, variable.name
            assert len(variable) == entry & 0xFF, variable.name
            total_bits += entry & 0xFF
        assert total_bits <= 64


def test_full_has_all_that_the_others_lack() -> None:
    full, basic, fixed = (dictionary(personality) for personality in PERSONALITIES)
    assert set(full) - set(basic) == {0x6007, 0x1029}
    assert 0x6007 in fixed
    assert 0x1029 in fixed
    assert full[0x60C2][1].writable
    assert not basic[0x60C2][1].writable
    assert basic[0x60C2][1].default * 10.0 ** basic[0x60C2][2].default == pytest.approx(0.002)


def test_the_fixed_map_is_constant_and_the_window_off() -> None:
    fixed = dictionary("fixed")
    assert mapping(fixed, 0x1600) == [0x60400010, 0x607A0020, 0x60600008]
    assert mapping(fixed, 0x1A00) == [0x60410010, 0x60640020, 0x60610008]
    for index in (0x1600, 0x1601, 0x1A00, 0x1A01):
        assert not any(variable.writable for variable in fixed[index].values())
    assert fixed[0x6065].default == 0xFFFFFFFF
    assert dictionary("full")[0x6065].default != 0xFFFFFFFF
