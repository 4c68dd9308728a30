"""klems_model.py: Klems matrices of a WINDOW file as a DSF in any direction: constant within every pair of patches."""

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.formats.klems import incident_place, process_of, to_radiance_deg
from gonio.formats.klems_matrices import Band
from gonio.formats.window_reader import WindowBsdf
from gonio.geometry.directions import angles_deg_from_unit

FloatArray = NDArray[np.float64]


class KlemsModel:
    """One band of a WINDOW file, seen in the frame of a sample whose front faces `front_faces`."""

    def __init__(self, window: WindowBsdf, band: Band, front_faces: Side) -> None:
        self._window, self._band, self._faces = window, band, front_faces

    def dsf_per_sr(self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr] (n,) towards unit vectors (n, 3): the patches' BSDF times |cos theta|; NaN where the file has no
        matrix. Raises UsageError when it is not declared which way the front faces."""
        basis = self._window.basis
        theta_deg, phi_deg = angles_deg_from_unit(outgoing)
        theta_r, phi_r = to_radiance_deg(theta_deg, phi_deg, self._faces)
        incident_r = to_radiance_deg(incident_theta_deg, incident_phi_deg, self._faces)
        side, polar, azimuth = incident_place(float(incident_r[0]), float(incident_r[1]))
        column = int(basis.patch_of(polar, azimuth))
        to_interior = theta_r <= 90.0
        row = basis.patch_of(np.where(to_interior, theta_r, 180.0 - theta_r), phi_r)
        result = np.full(len(theta_deg), np.nan)
        for interior in (True, False):
            matrix = self._window.matrices.get((self._band, process_of(side, interior), side))
            if matrix is not None:
                here = to_interior == interior
                result[here] = matrix[row[here], column]
        return np.asarray(result * np.abs(np.cos(np.radians(theta_deg))))
