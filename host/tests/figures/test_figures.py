"""test_figures.py: the figures of the spine, through firmware, twin and command line (level 1)."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import figures
from gonio.dataset.bsdf import PointFlag

pytestmark = pytest.mark.twin


@pytest.mark.parametrize("work", [figures.lambertian, figures.lobe, figures.pairing])
def test_figures_are_kept(work, tmp_path: Path) -> None:
    found = work(tmp_path)
    assert [figure for figure in found if not figure.kept] == []
    assert any(figure.limit is not None for figure in found)


def losses_in_motion(folder: Path) -> Path:
    """The scenario of pairing.toml with the losses of fault_losses.toml, moved into the sinusoid (the second path)."""
    axes = figures.SCENARIOS / "pairing-axes.toml"
    text = (figures.SCENARIOS / "pairing.toml").read_text().replace('"pairing-axes.toml"', f'"{axes}"')
    faults = (figures.SCENARIOS / "fault_losses.toml").read_text().split("[[fault]]")[1:]
    moved = ["[[fault]]" + fault.replace("after_path = 1", "after_path = 2") for fault in faults]
    scenario = folder / "losses.toml"
    scenario.write_text("\n".join([text, *moved]))
    return scenario


def test_losses_leave_flags_and_no_wrong_directions(tmp_path: Path) -> None:
    recording = figures.Recording.make(tmp_path, losses_in_motion(tmp_path))
    found = figures.Pairing.of(recording)
    counters = [event.counters for event in recording.log.events if event.WhichOneof("body") == "counters"][-1]
    assert counters.packets_lost == 1
    assert counters.samples_lost > 0
    assert counters.strobes_lost >= 4
    assert counters.strobes_rejected >= 1
    assert counters.tpdo_missing > 0
    assert counters.tpdo_late + counters.tpdo_duplicate > 0
    # Every sample that came has its own number and time, across the lost packet and the packet counter's wrap.
    assert np.abs(found.clock_error_us).max() < 5.0
    missing = np.diff(recording.log.sample_number.astype(np.int64)) - 1
    assert missing.sum() == counters.samples_lost
    # A lost pose has no reading; every reading is right.
    lost = (found.flags & PointFlag.POSE_LOST) != 0
    assert np.array_equal(lost, np.isnan(found.paired_deg).any(axis=1))
    assert found.error_deg(found.paired_deg)[~lost].max() < 0.002
    assert np.count_nonzero(found.flags & PointFlag.INTERPOLATED_POSE) > 0
    assert np.count_nonzero(lost) < 0.01 * len(lost)
