"""calibration.py: what is known of an instrument beside its axes and channels: values with standard uncertainties."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Calibration:
    """The table [calibration] of an instrument file, every key optional; u is one standard deviation (k = 1).

    Defaults are what a carefully adjusted instrument of this kind reaches; a laboratory states its own.
    """

    # Light = signal (1 + c signal / full scale), either gain alike; u also where c is 0.
    nonlinearity: float = 0.0
    nonlinearity_u: float = 5e-4
    # Lamp: how well the monitor follows what falls on the sample, over a scan.
    monitor_u_rel: float = 5e-4
    arm_radius_u_mm: float = 0.2
    aperture_diameter_u_mm: float = 0.01
    # Front face in front of the axes' centre, along the sample's +z.
    sample_offset_mm: float = 0.0
    sample_offset_u_mm: float = 0.1
    # Of the sample's normal against the axes, about the sample's x and y.
    tilt_u_deg: float = 0.02
    # Zero of every axis.
    axis_zero_u_deg: float = 0.01
    # DSF that the dark room adds everywhere; subtracted where the correction is on.
    stray_light_per_sr: float = 0.0
    stray_light_u_per_sr: float = 1e-6
