"""compile.py: a plan file to the program that acquire runs: directions to axis paths, everything checked beforehand."""

from dataclasses import asdict
from pathlib import Path

import numpy as np

from gonio.geometry.directions import angle_between_deg, mirror, retro, through, unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.plan.arm import axis_numbers, follow
from gonio.plan.circles import Coverage, unreachable
from gonio.plan.coarse import coarse_pass
from gonio.plan.knots import FloatArray, KnotArray, counts_per_deg, pack
from gonio.plan.limits import require_allowed
from gonio.plan.moves import move
from gonio.plan.program import DarkStep, OperatorStep, PathKind, PathStep, Program, ShutterStep, UnreachableDirection
from gonio.plan.schema import Direction, PeakPlan, Plan, SpiralPlan, load_plan
from gonio.plan.shadow import shading_angle_deg
from gonio.plan.sinusoid import sinusoid_program
from gonio.plan.spiral import spiral
from gonio.plan.trajectory import time_law
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

_NAMED = {"mirror": mirror, "retro": retro, "through": through}


def compile_plan(path: Path, instrument: Instrument) -> Program:
    """Read and compile a plan. Raises UsageError, with direction and limit, for what the instrument cannot do."""
    return compile_loaded(load_plan(path), instrument)


def compile_loaded(plan: Plan, instrument: Instrument) -> Program:
    """Compile a plan that was read already; see `compile_plan`."""
    open_loop = [axis.name for axis in instrument.axes if axis.driven and not axis.encoder]
    if open_loop:
        raise UsageError(f"{open_loop[0]}: has no encoder; its position in motion is unknown, so it cannot fly a scan")
    if plan.sinusoid is not None:
        wanted = plan.sinusoid
        program = sinusoid_program(
            instrument, wanted.amplitude_deg, wanted.peak_speed_deg_per_s, wanted.duration_s, plan.dark_s
        )
    else:
        program = _Compiler(plan, instrument).program()
    program.metadata = {**_metadata(plan, instrument), **program.metadata}
    return program


def _metadata(plan: Plan, instrument: Instrument) -> dict[str, object]:
    beam = asdict(plan.beam)
    return {
        "sample": {**asdict(plan.sample), "polarisation": beam.pop("polarisation")},
        "beam": beam,
        "channel": "visible",
        "scan": asdict(plan.scan),
        "head_diameter_mm": instrument.head_diameter_mm,
        "shading_angle_deg": shading_angle_deg(instrument, plan.beam),
        "plan": plan.text,
        "notes": [],
    }


