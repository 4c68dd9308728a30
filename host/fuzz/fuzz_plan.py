"""fuzz_plan.py: any bytes as a plan file end in a plan or in one UsageError, never in another exception."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    from gonio.plan.schema import load_plan
    from gonio.units.errors import UsageError

SEED = b'[scan]\nincident = [[0, 0], [30, 0]]\n[coarse]\npitch_deg = 6.0\n[[peak]]\nabout = "mirror"\nradius_deg = 5\n'
PLAN = Path(tempfile.mkdtemp(prefix="gonio-fuzz-")) / "plan.toml"


def one_input(data: bytes) -> None:
    cut = data[0] % len(SEED) if data else 0
    PLAN.write_bytes(SEED[:cut] + data[1:] if data[:1] >= b"\x80" else data)
    try:
        load_plan(PLAN)
    except UsageError as error:
        if "\n" in str(error):
            raise ValueError("an error is one line") from error


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
