"""louver.py: the louver of papers [1] and [4] for both sides: a scenario of ours, the same in facets for Radiance.

The profile is worked out here from the scenario's parameters, independently of sim/optics/samples.
"""

from dataclasses import dataclass
from math import asin, atan2, cos, hypot, radians, sin

from .scene import PORT_OUTSIDE_MM, RECEIVER_MM, ArcPiece, LinePiece, Piece, Scene, add_slats

# A slat of ours has no thickness; Radiance's two finishes need two surfaces.
APART_MM = 1e-3


@dataclass(frozen=True)
class Louver:
    """Parameters as in the scenario file; the top is Radiance's metal, the bottom its plastic, both smooth."""

    chord_mm: float = 12.0
    pitch_mm: float = 10.0
    count: int = 39
    length_mm: float = 400.0
    inclination_deg: float = 7.0
    shelf_sagitta_mm: float = 1.0
    retro_sagitta_mm: float = 2.0
    top_reflectance: float = 0.9
    top_specularity: float = 1.0
    bottom_reflectance: float = 0.8

    def scenario(
        self,
        *,
        photons: int,
        seed: int = 1,
        diameter_mm: float = 65.0,
        stop_distance_mm: float = RECEIVER_MM + PORT_OUTSIDE_MM,
        opening_deg: float = 0.5,
    ) -> str:
        """Our scenario file."""
        return f"""seed = {seed}
[sample]
kind = "louver"
chord_mm = {self.chord_mm}
pitch_mm = {self.pitch_mm}
count = {self.count}
length_mm = {self.length_mm}
inclination_deg = {self.inclination_deg}
shelf_sagitta_mm = {self.shelf_sagitta_mm}
retro_sagitta_mm = {self.retro_sagitta_mm}
top = "top"
bottom = "bottom"
[materials.top]
kind = "metal"
reflectance = {self.top_reflectance}
specularity = {self.top_specularity}
roughness = 0.0
[materials.bottom]
kind = "plastic"
reflectance = {self.bottom_reflectance}
specularity = 0.0
roughness = 0.0
[beam]
kind = "collimated"
diameter_mm = {diameter_mm}
edge_deg = 0.0
[source]
opening_angle_deg = {opening_deg}
stop_distance_mm = {stop_distance_mm}
[photons]
count = {photons}
[readings]
incident = [[45.0, 90.0]]
"""

    def radiance(self, facets: int) -> Scene:
        """Each section of a slat as `facets` flat strips."""
        scene = Scene()
        top, bottom = self.top_reflectance, self.bottom_reflectance
        scene.material("top", "metal", top, top, top, self.top_specularity, 0)
        scene.material("bottom", "plastic", bottom, bottom, bottom, 0, 0)
        lift = radians(self.inclination_deg)
        ends = [(along * sin(lift), -along * cos(lift)) for along in (0.0, self.chord_mm / 2, self.chord_mm)]
        profile: list[Piece] = []
        for shift_mm, name in ((0.0, "top"), (-APART_MM, "bottom")):
            (y0, z0), (y1, z1), (y2, z2) = ((y + shift_mm, z) for y, z in ends)
            profile.append(section(y0, z0, y1, z1, self.shelf_sagitta_mm, name))
            profile.append(section(y1, z1, y2, z2, self.retro_sagitta_mm, name))
        half = self.count // 2
        middle = 0.0 if self.count % 2 else 0.5
        slats = [slat + middle for slat in range(-half, self.count - half)]
        add_slats(scene, profile, pitch_mm=self.pitch_mm, slats=slats, half_length_mm=self.length_mm / 2, facets=facets)
        return scene


def section(y0: float, z0: float, y1: float, z1: float, sagitta_mm: float, material: str) -> Piece:
    """An arc from point 0 inwards (z falls) to point 1, sagging by `sagitta_mm` below its chord (negative: above)."""
    if sagitta_mm == 0:
        return LinePiece(y0, z0, y1, z1, material)
    chord = hypot(y1 - y0, z1 - z0)
    radius = (chord**2 / 4 + sagitta_mm**2) / (2 * abs(sagitta_mm))
    # Across the chord, upwards; the axis is there for what sags.
    up_y, up_z = -(z1 - z0) / chord, (y1 - y0) / chord
    side = radius - sagitta_mm if sagitta_mm > 0 else -(radius + sagitta_mm)
    y, z = (y0 + y1) / 2 + side * up_y, (z0 + z1) / 2 + side * up_z
    start, end = atan2(z0 - z, y0 - y), atan2(z1 - z, y1 - y)
    sweep = 2 * asin(chord / (2 * radius))
    # Of the two ways round, the one that ends at point 1.
    ahead = abs(sin(start + sweep) - sin(end)) + abs(cos(start + sweep) - cos(end))
    return ArcPiece(y, z, radius, start, sweep if ahead < 1e-6 else -sweep, material)