class _Compiler:
    """Appends step after step, each path beginning where the last one ended."""

    def __init__(self, plan: Plan, instrument: Instrument) -> None:
        self._plan = plan
        self._instrument = instrument
        self._kinematics = Kinematics(instrument.axes)
        self._steps: list[OperatorStep | ShutterStep | DarkStep | PathStep] = []
        self._unreachable: list[UnreachableDirection] = []
        self._notes: list[str] = []
        self._paths = 0
        self._dark = False  # whether a step has closed the shutter since it was last open
        # Where the axes stand before is not known here: acquire leads the first move in from there (moves.starting_at).
        self._standing = np.array([min(max(0.0, axis.min_deg), axis.max_deg) for axis in instrument.axes])

    def program(self) -> Program:
        """The whole program."""
        if self._plan.reference is not None:
            self._reference(self._plan.reference)
        for incident in self._plan.scan.incident:
            self._incident(incident)
        return Program(self._steps, self._unreachable, {"notes": self._notes}, self._instrument)

    def _error(self, problem: str) -> UsageError:
        return UsageError(f"{self._plan.source}: {problem}")

    def _reference(self, plan: SpiralPlan) -> None:
        self._steps.append(OperatorStep("sample_removed", "Take the sample out of its holder to measure the free beam"))
        sample = (float(self._standing[i]) for i in axis_numbers(self._instrument, "sample"))
        incident, _ = self._kinematics.directions(self._standing[None, :])
        first, second = sample
        knots = self._spiral(-incident[0], plan, (first, second), "reference")
        self._measure([("reference", "reference", knots)], None)
        self._steps.append(OperatorStep("sample_mounted", "Put the sample into its holder"))

    def _incident(self, incident: Direction) -> None:
        name = f"{incident[0]:g}/{incident[1]:g}"
        sample = self._sample_axes(incident)
        paths: list[tuple[PathKind, str, KnotArray]] = []
        if self._plan.coarse is not None:
            coverage = Coverage(self._instrument, sample, self._plan.coarse.pitch_deg, self._plan.coarse.sphere)
            knots = pack(coarse_pass(coverage, self._plan.scan.speed_deg_per_s), self._instrument)
            self._require(knots, f"coarse {name}")
            paths.append(("coarse", f"coarse {name}", knots))
            self._unreachable += unreachable(coverage, incident)
        for peak in self._plan.peaks:
            if peak.for_incident is None or incident in peak.for_incident:
                paths += self._peak(peak, incident, sample, name)
        if paths:
            self._measure(paths, incident)

    def _peak(
        self, peak: PeakPlan, incident: Direction, sample: tuple[float, float], name: str
    ) -> list[tuple[PathKind, str, KnotArray]]:
        if isinstance(peak.about, str):
            theta, phi = (float(angle) for angle in _NAMED[peak.about](*incident))
            title = f"{peak.about} {name}"
        else:
            theta, phi = peak.about
            title = f"peak ({theta:g}, {phi:g}) {name}"
        centre = unit_from_angles_deg(theta, phi)
        from_source = float(angle_between_deg(centre, unit_from_angles_deg(*incident)))
        shading = shading_angle_deg(self._instrument, self._plan.beam)
        if from_source < shading:
            self._notes.append(
                f"{title} is not measured: its centre is {from_source:.1f} deg from the source, and the detector's "
                f"head shades the beam within {shading:.1f} deg"
            )
            return []
        return [("peak", title, self._spiral(centre, peak.spiral, sample, title))]

    def _spiral(self, centre: FloatArray, plan: SpiralPlan, sample: tuple[float, float], name: str) -> KnotArray:
        track = spiral(centre, plan.radius_deg, plan.pitch_deg)
        curve = follow(track, sample, self._instrument, f"{self._plan.source}: {name}")
        knots = pack(time_law(curve, self._plan.scan.speed_deg_per_s, self._instrument), self._instrument)
        self._require(knots, name)
        return knots

    def _sample_axes(self, incident: Direction) -> tuple[float, float]:
        where = f"scan.incident: incident direction ({incident[0]:g}, {incident[1]:g})"
        try:
            sample = self._kinematics.sample_axes_for_incident(*incident)
        except UsageError as error:
            raise self._error(f"scan.incident: {error}") from error
        for number, reading in zip(axis_numbers(self._instrument, "sample"), sample, strict=True):
            axis = self._instrument.axes[number]
            if not axis.min_deg <= reading <= axis.max_deg:
                limit = axis.min_deg if reading < axis.min_deg else axis.max_deg
                raise self._error(
                    f"{where} is out of reach: {axis.name} would be {reading:.2f} deg, its limit is {limit:g}"
                )
        return sample

    def _require(self, knots: KnotArray, name: str) -> None:
        require_allowed(knots, self._instrument, self._kinematics, f"{self._plan.source}: {name}")

    def _measure(self, paths: list[tuple[PathKind, str, KnotArray]], incident: Direction | None) -> None:
        """Go there in the dark, record the dark signal, then fly the paths with the shutter open."""
        scale = counts_per_deg(self._instrument.axes)
        theta, phi = (None, None) if incident is None else incident
        if not self._dark:
            self._steps.append(ShutterStep(open=False))
        for number, (kind, name, knots) in enumerate(paths):
            ends = knots["position_counts"][[0, -1], : len(scale)] / scale
            title = f"move to {name}"
            way = move(self._standing, ends[0], self._instrument, f"{self._plan.source}: {title}")
            self._steps.append(PathStep(self._next_id(), "move", title, way))
            if number == 0:
                self._steps += [DarkStep(self._plan.dark_s), ShutterStep(open=True)]
            self._steps.append(PathStep(self._next_id(), kind, name, knots, theta, phi))
            self._standing = ends[1]
        self._steps.append(ShutterStep(open=False))
        self._dark = True

    def _next_id(self) -> int:
        self._paths += 1
        return self._paths
