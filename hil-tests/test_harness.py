"""test_harness.py: the harness itself, without a machine: rig files, outcomes, the kernel's inputs, results, initrd."""

import gzip
import json
from dataclasses import replace
from pathlib import Path

import pytest

from harness.bus import Emergency, emergencies
from harness.outcomes import BrokenRigError, Tally
from harness.results import Result, ScenarioFailedError
from harness.rig import RigFileError, load_rig
from kernel.build import Inputs, KernelError, add_driver, check_config
from scenarios.registry import load_scenarios
from vm.initrd import initrd

RIGS = Path(__file__).resolve().parent / "rigs"
HEAD = '[rig]\nname = "r"\nkind = "bench"\n'
BENCH = f'[bench]\nserial = "S1"\ninstrument = "{RIGS / "vm-axes.toml"}"\nwatcher = "can0"\noperator = "a person"\n'


def rig_file(folder: Path, text: str) -> Path:
    path = folder / "rig.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", ["vm.toml", "bench.toml"])
def test_rig_files_of_the_tree_load(name: str) -> None:
    assert load_rig(RIGS / name).file("instrument").is_file()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "[rig] must hold"),
        ("[rig", "cannot be read"),
        ('[rig]\nname = "r"\nkind = "moon"\n', 'rig.kind is "moon"'),
        (HEAD, "beside [rig] there must be [bench]"),
        (HEAD + BENCH + "speed = 1\n", "bench.speed: nobody knows"),
        (HEAD + BENCH.replace('serial = "S1"\n', ""), "bench.serial is missing"),
        (HEAD + BENCH.replace('"S1"', "1"), "bench.serial must be of type str"),
        (HEAD + BENCH.replace("vm-axes", "no-axes"), "there is no file"),
    ],
)
def test_wrong_rig_file_is_refused_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(RigFileError) as caught:
        load_rig(rig_file(tmp_path, text))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bench_is_absent_until_its_serial_is_on_usb(tmp_path: Path) -> None:
    rig = load_rig(rig_file(tmp_path, HEAD + BENCH))
    assert "S1" in str(rig.absent(tmp_path / "usb"))
    device = tmp_path / "usb" / "1-1"
    device.mkdir(parents=True)
    (device / "serial").write_text("S1\n")
    assert rig.absent(tmp_path / "usb") is None


def test_every_outcome_is_counted_and_the_worst_of_a_test_stays() -> None:
    tally = Tally()
    for test, outcome in (("a", "passed"), ("b", "failed"), ("c", "not run"), ("d", "broken rig")):
        tally.add(test, outcome)  # type: ignore[arg-type]
    tally.add("a", "failed")
    tally.add("b", "passed")
    assert tally.counts() == {"passed": 0, "failed": 2, "not run": 1, "broken rig": 1}
    assert tally.line("vm.toml") == "rig vm.toml: 0 passed, 2 failed, 1 not run, 1 broken rig"


def test_kernel_hash_tells_each_input_apart() -> None:
    inputs = Inputs(b"config", b"driver", "1", "gcc")
    others = [
        replace(inputs, config=b"confi", driver=b"gdriver"),
        replace(inputs, driver=b"other"),
        replace(inputs, source_version="2"),
        replace(inputs, compiler="clang"),
    ]
    assert replace(inputs).digest() == inputs.digest()
    assert len({inputs.digest(), *(other.digest() for other in others)}) == 5


def test_option_that_the_kernel_drops_is_an_error() -> None:
    check_config("CONFIG_A=y\n", "CONFIG_A=y\nCONFIG_B=y\n")
    with pytest.raises(KernelError, match="CONFIG_A=y"):
        check_config("CONFIG_A=y\n", "# CONFIG_A is not set\n")


def test_driver_goes_into_the_kernels_tree(tmp_path: Path) -> None:
    folder = tmp_path / "drivers" / "net" / "can"
    folder.mkdir(parents=True)
    (folder / "Makefile").write_text("obj-y += dev/\n")
    add_driver(tmp_path, b"/* driver */")
    assert (folder / "Makefile").read_text().endswith("obj-y += gonio_can_sim.o\n")
    assert (folder / "gonio_can_sim.c").read_bytes() == b"/* driver */"


def result_of(folder: Path, error: dict[str, str] | None) -> Result:
    content: dict[str, object] = {"error": error, "commands": [], "states": {}, "values": {"n": 1}}
    content["goniod_log"] = "goniod.1.err"
    (folder / "s").mkdir()
    (folder / "s" / "result.json").write_text(json.dumps(content))
    return Result(folder, "s")


def test_steps_that_failed_and_a_broken_rig_are_told_apart(tmp_path: Path) -> None:
    for kind, expected in (("failed", ScenarioFailedError), ("broken rig", BrokenRigError)):
        folder = tmp_path / kind
        folder.mkdir()
        with pytest.raises(expected):
            result_of(folder, {"kind": kind, "text": "why"}).require_steps()
    result_of(tmp_path, None).require_steps()


def test_scenario_without_result_is_a_broken_rig(tmp_path: Path) -> None:
    with pytest.raises(BrokenRigError, match="left no result"):
        Result(tmp_path, "s")


def test_emergencies_are_read_from_a_log_with_their_times(tmp_path: Path) -> None:
    log = tmp_path / "candump"
    lines = ["(5.900000) can0 083#3081110000000000", "(6.000000) can0 080#", "(6.000001) can0 083#5082110100000000"]
    lines += ["(6.100000) can0 084#0000000000000000", "(6.200000) can0 183#5082110100000000", "(6.3000"]
    log.write_text("\n".join(lines))
    assert emergencies(log, 6.0, 7.0) == [Emergency(6.000001, 3, 0x8250)]


def test_every_scenario_marker_names_a_scenario() -> None:
    names = {scenario.name for scenario in load_scenarios()}
    wanted = set()
    for path in Path(__file__).resolve().parent.rglob("test_*.py"):
        for line in path.read_text().splitlines():
            if line.startswith("@pytest.mark.scenario("):
                wanted.add(line.split('"')[1])
    assert wanted == names


def test_initial_root_is_a_newc_archive_with_init(tmp_path: Path) -> None:

    extra = tmp_path / "extra"
    extra.write_text("content")
    archive = gzip.decompress(initrd([extra]))
    assert archive.startswith(b"070701")
    assert b"TRAILER!!!" in archive
    for name in (b"init\0", b"bin/busybox\0", str(extra).lstrip("/").encode() + b"\0"):
        assert name in archive
