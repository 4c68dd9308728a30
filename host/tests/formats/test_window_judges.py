"""test_window_judges.py: independent programs load what we write: Radiance's BSDF reader, WINDOW's engine, xmlschema.

Each check is a process of its own: the readers can crash when one process loads many files.
"""

import json
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xmlschema
from synthetic_bsdf import distribution, lambert_and_mirror, lobe_per_sr, sphere_points, spiral_about

from gonio.dataset.bsdf import Dataset
from gonio.formats.window import read as window_reader
from gonio.formats.window import write as window_xml
from gonio.formats.window.klems import BASES
from gonio.formats.window.matrices import BANDS, KlemsMatrices, build

pytestmark = pytest.mark.judge

RADIANCE = """
import json, sys
import pyradiance.bsdf as b
job = json.load(sys.stdin)
sd = b.load_file(job["path"])
print(json.dumps({
    "values": [float(b.query(sd, *q)[1]) for q in job["queries"]],
    "hemi": [[b.direct_hemi(sd, t, p, b.SAMPLE_ALL & ~b.SAMPLE_R), b.direct_hemi(sd, t, p, b.SAMPLE_ALL & ~b.SAMPLE_T)]
             for t, p in job["hemi"]],
}))
"""
WINDOW = """
import json, sys
import pywincalc as p
product = p.parse_bsdf_xml_file(sys.argv[1])
standard = p.load_standard(str(p.standard_path / "W5_NFRC_2003.std"))
basis = p.BSDFHemisphere.create(p.BSDFBasisType.FULL)
system = p.GlazingSystem(optical_standard=standard, solid_layers=[product], bsdf_hemisphere=basis)
out = []
for method, theta, phi in json.loads(sys.argv[2]):
    r = system.optical_method_results(method, theta, phi).system_results
    out.append([s.direct_hemispherical for s in (r.front.transmittance, r.back.transmittance,
                                                 r.front.reflectance, r.back.reflectance)])
print(json.dumps(out))
"""


