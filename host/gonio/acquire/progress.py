"""progress.py: the progress bar on standard error: what is measured, how far, how long it takes."""

from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn


class ScanProgress:
    """Counts path time against the program's whole time. Not on a terminal: silent, but for what `say` is given."""

    def __init__(self, total_s: float) -> None:
        self._console = Console(stderr=True, soft_wrap=True, highlight=False)
        self._progress = Progress(
            TextColumn("{task.description:<24}"),
            BarColumn(),
            TextColumn("{task.completed:.0f} of {task.total:.0f} s"),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
        )
        self._task: TaskID = self._progress.add_task("boot and homing", total=total_s)
        self._done_s = 0.0
        self._step_s = 0.0

    def begin(self, name: str, duration_s: float) -> None:
        """A step of so long begins."""
        self._step_s = duration_s
        self._progress.update(self._task, description=name)

    def path_time(self, path_time_ns: int) -> None:
        """How far the step is."""
        self._progress.update(self._task, completed=self._done_s + min(path_time_ns * 1e-9, self._step_s))

    def end(self) -> None:
        """The step is done."""
        self._done_s += self._step_s
        self._progress.update(self._task, completed=self._done_s)

    def say(self, text: str) -> None:
        """A line for the user, above the bar."""
        self._console.print(text, markup=False)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()
