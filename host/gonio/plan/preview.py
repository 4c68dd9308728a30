"""preview.py: a self-contained HTML page that shows a program's paths on the sphere, for `gonio plan --preview`."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.plan.knots import FloatArray, positions_deg
from gonio.plan.program import PathStep, Program
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

_COLOURS = {"reference": "#7a5195", "coarse": "#2f6f9f", "peak": "#d1495b"}


def write_preview(program: Program, instrument: Instrument, path: Path) -> None:
    """Write the page; it needs no network. Raises UsageError if the file cannot be written."""
    text = page(program, instrument)
    beside = path.with_name(path.name + ".part")
    try:
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, path)
    except OSError as error:
        raise UsageError(f"{path}: cannot write the preview ({error.strerror}): choose another place") from error


def page(program: Program, instrument: Instrument) -> str:
    """The page as text: one sphere per incident direction in the sample frame, +z (front normal) up."""
    import plotly.graph_objects as go  # noqa: PLC0415 - only the preview needs it, and it loads slowly
    import plotly.io  # noqa: PLC0415

    groups: dict[tuple[float, float] | None, list[PathStep]] = {}
    for step in program.steps:
        if isinstance(step, PathStep) and step.kind != "move":
            theta, phi = step.incident_theta_deg, step.incident_phi_deg
            groups.setdefault(None if theta is None or phi is None else (theta, phi), []).append(step)
    figure = go.Figure()
    figure.add_trace(_globe(go))
    shown: list[tuple[int, int]] = []
    for number, (incident, steps) in enumerate(groups.items()):
        first = len(figure.data)
        for step in steps:
            figure.add_trace(_line(go, _track(step, instrument), _COLOURS[step.kind], step.name, number == 0))
        if incident is not None:
            figure.add_trace(_points(go, unit_from_angles_deg(*incident)[None, :], "incident direction", number == 0))
        lost = [
            unit_from_angles_deg(u.theta_deg, u.phi_deg)
            for u in program.unreachable
            if (u.incident_theta_deg, u.incident_phi_deg) == incident
        ]
        if lost:
            figure.add_trace(_points(go, np.array(lost), "out of reach", number == 0))
        shown.append((first, len(figure.data)))
    total = len(figure.data)
    buttons = [
        {
            "label": _title(incident),
            "method": "update",
            "args": [{"visible": [i == 0 or first <= i < last for i in range(total)]}],
        }
        for incident, (first, last) in zip(groups, shown, strict=True)
    ]
    figure.update_layout(
        title=f"{program.metadata.get('sample', {}).get('name', 'program')}: {_duration(program.duration_s)}",
        updatemenus=[{"buttons": buttons, "x": 0.0, "y": 1.0, "xanchor": "left"}],
        scene={
            "xaxis": {"title": "x (right)"},
            "yaxis": {"title": "y (up)"},
            "zaxis": {"title": "z (front normal)"},
            "aspectmode": "data",
        },
        margin={"l": 0, "r": 0, "t": 50, "b": 0},
    )
    return str(plotly.io.to_html(figure, include_plotlyjs=True, full_html=True, default_height="95vh"))


def _title(incident: tuple[float, float] | None) -> str:
    return "without sample" if incident is None else f"incident ({incident[0]:g}, {incident[1]:g})"


def _duration(seconds: float) -> str:
    return f"{seconds / 60.0:.0f} min" if seconds >= 120.0 else f"{seconds:.0f} s"


def _track(step: PathStep, instrument: Instrument) -> FloatArray:
    return Kinematics(instrument.axes).directions(positions_deg(step.knots, instrument))[1]


def _line(go: Any, track: FloatArray, colour: str, name: str, visible: bool) -> Any:
    x, y, z = np.round(track, 4).T
    return go.Scatter3d(
        x=x, y=y, z=z, mode="lines", line={"color": colour, "width": 2}, name=name, visible=visible, hoverinfo="name"
    )


def _points(go: Any, places: FloatArray, name: str, visible: bool) -> Any:
    x, y, z = places.T
    return go.Scatter3d(x=x, y=y, z=z, mode="markers", marker={"size": 4}, name=name, visible=visible)


def _globe(go: Any) -> Any:
    theta, phi = np.meshgrid(np.linspace(0.0, 180.0, 37), np.linspace(0.0, 360.0, 73))
    x, y, z = np.moveaxis(0.985 * unit_from_angles_deg(theta, phi), -1, 0)
    return go.Surface(
        x=x, y=y, z=z, opacity=0.35, showscale=False, hoverinfo="skip", colorscale=[[0, "#dddddd"], [1, "#dddddd"]]
    )
