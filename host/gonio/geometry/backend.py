"""backend.py: who works on irregular directions, chosen at import: the compiled module, or scipy without it."""

try:
    from gonio.geometry import _sphere as sphere
except ImportError:
    from gonio.geometry import fallback as sphere  # type: ignore[no-redef]

__all__ = ["sphere"]
