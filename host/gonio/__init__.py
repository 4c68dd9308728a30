"""gonio: the host of a scanning goniophotometer: acquisition, reduction, files and reports."""

__version__ = "0.1.0"
