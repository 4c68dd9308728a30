"""main.py: the command line's frame: errors in one line, exit statuses, --version and --debug."""

import sys
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated, NoReturn

import typer
from typer.exceptions import TyperException

from gonio.cli import (
    compare,
    convert,
    deconvolve,
    device,
    drives,
    export,
    fit,
    importing,
    merge,
    query,
    reduce,
    report,
    scan,
    simulate,
)
from gonio.units.errors import GonioError

INTERNAL_ERROR = 70  # sysexits.h: EX_SOFTWARE
INTERRUPTED = 130  # the shell's for SIGINT

app = typer.Typer(
    name="gonio",
    help="Drives a scanning goniophotometer, reduces what it measured and writes BSDF files.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
device.register(app)
scan.register(app)
drives.register(app)
simulate.register(app)
reduce.register(app)
merge.register(app)
compare.register(app)
deconvolve.register(app)
fit.register(app)
export.register(app)
convert.register(app)
importing.register(app)
query.register(app)
report.register(app)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"gonio {version('gonio')}")
        raise typer.Exit


@app.callback()
def _common(
    context: typer.Context,
    _version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and end.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show where an internal error comes from.")] = False,
) -> None:
    context.obj = debug


def run(arguments: Sequence[str]) -> int:
    """Run one command; its exit status (0 good, 1 a check found something, 2 wrong use, 3 instrument fault)."""
    debug = "--debug" in arguments
    try:
        status = app(args=list(arguments), prog_name="gonio", standalone_mode=False)
    except GonioError as error:
        _say(str(error))
        return error.exit_status
    except TyperException as error:
        text = error.format_message()
        if "\n" in text:  # no command: this is the whole help
            typer.echo(text)
        else:
            _say(f"{text} (see gonio --help)")
        return 2
    except (typer.Abort, KeyboardInterrupt):
        status = INTERRUPTED
    except BrokenPipeError:
        return 1  # who read our output has gone
    except Exception as error:
        if debug:
            traceback.print_exc()
        text = " ".join(str(error).split())
        _say(f"internal error: {type(error).__name__}: {text} (gonio --debug ... shows where)")
        return INTERNAL_ERROR
    if status == INTERRUPTED:  # typer turns Ctrl-C into this status itself
        _say("interrupted: no file was left half written")
    return status if isinstance(status, int) else 0


def _say(line: str) -> None:
    print(f"gonio: {line}", file=sys.stderr)  # noqa: T201 - the one place that prints errors


def main() -> NoReturn:
    """The command `gonio`."""
    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
