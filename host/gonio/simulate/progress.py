"""progress.py: the progress bar of a simulation on standard error: photons, rate, time left."""

from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text


class _Rate(ProgressColumn):
    """Million photons per second."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed / 1e6:.2f} M/s")


class PhotonProgress:
    """Counts photons against those that are wanted so far. Not on a terminal: silent."""

    def __init__(self) -> None:
        console = Console(stderr=True, soft_wrap=True, highlight=False)
        self._progress = Progress(
            TextColumn("{task.description:<16}"),
            BarColumn(),
            TextColumn("{task.fields[shown]} million photons"),
            _Rate(),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._progress.add_task("free beam", total=0.0, shown="")
        self._wanted = 0
        self._done = 0

    def begin(self, name: str) -> None:
        """A part of the work begins."""
        self._progress.update(self._task, description=name)

    def want(self, photons: int) -> None:
        """So many more are to be traced."""
        self._wanted += photons
        self.at(0)

    def at(self, photons: int) -> None:
        """So many are traced beyond those that are done."""
        now = self._done + photons
        shown = f"{now / 1e6:.1f} of {self._wanted / 1e6:.1f}"
        self._progress.update(self._task, total=self._wanted, completed=now, shown=shown)

    def done(self, photons: int) -> None:
        """So many more are done."""
        self._done += photons
        self.at(0)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()
