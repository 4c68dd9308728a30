"""options.py: what a user may choose of a reduction; all of it is in the file's provenance."""

from dataclasses import dataclass
from typing import Any

from gonio.reduce.coverage import REACH_FACTOR
from gonio.units.errors import UsageError


@dataclass(frozen=True)
class ReduceOptions:
    """`bin_deg`: successive samples of the coarse pass are joined over so many degrees of track; 0: never."""

    bin_deg: float = 0.0
    without: tuple[str, ...] = ()  # names of corrections.chain.NAMES
    reach_factor: float = REACH_FACTOR  # no point owns area farther than this times the local pitch of its path
    calibration_text: str = ""  # TOML with a table [calibration] that goes before the instrument's own
    calibration_name: str = "--calibration"  # of the file it is from, for errors
    p_i: float | None = None  # declared, counts * sr: for a scan without a reference scan
    p_i_u: float = 0.0  # its standard uncertainty, counts * sr

    def __post_init__(self) -> None:
        if not self.reach_factor > 0.0:
            raise UsageError(f"--reach {self.reach_factor:g}: it must be more than 0; 1.5 is usual")
        if self.p_i is None and self.p_i_u:
            raise UsageError("--p-i-u: it is the uncertainty of --p-i, which is missing")
        if self.p_i is not None and not (0.0 < self.p_i < float("inf") and 0.0 <= self.p_i_u < float("inf")):
            raise UsageError(f"--p-i {self.p_i:g} with --p-i-u {self.p_i_u:g}: P_i is more than 0, its u is 0 or more")


@dataclass(frozen=True)
class OtherBeam:
    """The free beam of another scan of the same instrument: `facts` is "beam" of that dataset's provenance."""

    name: str  # of the file
    facts: dict[str, Any]
