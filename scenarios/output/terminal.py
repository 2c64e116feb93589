"""Run a command from the command line: arguments, progress bars, errors and exit status."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Sequence
from dataclasses import field, make_dataclass
from typing import Annotated, Any, Protocol

import tyro

from flybench.disk_space import caused_by_full_disk
from flybench.errors import FlybenchError
from scenarios.errors import is_interrupt
from scenarios.output.arguments.option_groups import flat, grouped
from scenarios.output.arguments.shared_options import SharedOptions
from scenarios.output.log import log_complaint, log_step
from scenarios.output.repetition import check_repetition
from scenarios.output.streams import (
    claim_output,
    complain,
    discard_output,
    own_output,
    prepare_streams,
)


class Command(Protocol):
    """A sub-command: a dataclass whose fields are the command-line arguments."""

    def execute(self) -> int:
        """Run the command and return the exit status of the process."""
        ...


def has_display() -> bool:
    """Return True if a window can be opened."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def run_cli(
    command: Any,
    *,
    prog: str | None = None,
    description: str | None = None,
    arguments: Sequence[str] | None = None,
) -> None:
    """Run a command with the arguments of this process, and exit with its status.

    Args:
        command: class of the command, or a union of classes for sub-commands.
        prog: name of the program in the help; None: that of the script.
        description: text above the options in the help; None: the docstring of the class.
        arguments: arguments of the command; None: those of the process.
    """
    prepare_streams()
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        parsed = tyro.cli(
            arguments_of(command),
            prog=prog,
            args=words,
            description=description or command.__doc__,
            config=(tyro.conf.CascadeSubcommandArgs,),
        )
        chosen: Any = flat(command, parsed.command)
        check_repetition(words, also_repeatable=getattr(chosen, "REPEATABLE", ()))
        with parsed.shared.applied():
            claim_output()
            sys.exit(execute(chosen))
    except FlybenchError as error:  # raised by arguments that check themselves
        complain(str(error))
        sys.exit(2)
    except SystemExit as end:  # also if the help is printed, or an argument is wrong
        sys.exit(_flushed(end.code))
    except BrokenPipeError:
        discard_output()
        sys.exit(1)


def _flushed(status: Any) -> Any:
    """Flush our output, and return the status; 1 if the reader of our output has closed it."""
    try:
        if own_output() is not None:
            own_output().flush()
    except BrokenPipeError:
        discard_output()
        return 1
    return status


def arguments_of(command: Any) -> Any:
    """Return the class that is parsed: the command, grouped, and the options of all commands."""
    shared = tyro.conf.OmitArgPrefixes[SharedOptions]
    arguments: list[tuple[str, Any, Any]] = [
        ("command", Annotated[grouped(command), tyro.conf.arg(name="")], field()),
        (
            "shared",
            Annotated[shared, tyro.conf.arg(name="general")],
            field(default_factory=SharedOptions),
        ),
    ]
    return make_dataclass("Arguments", arguments)


def execute(command: Command) -> int:
    """Run a command and return the exit status of the process.

    A `FlybenchError` is printed on standard error without a traceback; the status is then 2.
    SIGTERM and SIGHUP act like Ctrl-C, so that temporary files are removed; the status is then 130.
    """
    _handle_signals_as_interrupt()
    start_s = time.perf_counter()
    try:
        status = _executed(command)
    except BaseException:
        log_complaint(traceback.format_exc())
        raise
    log_step(f"status {status} after {time.perf_counter() - start_s:.1f} s")
    return status


def _executed(command: Command) -> int:
    try:
        return int(_flushed(command.execute()))
    except FlybenchError as error:
        log_step(traceback.format_exc())
        complain(str(error))
        return 2
    except MemoryError:
        complain("memory ran out. Close other programs, or choose something smaller.")
        return 2
    except KeyboardInterrupt:
        return _interrupted()
    except SystemError as error:
        if not is_interrupt(error):
            raise
        return _interrupted()
    except BrokenPipeError:  # the reader of our output has closed it
        discard_output()
        return 1
    except OSError as error:
        if not caused_by_full_disk(error):
            raise
        try:
            own_output().flush()
        except OSError:  # it is the standard output that has no room
            discard_output()
        where = f" of {error.filename}" if error.filename else ""
        complain(
            f"The disk{where} is full ({error.strerror}). It is that of the output, of "
            f"{tempfile.gettempdir()} or of the standard output. Free some space there."
        )
        return 2


def report_failures(reasons: Iterable[str]) -> int:
    """Print the reasons why detectors failed on standard error.

    Returns:
        The exit status of a command whose other results are complete: 1 if a detector failed.
    """
    status = 0
    for reason in reasons:
        complain(reason)
        status = 1
    return status


def _handle_signals_as_interrupt() -> None:
    """Raise KeyboardInterrupt on Ctrl-C, SIGTERM and SIGHUP; leave ignored signals ignored."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    hangup = getattr(signal, "SIGHUP", None)  # Windows does not have it
    if hangup is not None and signal.getsignal(hangup) is not signal.SIG_IGN:
        signal.signal(hangup, signal.default_int_handler)


def _interrupted() -> int:
    complain("interrupted")
    return 130
