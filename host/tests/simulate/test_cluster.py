"""test_cluster.py: the same bits from threads and from Dask workers, though one dies; what a scheduler cannot do."""

import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gonio.simulate import cluster
from gonio.simulate.bundle import Bundle, pack
from gonio.simulate.campaign import Effort, run
from gonio.simulate.cluster import ClusterCrew, connected
from gonio.simulate.directions import rings
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import Job, Part
from gonio.simulate.tracing import Laboratory, LocalCrew
from gonio.units.errors import UsageError

HALF_ANGLE_RAD = 0.05
EFFORT = Effort(40_000, relative_error=0.3, most_photons=400_000)


def jobs() -> list[Job]:
    """Two incident directions."""
    return [Job("visible", (theta, 0.0), True, rings(10.0)) for theta in (0.0, 45.0)]


def write_scenario(folder: Path) -> Path:
    """With files in it that are named from below and from above."""
    (folder / "deep").mkdir(parents=True)
    (folder / "axes.toml").write_text("[instrument]\narm_radius_mm = 500.0\ndetector_aperture_mm = 20.0\n")
    path = folder / "deep" / "white.toml"
    path.write_text('instrument = "../axes.toml"\nseed = 5\n[sample]\nkind = "lambertian"\nreflectance = 0.5\n')
    return path


def killing(marker: Path, task: Callable[..., Part]) -> Callable[..., Any]:
    """The task, but whoever runs it first dies of it."""

    def kill_or_trace(*arguments: Any) -> Any:
        try:
            os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            return task(*arguments)
        os.kill(os.getpid(), signal.SIGKILL)
        return None

    return kill_or_trace


def test_a_lost_worker_changes_no_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bundle = pack(write_scenario(tmp_path / "here"), None, ("visible",))
    progress = PhotonProgress()
    local = LocalCrew(Laboratory(bundle, tmp_path / "here" / "deep" / "white.toml"), 2, progress)
    plain = run(jobs(), EFFORT, HALF_ANGLE_RAD, local, progress)
    assert all(reading.balance["photons"] > EFFORT.photons for reading in plain)  # there was more than one round
    marker = tmp_path / "somebody died"
    monkeypatch.setattr(cluster, "trace_range", killing(marker, cluster.trace_range))
    with connected(None, 2) as client:
        crew = ClusterCrew(client, bundle, least_photons=7_000)
        divided = run(jobs(), EFFORT, HALF_ANGLE_RAD, crew, progress)
    assert marker.exists()
    for one, other in zip(plain, divided, strict=True):
        np.testing.assert_array_equal(one.signal_per_sr, other.signal_per_sr)
        np.testing.assert_array_equal(one.error_per_sr, other.error_per_sr)
        np.testing.assert_array_equal(one.hits, other.hits)
        assert one.balance == other.balance


def test_a_bundle_unpacks_as_it_lay(tmp_path: Path) -> None:
    bundle = pack(write_scenario(tmp_path / "here"), 3, ("visible",))
    assert set(bundle.files) == {"white.toml", "../axes.toml"}
    there = bundle.unpack(tmp_path / "there")
    assert there.read_bytes() == bundle.files["white.toml"]
    assert (there.parent / "../axes.toml").read_bytes() == bundle.files["../axes.toml"]
    assert bundle.digest != Bundle(bundle.scenario, bundle.files, bundle.tables, 4).digest


def test_a_scheduler_that_is_not_there() -> None:
    with pytest.raises(UsageError, match="cannot connect"), connected("nonsense://127.0.0.1:1", 0):
        pass
