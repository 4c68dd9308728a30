"""version.py: the version of this package, for provenance and to keep a cluster's workers alike."""

from importlib.metadata import PackageNotFoundError, version


def gonio_version() -> str:
    """As installed."""
    try:
        return version("gonio")
    except PackageNotFoundError:
        return "not installed"
