"""backend.py: who evaluates models and fits grids, chosen at import: the compiled module, or numpy without it."""

try:
    from gonio.model import _model as model
except ImportError:
    from gonio.model import fallback as model  # type: ignore[no-redef]

__all__ = ["model"]
