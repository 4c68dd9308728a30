"""write.py: tensor tree XML as Radiance reads it, from any Bsdf, with what is known of where its values come from."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.sax.saxutils import escape

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, Origin
from gonio.formats import atomic, validity
from gonio.formats.tensor.build import Built, Limit, build
from gonio.formats.tensor.cells_table import cells_table, origin_shares
from gonio.formats.tensor.material import material_text
from gonio.units.errors import UsageError

LEAST_RESOLUTION, MOST_RESOLUTION = 2, 9
DEFAULT_RESOLUTION = {3: 7, 4: 5}  # of four dimensions every step of the resolution makes 16 times the cells
DEFAULT_MB = 2.0  # of a file without a limit
BANDS = ("Visible", "Solar")
TRISTIMULUS = ("CIE-X", "CIE-Y", "CIE-Z")
# Channels that the reader makes of bands; CIE-X and CIE-Z keep their names.
_READ_AS = {"Visible": "visible", "Solar": "solar", "CIE-Y": "visible"}
_HEADER_BYTES = 6000  # at most, of elements and what is said of the trees


def write_tensor(
    bsdf: Bsdf,
    path: Path,
    *,
    dimensions: int,
    resolution: int | None = None,
    leaves: int | None = None,
    size_mb: float | None = None,
    percent: float | None = None,
    front: Side | None = None,
    channels: dict[str, str] | None = None,
    rescale: bool = False,
    material: Path | None = None,
    cells: Path | None = None,
) -> list[str]:
    """Writes a tensor tree, whole or not at all, and returns remarks, one sentence each.

    `dimensions`: 3 for a sample that is declared isotropic, else 4. `resolution` k: the finest cells are 2^-k of an
    axis; None: DEFAULT_RESOLUTION. One limit of the file: `leaves`, `size_mb` (10^6 bytes), or `percent`, the share of
    a full tree's leaves to take away by the measure of Radiance's rttree_reduce. `channels`: names of ours for Visible
    and Solar, or for CIE-X, CIE-Y and CIE-Z. `material`: a file for Radiance with the materials that use this one;
    `cells`: a CSV of all leaves with their origin. Raises UsageError where something is undeclared or cannot be
    written, CheckFailed where energy exceeds 1.
    """
    faces = bsdf.front_faces if front is None else front
    _check(bsdf, dimensions, resolution, [leaves, size_mb, percent])
    k = DEFAULT_RESOLUTION[dimensions] if resolution is None else resolution
    wanted = _channels(bsdf, channels)
    if leaves is None and percent is None:
        size_mb = DEFAULT_MB if size_mb is None else size_mb
    said = list(_comments(bsdf, faces, wanted))
    room = None if size_mb is None else size_mb * 1e6 - _HEADER_BYTES - sum(map(len, said))
    if room is not None and room <= 0:
        raise UsageError(f"{size_mb:g} MB are less than what a file says beside its tree: allow more")
    built = build(bsdf, wanted, faces, dimensions, k, Limit(leaves, room, percent), rescaled=rescale)
    document = _document(bsdf, built, dimensions, [*said, *built.remarks, *_origins(built)])
    files = {path: document}
    if material is not None:
        files[material] = material_text(path, view_through=built.view_through)
    if cells is not None:
        files[cells] = cells_table(built, path.name)
    atomic.write_set(files)
    count = sum(own.chosen.leaves for own in built.leaves.values())
    remarks = [*built.remarks, f"{count} leaves, resolution {k}, {len(document) / 1e6:.3f} MB."]
    if dimensions == 4 and bsdf.symmetry == "isotropic":
        remarks.append("The sample is isotropic: 3 dimensions (tensor3) hold all of it, finer, in a file of this size.")
    return remarks


def _check(bsdf: Bsdf, dimensions: int, resolution: int | None, limits: list[int | float | None]) -> None:
    if dimensions not in (3, 4):
        raise UsageError(f"a tensor tree has 3 or 4 dimensions, not {dimensions}")
    if resolution is not None and not LEAST_RESOLUTION <= resolution <= MOST_RESOLUTION:
        raise UsageError(f"resolution {resolution}: choose {LEAST_RESOLUTION} to {MOST_RESOLUTION}")
    if dimensions == 3 and bsdf.symmetry != "isotropic":
        raise UsageError(
            f"a tree of 3 dimensions is for isotropic samples, this one is declared {bsdf.symmetry}: write 4 dimensions"
        )
    given = [limit for limit in limits if limit is not None]
    if len(given) > 1:
        raise UsageError("leaves, size and percentage exclude each other: give one limit")
    if any(not limit > 0 for limit in given):
        raise UsageError("a limit of the tree must be over 0")
    if limits[2] is not None and not limits[2] < 100:
        raise UsageError("the percentage of leaves to take away must be below 100")


def _channels(bsdf: Bsdf, channels: dict[str, str] | None) -> dict[str, str]:
    """Channel of each wavelength of the file."""
    if not channels:
        named = [name for name in bsdf.channels if name.lower() in ("visible", "photopic")]
        if len(bsdf.channels) != 1 and len(named) != 1:
            raise UsageError(f"it is not clear which channel is visible: choose one of {', '.join(bsdf.channels)}")
        return {"Visible": named[0] if named else next(iter(bsdf.channels))}
    for band, name in channels.items():
        if band not in (*BANDS, *TRISTIMULUS):
            raise UsageError(f"a tensor tree holds {', '.join((*BANDS, *TRISTIMULUS))}, not {band!r}")
        if name not in bsdf.channels:
            raise UsageError(f"there is no channel {name!r}: choose one of {', '.join(bsdf.channels)}")
    colours = [band for band in TRISTIMULUS if band in channels]
    if colours and (len(colours) != 3 or "Visible" in channels):
        raise UsageError("colour needs CIE-X, CIE-Y and CIE-Z and no Visible, whose place Y takes")
    return dict(channels)


def _comments(bsdf: Bsdf, faces: Side, channels: dict[str, str]) -> Iterator[str]:
    """What does not depend on the trees."""
    yield "Written by gonio. Values are averages over the cells of the tree."
    if faces != "undeclared":
        yield f"{validity.FRONT_SENTENCE}{'front' if faces == 'exterior' else 'back'}."
    yield f"Polarisation {bsdf.polarisation}; symmetry {bsdf.symmetry} (as declared)."
    for band, name in channels.items():
        if band.lower() != name.lower():
            yield f"{band} holds channel {name}."
    yield from bsdf.validity
    held = {_READ_AS.get(band, band): bsdf.channels[name] for band, name in channels.items()}
    yield validity.line(replace(bsdf, front_faces=faces, channels=held))


def _origins(built: Built) -> Iterator[str]:
    for block, shares in origin_shares(built).items():
        parts = [
            f"{share:.1%} {origin.name.lower()}" for origin, share in zip(Origin, shares, strict=True) if share > 0.0
        ]
        yield f"{block}, by projected solid angle: {', '.join(parts)}."


def _document(bsdf: Bsdf, built: Built, dimensions: int, comments: list[str]) -> bytes:
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<WindowElement xmlns="http://windows.lbl.gov">',
        "<WindowElementType>System</WindowElementType>",
        "<FileType>BSDF</FileType>",
        "<Optical>",
        "<Layer>",
        "<Material>",
        f"<Name>{_plain(bsdf.sample_name or 'unnamed sample')}</Name>",
        f"<Manufacturer>{_plain(bsdf.manufacturer or 'not stated')}</Manufacturer>",
    ]
    if bsdf.thickness_mm is not None:
        lines.append(f'<Thickness unit="Millimeter">{bsdf.thickness_mm:g}</Thickness>')
    lines += [
        "<DeviceType>Other</DeviceType>",
        f"<Comments>{_plain(' '.join(comments))}</Comments>",
        "</Material>",
        "<DataDefinition>",
        f"<IncidentDataStructure>TensorTree{dimensions}</IncidentDataStructure>",
        "</DataDefinition>",
    ]
    for (wavelength, component), text in built.text.items():
        lines += [
            "<WavelengthData>",
            "<LayerNumber>System</LayerNumber>",
            f'<Wavelength unit="Integral">{wavelength}</Wavelength>',
            "<WavelengthDataBlock>",
            f"<WavelengthDataDirection>{component}</WavelengthDataDirection>",
            "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>",
            "<ScatteringDataType>BTDF</ScatteringDataType>",
            f"<ScatteringData>{text}</ScatteringData>",
            "</WavelengthDataBlock>",
            "</WavelengthData>",
        ]
    lines += ["</Layer>", "</Optical>", "</WindowElement>", ""]
    return "\n".join(lines).encode()


def _plain(text: str) -> str:
    """For XML, which cannot hold control characters."""
    return escape("".join(c if c.isprintable() or c == "\n" else " " for c in text))
