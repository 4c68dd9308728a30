"""merge.py: commands that join datasets: merge, repeatability."""

import typer


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    _ = app
