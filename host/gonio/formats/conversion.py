"""conversion.py: the matrices of a simulation file in another Klems basis: integrals are kept, nothing is fitted.

Kept exactly: what an incident patch (cell) of the new basis sends out, over all outgoing ones, is the mean of what the
old basis's incident cells send out that it overlaps, weighted by the projected solid angle that they share; so all
light of the hemisphere is kept too. Where cells of both do not coincide that mean changes single columns: this is
resolution, which a way there and back cannot undo.
"""

import numpy as np

from gonio.dataset.scattering import Bsdf, FloatArray, Scattering
from gonio.formats.patches import of_tree
from gonio.formats.patches.average import PatchMatrices
from gonio.formats.patches.hemispheres import Component
from gonio.formats.patches.overlap import rebinned
from gonio.formats.tensor.flat import FlatTree
from gonio.formats.tensor.tree import TreeScattering, TristimulusTrees
from gonio.formats.window.klems import KlemsBasis
from gonio.formats.window.scattering import KlemsScattering


def averages(bsdf: Bsdf, basis: KlemsBasis) -> dict[str, PatchMatrices]:
    """Averages over the basis's patches of every channel of a file that was read."""
    return {name: _of_channel(channel, basis) for name, channel in bsdf.channels.items()}


def _of_channel(channel: Scattering, basis: KlemsBasis) -> PatchMatrices:
    found = PatchMatrices()
    if isinstance(channel, KlemsScattering):
        for (band, process, side), values in channel.window.matrices.items():
            if band == channel.band and Component(channel, process, side, channel.front_faces).covered():
                found.matrices[process, side] = rebinned(values, channel.window.basis, basis)
    elif isinstance(channel, TreeScattering):
        for component, tree in channel.trees.items():
            found.matrices[component.process, component.side] = of_tree.matrix(tree, basis)
    elif isinstance(channel, TristimulusTrees):
        for component, tree in channel.y.trees.items():
            u, v = channel.u[component], channel.v[component]

            def share(place: FloatArray, u: FlatTree = u, v: FlatTree = v) -> FloatArray:
                return _over_y(u.at(place), v.at(place), of_x=channel.of_x)

            found.matrices[component.process, component.side] = of_tree.matrix(tree, basis, share)
    else:
        raise TypeError(f"{type(channel).__name__} is no content of a simulation file")
    found.error = {key: np.zeros(basis.size) for key in found.matrices}
    return found


def _over_y(u: FloatArray, v: FloatArray, *, of_x: bool) -> FloatArray:
    """X / Y or Z / Y of a colour with the CIE 1976 chromaticity u', v'."""
    share = 9.0 * u if of_x else 12.0 - 3.0 * u - 20.0 * v
    return np.asarray(np.maximum(share / (4.0 * np.maximum(v, 1e-6)), 0.0))
