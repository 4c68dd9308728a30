"""query.py: query: what a model or file says in given directions, one pair or a table of them."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gonio.cli.device import JsonOption
from gonio.cli.options import DeclaredSymmetry, Front, angles
from gonio.cli.places import check_inputs, check_outputs
from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from gonio.dataset.scattering import Bsdf, Scattering
    from gonio.formats.asked_table import Counts


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("query")(query)


def query(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A dataset, model, WINDOW XML, tensor tree, or pab, CSV or NIST points."),
    ],
    *,
    incident: Annotated[
        str | None, typer.Option(metavar="THETA,PHI", help="Towards the source, degrees, in the sample frame.")
    ] = None,
    outgoing: Annotated[
        str | None, typer.Option(metavar="THETA,PHI", help="Towards the detector; theta over 90 is behind the sample.")
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option(
            metavar="IN.csv", help="Columns theta_i_deg, phi_i_deg, theta_s_deg, phi_s_deg; others pass through."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="OUT.csv", help="The table with bsdf, origin and a reason per row."),
    ] = None,
    channel: Annotated[str | None, typer.Option(metavar="NAME", help="Default: visible, or the only one.")] = None,
    front: Annotated[
        Front | None, typer.Option(help="Side that the sample's front faces; goes before what the file says.")
    ] = None,
    symmetry: Annotated[
        DeclaredSymmetry | None,
        typer.Option(help="Points are fitted: what to declare of the sample where the file does not."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say the BSDF and the DSF [1/sr], and whether they are measured, interpolated, extrapolated or absent.

    Outside the range that was measured there is a warning on standard error.
    """
    from gonio.cli.sources import open_bsdf
    from gonio.formats.asking import channel_of

    if (table is None) == (incident is None or outgoing is None) or (table is None) != (output is None):
        raise UsageError("query takes --incident THETA,PHI --outgoing THETA,PHI, or --table IN.csv -o OUT.csv")
    if table is not None and (incident is not None or outgoing is not None):
        raise UsageError("--table has the directions: leave --incident and --outgoing away")
    check_inputs(file, table)
    check_outputs(output, inputs=[file, table])
    pair = None if incident is None or outgoing is None else (angles(incident), angles(outgoing))
    bsdf = open_bsdf(
        file,
        symmetry=None if symmetry is None else symmetry.value,
        front=None if front is None else front.value,
    )
    name = channel_of(bsdf, channel, str(file))
    if pair is not None:
        _one_pair(bsdf, name, file, *pair, as_json=as_json)
    elif table is not None and output is not None:
        _table(bsdf.channels[name], file, table, output, as_json=as_json)


def _one_pair(
    bsdf: "Bsdf",
    channel: str,
    file: Path,
    incident_deg: tuple[float, float],
    outgoing_deg: tuple[float, float],
    *,
    as_json: bool,
) -> None:
    import math

    from gonio.dataset.scattering import Origin
    from gonio.formats.asking import REASONS, Reason, ask
    from gonio.geometry.directions import unit_from_angles_deg

    incident, outgoing = (unit_from_angles_deg([theta], [phi]) for theta, phi in (incident_deg, outgoing_deg))
    found = ask(bsdf.channels[channel], incident, outgoing)
    origin, reason = Origin(int(found.origin[0])), REASONS[Reason(int(found.reason[0]))]
    values = {"bsdf_per_sr": float(found.bsdf_per_sr[0]), "dsf_per_sr": float(found.dsf_per_sr[0])}
    if origin is Origin.EXTRAPOLATED:
        say(f"warning: {file}: outside the validity range, the value is extrapolated. {' '.join(bsdf.validity)}")
    if as_json:
        content: dict[str, Any] = {
            "file": str(file),
            "channel": channel,
            "incident_deg": list(incident_deg),
            "outgoing_deg": list(outgoing_deg),
            **{key: value if math.isfinite(value) else None for key, value in values.items()},
            "origin": origin.name.lower(),
            "reason": reason or None,
            "front_faces": bsdf.front_faces,
            "validity": list(bsdf.validity),
        }
        typer.echo(json.dumps(content, allow_nan=False))
        return
    for key, title in (("bsdf_per_sr", "BSDF"), ("dsf_per_sr", "DSF")):
        value = values[key]
        typer.echo(f"{title:<8}{value:.7g} 1/sr" if math.isfinite(value) else f"{title:<8}none")
    typer.echo(f"origin  {origin.name.lower()}")
    if reason:
        typer.echo(f"reason  {reason}")
    typer.echo(
        f"channel {channel}, incident {incident_deg[0]:g}/{incident_deg[1]:g}, outgoing {outgoing_deg[0]:g}/"
        f"{outgoing_deg[1]:g} (theta/phi in degrees, sample frame; {_front(bsdf)})"
    )


def _front(bsdf: "Bsdf") -> str:
    if bsdf.front_faces == "undeclared":
        return "which way the front faces is not declared"
    return f"the front faces the {bsdf.front_faces}"


def _table(scattering: "Scattering", file: Path, table: Path, output: Path, *, as_json: bool) -> None:
    from gonio.formats.asked_table import answer
    from gonio.formats.asking import ask

    counts = answer(table, output, lambda incident, outgoing, which: ask(scattering, incident, outgoing, which))
    if counts.extrapolated:
        say(f"warning: {file}: {counts.extrapolated} of {counts.rows} rows are outside the validity range.")
    if as_json:
        typer.echo(json.dumps(_plain(counts, output), allow_nan=False))
        return
    for reason, number in counts.reasons.items():
        say(f"{table}: {number} of {counts.rows} rows without a value: {reason}.")
    typer.echo(output)


def _plain(counts: "Counts", output: Path) -> dict[str, Any]:
    return {
        "output": str(output),
        "rows": counts.rows,
        "without_value": counts.without_value,
        "extrapolated": counts.extrapolated,
        "reasons": counts.reasons,
    }
