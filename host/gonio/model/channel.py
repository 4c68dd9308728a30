"""channel.py: a channel of a measured sample as a BSDF in all directions: all its components."""

from collections import OrderedDict
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin
from gonio.model.between.energy import Bound
from gonio.model.between.resolve import Resolver
from gonio.model.evaluate import evaluate
from gonio.model.hemisphere import folded
from gonio.model.nodes.coverage import BEYOND, WITHIN
from gonio.model.nodes.points import COMPONENTS, SAME_DEG, Component
from gonio.model.slices import Slices

_REMEMBERED = 16  # sets of incident directions per component
_WIDEST_FEATURE_RAD = np.radians(15.0)


@dataclass
class FittedComponent:
    """One component: nodes, the way between them, and the bound of energy."""

    resolver: Resolver
    bound: Bound
    _resolved: OrderedDict[bytes, Slices] = field(default_factory=OrderedDict)

    def slices(self, incident: FloatArray) -> Slices:
        """Resolved for folded incident directions (k, 3); those asked for last are remembered."""
        key = incident.tobytes()
        found = self._resolved.get(key)
        if found is None:
            found = self.bound.applied(self.resolver, incident, self.resolver.slices(incident))
            self._resolved[key] = found
            if len(self._resolved) > _REMEMBERED:
                self._resolved.popitem(last=False)
        else:
            self._resolved.move_to_end(key)
        return found

    def measured(self, incident: FloatArray) -> NDArray[np.bool_]:
        """Which of folded incident directions (k, 3) were measured, or are images of such."""
        own, nodes = incident, self.resolver.incident
        if self.resolver.images.isotropic:
            across = np.hypot(own[:, 0], own[:, 1])
            own = np.stack((across, np.zeros(len(across)), own[:, 2]), axis=1)
        chord = np.linalg.norm(own[:, None] - nodes[None], axis=2).min(axis=1)
        return np.asarray(chord <= np.radians(SAME_DEG))


@dataclass
class Fitted:
    """A channel (Scattering): its components, by light side and leaving side."""

    components: dict[Component, FittedComponent]

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        result = np.full(len(outgoing), np.nan)
        for component, rows in _parts(incident, outgoing, which):
            model = self.components.get(component)
            if model is None:
                continue
            slices = model.slices(folded(incident))
            own = outgoing if rows is None else outgoing[rows]
            row = which if which is None or rows is None else which[rows]
            up = own if component.outgoing_front else folded(own)
            value = evaluate(slices, model.resolver.grids, up, row)
            if rows is None:
                return value
            result[rows] = value
        return result

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering. MEASURED: the incident direction was measured (or is an image of one by the declared
        symmetry) and a point lies within reach; EXTRAPOLATED: beyond the incident directions, or no point around."""
        result = np.full(len(outgoing), Origin.ABSENT, dtype=np.uint8)
        every = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        for component, rows in _parts(incident, outgoing, which):
            model = self.components.get(component)
            if model is None:
                continue
            own = np.arange(len(outgoing)) if rows is None else rows
            light = folded(incident)
            reached = model.resolver.reached(light, outgoing[own, :2], every[own])
            at_node = model.measured(light)[every[own]]
            between = model.resolver.origin(light)[every[own]]
            value = np.where(at_node & (reached == WITHIN), Origin.MEASURED, Origin.INTERPOLATED)
            beyond = (reached == BEYOND) | (~at_node & (between == Origin.EXTRAPOLATED))
            result[own] = np.where(beyond, Origin.EXTRAPOLATED, value)
        return result

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        return Component(incident_front, outgoing_front) in self.components

    def features(self, incident: FloatArray) -> Features:
        """See Scattering: lobes narrower than 15 degrees."""
        centre, sigma, rows = [np.zeros((0, 3))], [np.zeros(0)], [np.zeros(0, dtype=np.int64)]
        for component, model in self.components.items():
            asked = np.flatnonzero((incident[:, 2] >= 0.0) == component.incident_front)
            if len(asked) == 0:
                continue
            slices = model.slices(folded(incident[asked]))
            if len(slices.lobe_peak_per_sr) == 0:
                continue
            smaller = 1.0 / np.linalg.norm(slices.lobe_whitening, ord=2, axis=(1, 2))
            narrow = smaller < _WIDEST_FEATURE_RAD
            towards = np.array(slices.lobe_frame[narrow, 2])
            towards[:, 2] = np.maximum(towards[:, 2], 0.0)  # a peak below the horizon is seen at its rim
            towards /= np.linalg.norm(towards, axis=1, keepdims=True)
            towards[:, 2] *= 1.0 if component.outgoing_front else -1.0
            centre.append(towards)
            sigma.append(smaller[narrow])
            rows.append(asked[np.repeat(np.arange(len(asked)), np.diff(slices.lobe_start))[narrow]])
        return Features(np.concatenate(centre), np.concatenate(sigma), np.concatenate(rows))


def _parts(
    incident: FloatArray, outgoing: FloatArray, which: IndexArray | None
) -> list[tuple[Component, IndexArray | None]]:
    """Which outgoing directions belong to which component; None: all of them."""
    leaves = outgoing[:, 2] >= 0.0
    arrives = incident[:, 2] >= 0.0
    same_light = len(arrives) > 0 and bool(np.all(arrives == arrives[0]))
    if len(outgoing) and same_light and bool(np.all(leaves == leaves[0])):
        return [(Component(bool(arrives[0]), bool(leaves[0])), None)]
    own = np.broadcast_to(arrives[0], leaves.shape) if which is None and len(arrives) else arrives[which]
    found = [
        (component, np.flatnonzero((own == component.incident_front) & (leaves == component.outgoing_front)))
        for component in COMPONENTS
    ]
    return [(component, rows) for component, rows in found if len(rows)]