def radiance(path: Path, queries: list[list[float]], hemi: list[list[float]] | None = None) -> dict[str, Any]:
    job = json.dumps({"path": str(path), "queries": queries, "hemi": hemi or []})
    done = subprocess.run([sys.executable, "-c", RADIANCE], input=job, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def window(path: Path, cases: list[tuple[str, float, float]]) -> list[list[float]]:
    command = [sys.executable, "-c", WINDOW, str(path), json.dumps(cases)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return list(json.loads(done.stdout))


@pytest.mark.parametrize("basis", ["klems-full", "klems-half", "klems-quarter"])
def test_xmlschema_accepts_it(tmp_path: Path, basis: str) -> None:
    path = tmp_path / "bsdf.xml"
    window_xml.write(lambert_and_mirror(), path, basis=basis, fill="nearest", assume_flat=True)
    schema = xmlschema.XMLSchema((files("gonio.formats") / "data" / "BSDF-v1.7.7.xsd").read_text(encoding="utf-8"))
    schema.validate(str(path))


def test_windows_engine_computes_our_hemispherical_values(tmp_path: Path) -> None:
    path = tmp_path / "bsdf.xml"
    dataset = lambert_and_mirror()
    built = window_xml.write(dataset, path, fill="nearest", assume_flat=True)
    size = built.basis.projected_solid_angle_sr
    cases = [("PHOTOPIC", 0.0, 0.0), ("PHOTOPIC", 30.0, 0.0), ("SOLAR", 60.0, 0.0)]
    for (_, theta, phi), found in zip(cases, window(path, cases), strict=True):
        column = int(built.basis.patch_of(theta, phi))
        block = built.bands["Visible"].matrices
        order = [(p, s) for p in ("Transmission", "Reflection") for s in ("Front", "Back")]
        expected = [float(size @ block[key][:, column]) for key in order]
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-9)


def test_radiance_computes_our_hemispherical_values(tmp_path: Path) -> None:
    path = tmp_path / "bsdf.xml"
    built = window_xml.write(lambert_and_mirror(), path, fill="nearest")
    size = built.basis.projected_solid_angle_sr
    # Light from the exterior: Radiance's theta_i over 90; our front faces the exterior.
    found = radiance(path, [], [[180.0, 0.0], [150.0, 180.0], [120.0, 180.0]])["hemi"]
    for theta, (tau, rho) in zip((0.0, 30.0, 60.0), found, strict=True):
        column = int(built.basis.patch_of(theta, 0.0))
        block = built.bands["Visible"].matrices
        # Radiance drops what is not Lambertian when it is under 0.01 in all, which is so in transmission here.
        assert tau == pytest.approx(float(size @ block["Transmission", "Front"][:, column]), abs=1e-3)
        assert rho == pytest.approx(float(size @ block["Reflection", "Front"][:, column]), rel=1e-3)


@pytest.mark.parametrize(
    ("process", "side", "incident", "outgoing"),
    [
        ("Transmission", "Front", (140, 180), (40, 90)),
        ("Transmission", "Back", (40, 180), (140, 90)),
        ("Reflection", "Front", (140, 180), (140, 90)),
        ("Reflection", "Back", (40, 180), (40, 90)),
    ],
)
def test_radiance_answers_the_four_tried_mappings(tmp_path: Path, process, side, incident, outgoing) -> None:  # type: ignore[no-untyped-def]
    basis = BASES["klems-full"]
    empty = build(Dataset([lambert_and_mirror((30.0,)).distributions[0]], front_faces="interior"))
    for band in BANDS:
        for matrix in empty.bands[band].matrices.values():
            matrix[:] = 0.0
    column, row = int(basis.patch_of(40, 0)), int(basis.patch_of(40, 90))
    empty.bands["Visible"].matrices[process, side][row, column] = 0.7
    path = tmp_path / "single.xml"
    path.write_bytes(
        window_xml.render(Dataset([]), KlemsMatrices(basis, empty.bands, "interior"), window_xml.ThermalValues())
    )
    others = [(180 - t, p) for t, p in (outgoing,)] + [(outgoing[0], 270), (outgoing[0], 0), (outgoing[0], 180)]
    values = radiance(path, [[*incident, *o] for o in [outgoing, *others]])["values"]
    assert values[0] == pytest.approx(0.7, rel=5e-4)
    assert max(values[1:]) < 0.01


@pytest.mark.parametrize("front_faces", ["exterior", "interior"])
@pytest.mark.parametrize(
    ("incident", "lobe"),
    [
        ((40.0, 30.0), (40.0, 105.0)),  # front, reflected up and to the left
        ((40.0, 285.0), (120.0, 30.0)),  # front, through
        ((140.0, 15.0), (60.0, 285.0)),  # back, through
        ((120.0, 105.0), (140.0, 75.0)),  # back, reflected
    ],
)
def test_radiance_answers_an_asymmetric_fixture(tmp_path: Path, front_faces, incident, lobe) -> None:  # type: ignore[no-untyped-def]
    """Front and back, left and right, up and down: only the lobe's own direction answers."""
    units = np.concatenate([sphere_points(2000), spiral_about(*lobe, 5.0, 0.5)])
    part = distribution(incident, units, lambda u: lobe_per_sr(u, lobe, 0.3))
    path = tmp_path / "asymmetric.xml"
    window_xml.write(Dataset([part], front_faces=front_faces), path)
    peak = max(float(m.max()) for m in window_reader.read(path).matrices.values())

    def turned(theta: float, phi: float) -> list[float]:
        """Radiance's frame: about y by half a turn when the front faces the exterior."""
        return [theta, phi] if front_faces == "interior" else [180 - theta, (180 - phi) % 360]

    theta, phi = lobe
    flipped = [(180 - theta, phi), (theta, 180 - phi), (theta, -phi), (theta, phi + 180)]
    queries = [[*turned(*incident), *turned(*o)] for o in [lobe, *flipped]]
    wrong_side = [*turned(180 - incident[0], incident[1]), *turned(*lobe)]
    values = radiance(path, [*queries, wrong_side])["values"]
    assert values[0] == pytest.approx(peak, rel=5e-4)
    assert max(values[1:]) < 0.01 * peak
