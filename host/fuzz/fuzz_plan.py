"""fuzz_plan.py: any bytes as a plan file end in a plan or in one UsageError, never in another exception."""

import re
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    from inputs import one_line

    from gonio.plan.schema import load_plan

SEED = b"""[sample]
name = "tile"
thickness_mm = 3.0
[beam]
kind = "focused"
diameter_mm = 10.0
divergence_deg = 1.0
[scan]
speed_deg_per_s = 30.0
incident = [[0, 0], [30, 0]]
[reference]
radius_deg = 2.0
pitch_deg = 0.5
[coarse]
pitch_deg = 6.0
sphere = "whole"
[[peak]]
about = "mirror"
radius_deg = 5
pitch_deg = 1
for_incident = [[30, 0]]
[dark]
duration_s = 1.0
"""
PARTS = re.split(rb"(?<== )(.+)", SEED)  # text, value, text, value, ..., text
PLAN = Path(tempfile.mkdtemp(prefix="gonio-fuzz-")) / "plan.toml"


def one_input(data: bytes) -> None:
    if len(data) > 2 and data[0] >= 128:  # a good plan with one value replaced
        parts = list(PARTS)
        parts[1 + 2 * (data[1] % (len(parts) // 2))] = data[2:]
        data = b"".join(parts)
    PLAN.write_bytes(data)
    with one_line():
        load_plan(PLAN)


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
