"""fallback: what the compiled module _model does, by numpy: the same functions (_model.pyi), slower."""

from gonio.model.fallback.evaluate import evaluate
from gonio.model.fallback.grid import fit_grid, grid_at, suitable_size
from gonio.model.fallback.near import near_lobes, sorted_cells

__all__ = ["evaluate", "fit_grid", "grid_at", "near_lobes", "sorted_cells", "suitable_size"]
