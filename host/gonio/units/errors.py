"""errors.py: the errors that a user sees as one line; each knows the exit status of the command line."""


class GonioError(Exception):
    """One sentence: what, where, what to do. Only the command line prints it."""

    exit_status = 1


class CheckFailed(GonioError):  # noqa: N818 - named for what it says, like InstrumentFault
    """A check found something."""

    exit_status = 1


class UsageError(GonioError):
    """Wrong use or unreadable input."""

    exit_status = 2


class InstrumentFault(GonioError):  # noqa: N818 - a fault is the field's word
    """The instrument, its firmware or the way to them failed."""

    exit_status = 3
