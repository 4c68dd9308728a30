"""size.py: how much work a run of the judges is."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Size:
    """Points per direction, resolutions and so on."""

    points: int
    many_points: int
    resolutions: tuple[int, ...]  # of Radiance's trees; ours is held against the file of the first
    ceilings: tuple[int, ...]
    finest: int  # k of our trees
    large_mb: float
    left_out_deg: tuple[float, ...]
    photons: int
    anisotropic_k: int


FULL = Size(20_000, 300_000, (7, 8), (7, 8, 9), 9, 8.0, (40.0, 20.0, 60.0), 4_000_000, 5)
QUICK = Size(3_000, 6_000, (5, 6), (5, 6), 6, 0.5, (40.0,), 100_000, 4)
