"""fuzz_asked_table.py: any bytes as a table of directions end in a table as long as it, or in one UsageError."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    import numpy as np
    from inputs import changed, one_line

    from gonio.formats import asked_table
    from gonio.formats.asking import Answers, Reason

SEED = (
    b"# a comment\nname,theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg\n"
    b'a,0,0,10,20\n"b, quoted",30,45,150,350\n\nc,-30,45,90,1e1\nd,x,,nan,inf\ne,1\nf,1,2,3,4,5\n'
)
FOLDER = Path(tempfile.mkdtemp(prefix="gonio-fuzz-"))
SOURCE, TARGET = FOLDER / "in.csv", FOLDER / "out.csv"


def ask(incident: np.ndarray, outgoing: np.ndarray, which: np.ndarray) -> Answers:  # type: ignore[type-arg]
    """As long as asked; half of the values are missing."""
    if which.max() >= len(incident) or len(which) != len(outgoing):
        raise ValueError("rows do not fit")
    n = len(outgoing)
    value = np.where(np.arange(n) % 2 == 0, 0.5, np.nan)
    reason = np.where(np.isnan(value), Reason.ABSENT, Reason.NONE).astype(np.uint8)
    return Answers(value, value, np.zeros(n, dtype=np.uint8), reason)


def one_input(data: bytes) -> None:
    SOURCE.write_bytes(changed(data, (SEED,)))
    asked_table.ROWS_AT_ONCE = 1 + len(data) % 5
    with one_line():
        asked_table.answer(SOURCE, TARGET, ask)
        before, after = (
            path.read_text(encoding="utf-8-sig", errors="surrogateescape").count("\n") for path in (SOURCE, TARGET)
        )
        if after < before:
            raise ValueError("lines were lost")


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
