"""The command line: it parses and calls.

A command imports what it needs when it is called, so that `tbi --help` answers at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import typer

from tbi_cli.cli.catalogue import list_, schema
from tbi_cli.cli.export import export
from tbi_cli.cli.info import info
from tbi_cli.cli.init import init
from tbi_cli.cli.merge import merge
from tbi_cli.cli.report import report
from tbi_cli.cli.reproduce import reproduce
from tbi_cli.cli.run import run, sweep
from tbi_cli.cli.status import status
from tbi_cli.cli.stopping import INTERRUPTED
from tbi_cli.cli.streams import ReaderGoneError
from tbi_cli.cli.submit import submit
from tbi_cli.cli.validate import validate
from tbi_cli.cli.verify import verify
from tbi_cli.cli.version import common
from tbi_cli.docstrings import docstring
from tbi_cli.errors import RunFailedError, UserError
from tbi_cli.printable import printable_streams
from tbi_cli.shortage import shortage

app = typer.Typer(
    name="tbi",
    help="What a train does to a bridge, and the bridge to the train, at every speed, mass and span.",
    epilog="To begin with: tbi init, then tbi validate case.yaml, tbi run case.yaml, tbi report results.h5.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
app.callback()(common)
_COMMANDS = (
    *(run, sweep, report, reproduce, validate, verify, init, info, export, list_, schema),
    *(merge, submit, status),
)
for command in _COMMANDS:
    app.command(command.__name__.rstrip("_"), help=docstring(command))(command)


def run_command_line(arguments: Sequence[str]) -> int:
    """Runs one command and returns its exit code.

    A user's mistake, or a shortage of memory, is one message on standard error, never a traceback.
    """
    with printable_streams():
        return _run(arguments)


def _run(arguments: Sequence[str]) -> int:
    try:
        code = _called(arguments)
        sys.stdout.flush()
        return code
    except ReaderGoneError as error:
        return error.exit_code
    except UserError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        if (message := shortage(error)) is not None:
            print(message, file=sys.stderr)
            return RunFailedError.exit_code
        if not (isinstance(error, OSError) and isinstance(error.filename, str | bytes)):
            raise
        print(UserError.from_os(os.fsdecode(error.filename), error), file=sys.stderr)
        return UserError.exit_code


def _called(arguments: Sequence[str]) -> int:
    try:
        app(list(arguments), prog_name="tbi")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    return 0
