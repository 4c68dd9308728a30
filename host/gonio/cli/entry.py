"""entry.py: where `gonio` begins: Ctrl-C while Python still imports ends the program, without a traceback."""

import os
import signal
from typing import NoReturn

# numpy's linear algebra would start a thread per processor, which wait for work by spinning: matrices here are narrow,
# and what takes time has threads of its own. To be set before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main() -> NoReturn:
    """The command `gonio`."""
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # a shell's background job ignores it
    if heeded:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from gonio.cli.main import main as run  # noqa: PLC0415 - the import is what may be interrupted

    if heeded:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()
