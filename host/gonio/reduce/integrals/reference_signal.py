"""reference_signal.py: the BSDF from distance, detector area and the signal of the free beam, beside the form with P_i.

Paper [2], eq. 2: BSDF = r^2 / (A_det cos theta) * S_sample / S_ref, with r the distance from sample to detector, A_det
the detector's area and S_ref its signal when the whole free beam falls on it. With the receiver's solid angle omega =
A_det / r^2 a signal averages the light over the aperture: S(x) = integral of the flux per solid angle over the aperture
about x. Integrated over all x that is omega times the beam's power, whatever beam and aperture look like. So P_i =
integral of S over a scan of the beam = omega * S_ref, and DSF = S_sample / P_i is the same quotient.
"""

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.uncertainty import Uncertain

FloatArray = NDArray[np.float64]


def receiver_solid_angle_sr(distance_mm: Uncertain, area_mm2: Uncertain) -> Uncertain:
    """A / r^2, with the effects `distance` and `aperture` for the standard uncertainties of the two. A flat circular
    aperture of half angle a has 2 pi (1 - cos a), less by a^2 / 4 of it than A / r^2 has from its rim. Raises
    ValueError for lengths that are not positive."""
    r, area = distance_mm.value, area_mm2.value
    if not (r > 0.0 and area > 0.0):
        raise ValueError(f"distance and detector area must be positive, not {r:g} mm and {area:g} mm^2")
    omega = area / r**2
    return Uncertain(
        omega,
        0.0,
        {"distance": -2.0 * omega * distance_mm.u / r, "aperture": omega * area_mm2.u / area},
    )


def dsf_of_reference_signal(
    sample_signal: Uncertain, reference_signal: Uncertain, distance_mm: Uncertain, area_mm2: Uncertain
) -> Uncertain:
    """DSF [1/sr] of one reading: r^2 / A_det * S_sample / S_ref; both signals in one unit, dark subtracted. The ratio
    is formed first, so what both signals share (gain, lamp) cancels. Raises ValueError for a reference without light.
    """
    if not reference_signal.value > 0.0:
        raise ValueError(f"the reference signal must be positive, it is {reference_signal.value:g}")
    return sample_signal.over(reference_signal).over(receiver_solid_angle_sr(distance_mm, area_mm2))


def bsdf_of_reference_signal(
    sample_signal: Uncertain,
    reference_signal: Uncertain,
    distance_mm: Uncertain,
    area_mm2: Uncertain,
    theta_deg: float,
) -> Uncertain:
    """BSDF [1/sr], paper [2] eq. 2, towards theta_deg. Raises ValueError at theta = 90 degrees, where it has no
    value."""
    cosine = abs(float(np.cos(np.radians(theta_deg))))
    if cosine < 1e-9:
        raise ValueError("the BSDF has no value at theta = 90 degrees: use the DSF")
    return dsf_of_reference_signal(sample_signal, reference_signal, distance_mm, area_mm2).scaled(1.0 / cosine)


def reference_signal_of(p_i: Uncertain, distance_mm: Uncertain, area_mm2: Uncertain) -> Uncertain:
    """S_ref = P_i / omega: what a detector that takes in the whole free beam would read, from the scan of the beam with
    one that need not."""
    return p_i.over(receiver_solid_angle_sr(distance_mm, area_mm2))
