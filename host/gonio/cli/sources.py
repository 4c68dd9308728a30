"""sources.py: a BSDF from any file that can be asked: dataset, model, matrices, tensor tree, tables of points."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gonio.dataset.bsdf import Dataset, Side, Symmetry
    from gonio.dataset.scattering import Bsdf
    from gonio.formats.findings import Findings

FileKind = Literal["dataset", "model", "matrices", "tree", "points"]
_HDF5 = b"\x89HDF\r\n\x1a\n"
_RAW_LOG = b"\x89MCAP"
_INSTEAD = {
    "model": "is a fitted model: name the dataset that it was fitted to",
    "matrices": "is BSDF XML: gonio import makes a dataset of it",
    "tree": "is a tensor tree in XML: gonio import makes a dataset of it",
    "points": "is a table of points: gonio import makes a dataset of it",
}
_MOST_SAID = 10


def kind_of(path: Path) -> FileKind:
    """What a file is, by its content. Raises UsageError where it cannot be read or is nothing of that."""
    from gonio.formats.detect import beginning_of, looks_like_points, looks_like_xml
    from gonio.formats.tensor.read import is_tensor

    beginning = beginning_of(path)
    if beginning.startswith(_HDF5):
        from gonio.model.model_file import is_model

        return "model" if is_model(path) else "dataset"
    if looks_like_xml(beginning):
        return "tree" if is_tensor(path) else "matrices"
    if beginning.startswith(_RAW_LOG):
        raise UsageError(f"{path}: is a raw log: gonio reduce makes a dataset of it")
    if not looks_like_points(beginning):
        raise UsageError(
            f"{path}: is no dataset, fitted model, BSDF XML nor table of points that gonio knows: name another file"
        )
    return "points"


def check_dataset(path: Path) -> None:
    """UsageError where a file is no dataset: what it is, and which command makes one of it."""
    kind = kind_of(path)
    if kind != "dataset":
        raise UsageError(f"{path}: {_INSTEAD[kind]}")


def open_bsdf(
    path: Path,
    *,
    symmetry: "Symmetry | None" = None,
    front: "Side | None" = None,
    channels: "Sequence[str] | None" = None,
) -> "Bsdf":
    """Any file as something that answers in any direction. Warnings about the file go to standard error.

    Points are fitted: measured datasets, and tables of points once they were given cells; `symmetry` goes before what
    they declare; a model keeps the one that it was fitted with. `front`: side that the sample's front faces; goes
    before what the file says. `channels`: of points, those to be fitted; None: all. Raises UsageError, one line.
    """
    kind = kind_of(path)
    if kind == "matrices":
        from gonio.formats.window.scattering import window_bsdf

        bsdf, findings = window_bsdf(path, front)
        _warn(findings)
        return bsdf
    if kind == "tree":
        from gonio.formats.tensor.read import read_tensor

        bsdf, findings = read_tensor(path, front)
        _warn(findings)
        return bsdf
    if kind == "model":
        from gonio.model.model_file import read_model

        bsdf = read_model(path)
        if symmetry is not None and symmetry != bsdf.symmetry:
            raise UsageError(
                f"{path}: was fitted as {bsdf.symmetry}: leave --symmetry {symmetry} away, or fit the dataset again"
            )
        if front is not None:
            bsdf.front_faces = front
        return bsdf
    from gonio.model.fitted import fit_bsdf

    dataset = _dataset(path, kind)
    if front is not None:
        dataset.front_faces = front
    return fit_bsdf(dataset, symmetry=symmetry, channels=channels)


def _dataset(path: Path, kind: FileKind) -> "Dataset":
    from gonio.dataset.nexus import read_dataset
    from gonio.reduce.imported import reduce_dataset

    if kind == "dataset":
        return reduce_dataset(read_dataset(path))
    from gonio.formats.detect import read_points

    return reduce_dataset(read_points([path]))


def _warn(findings: "Findings") -> None:
    warnings = findings.of("error", "warning")
    say(*(f"{findings.source}: {finding.where}: {finding.message}" for finding in warnings[:_MOST_SAID]))
    if len(warnings) > _MOST_SAID:
        say(f"{findings.source}: {len(warnings) - _MOST_SAID} more remarks: gonio validate lists them")
