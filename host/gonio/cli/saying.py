"""saying.py: remarks of a command, on standard error."""

import typer


def say(*remarks: str) -> None:
    """One line per remark."""
    for remark in remarks:
        typer.echo(f"gonio: {remark}", err=True)
