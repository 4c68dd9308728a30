"""resume.py: what is left of a program after an interruption: whole paths, and the rest of a partial one."""

from dataclasses import replace

import numpy as np

from gonio.plan.knots import FloatArray, KnotArray, evaluate
from gonio.plan.limits import HOLD_RATE_PER_S
from gonio.plan.moves import move
from gonio.plan.profiles import STEP_SLOPE, speed_up
from gonio.plan.program import DarkStep, OperatorStep, PathStep, Program, ShutterStep, Step
from gonio.units.instrument import Instrument

# The rate of path time then changes no faster than in a feed hold, for which every path leaves room.
_RAMP_S = STEP_SLOPE / HOLD_RATE_PER_S
_KNOT_NS = 20_000_000
_LEAST_GAP_NS = 5_000_000


def remaining(program: Program, done_path_ids: set[int], partial: tuple[int, int] | None) -> Program:
    """The program without the measured paths that are done; of a `partial` one, (path id, path time in ns), the rest.

    The rest starts at rest and speeds up on the same curve. Paths keep their ids, moves are planned anew and get fresh
    ids, and every incident direction that is not done gets its dark signal again. Empty steps: nothing is left.
    Raises ValueError for a program that was not compiled for an instrument, UsageError if a new move finds no way.
    """
    if program.instrument is None:
        raise ValueError("a program without its instrument cannot be resumed")
    planner = _Planner(program, program.instrument)
    operator: OperatorStep | None = None
    steps: list[Step] = []
    for group in _groups(program.steps):
        asked = next((step for step in group if isinstance(step, OperatorStep)), None)
        operator = asked or operator
        paths = [_rest(step, partial) for step in group if _is_measured(step)]
        left = [path for path in paths if path is not None and path.path_id not in done_path_ids]
        if left:
            if operator is not None:
                steps.append(operator)
                operator = None
            steps += planner.group(left, next(step for step in group if isinstance(step, DarkStep)))
    return replace(program, steps=steps)


def _is_measured(step: Step) -> bool:
    return isinstance(step, PathStep) and step.kind != "move"


def _groups(steps: list[Step]) -> list[list[Step]]:
    """One group per time that the shutter was open: what leads there, the paths, the closing."""
    groups: list[list[Step]] = [[]]
    opened = False
    for step in steps:
        groups[-1].append(step)
        if isinstance(step, ShutterStep):
            if opened and not step.open:
                groups.append([])
            opened = step.open
    return [group for group in groups if any(_is_measured(step) for step in group)]


def _rest(step: Step, partial: tuple[int, int] | None) -> PathStep | None:
    assert isinstance(step, PathStep)
    if partial is None or step.path_id != partial[0]:
        return step
    if partial[1] >= int(step.knots["time_ns"][-1]):
        return None
    return replace(step, knots=retimed(step.knots, max(0, partial[1])))


def retimed(knots: KnotArray, from_ns: int) -> KnotArray:
    """The rest of a path from path time `from_ns`: at rest there, then ever faster until it runs as planned.

    With s(t) the path time and q', q'' the path's derivatives: velocity q' s', acceleration q'' s'^2 + q' s''.
    """
    if from_ns <= 0:
        return knots
    left_s = (int(knots["time_ns"][-1]) - from_ns) * 1e-9
    end_ns = round(_time_to_pass(left_s) * 1e9)
    ramp_ns = min(end_ns - _LEAST_GAP_NS, round(_RAMP_S * 1e9))
    fine = np.arange(0, max(1, ramp_ns), _KNOT_NS, dtype=np.int64)
    # After the ramp the path runs behind its old times by a constant: its own knots serve again.
    delay_ns = round(0.5 * _RAMP_S * 1e9) - from_ns
    behind = knots["time_ns"] + delay_ns > max(ramp_ns, int(fine[-1]) + _LEAST_GAP_NS)
    later = knots[behind] if end_ns > round(_RAMP_S * 1e9) else knots[-1:]
    result = np.zeros(len(fine) + len(later), dtype=knots.dtype)
    result[len(fine) :] = later
    result["time_ns"][: len(fine)] = fine
    result["time_ns"][len(fine) :] += delay_ns
    result["time_ns"][-1] = end_ns
    path_s, rate, bend = speed_up(fine.astype(np.float64) * 1e-9, _RAMP_S)
    q, d_q, dd_q = evaluate(knots, from_ns + path_s * 1e9)
    result["position_counts"][: len(fine)] = q
    result["velocity_counts_per_s"][: len(fine)] = d_q * rate[:, None]
    result["acceleration_counts_per_s2"][: len(fine)] = dd_q * (rate**2)[:, None] + d_q * bend[:, None]
    for end in (0, -1):
        result["velocity_counts_per_s"][end] = 0.0
        result["acceleration_counts_per_s2"][end] = 0.0
    return result


def _time_to_pass(path_s: float) -> float:
    """Time after which a path that speeds up from rest has passed `path_s` of path time."""
    if path_s >= 0.5 * _RAMP_S:
        return path_s + 0.5 * _RAMP_S
    time = np.linspace(0.0, _RAMP_S, 4097, dtype=np.float64)
    return float(np.interp(path_s, speed_up(time, _RAMP_S)[0], time))


class _Planner:
    """Plans the moves anew, with ids that the program has not used."""

    def __init__(self, program: Program, instrument: Instrument) -> None:
        self._instrument = instrument
        self._id = max((step.path_id for step in program.steps if isinstance(step, PathStep)), default=0)
        self._standing: FloatArray | None = None

    def group(self, paths: list[PathStep], dark: DarkStep) -> list[Step]:
        """A move and the dark signal, then the paths with moves between them, the shutter closed around."""
        steps: list[Step] = [ShutterStep(open=False)]
        for number, path in enumerate(paths):
            steps.append(self._move_to(path))
            if number == 0:
                steps += [dark, ShutterStep(open=True)]
            steps.append(path)
        steps.append(ShutterStep(open=False))
        return steps

    def _move_to(self, path: PathStep) -> PathStep:
        scale = np.array([axis.counts_per_deg for axis in self._instrument.axes])
        ends = path.knots["position_counts"][[0, -1], : len(scale)] / scale
        # The first move is led in from where the axes stand (moves.starting_at); until then it stays in place.
        start = ends[0] if self._standing is None else self._standing
        self._standing = ends[1]
        self._id += 1
        name = f"move to {path.name}"
        return PathStep(self._id, "move", name, move(start, ends[0], self._instrument, name))
