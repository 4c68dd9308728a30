"""compare.py: the command compare: how far two datasets, or a dataset and a model, agree."""

import typer


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    _ = app
