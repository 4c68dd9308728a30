"""test_bench_sim.py: the benchmark beside Radiance runs and writes its rows; --quick says nothing about speed."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]


@pytest.mark.judge
def test_quick_benchmark_writes_its_rows(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "host/benchmarks/bench_sim.py"), str(tmp_path), "--quick"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "Radiance mkpmap + rtrace" in done.stdout
    result = json.loads((tmp_path / "bench_sim.json").read_text())
    rows = {row["name"]: row for row in result["rows"]}
    assert result["bench"] == "bench_sim"
    assert rows["Klems full at genBSDF's error of 2000 samples"]["peer"] > 0
    # Few photons: the readings' integral is still what arrived, to their own precision.
    assert rows["bias of the hemispherical integral"]["ours"] < 0.1
