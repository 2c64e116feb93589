"""What a command does, besides its results: in a log file, and with --verbose on the terminal.

Three levels exist: what the command prints (DEBUG), what it does (INFO), and its warnings and
errors (WARNING). The terminal shows the first and the last anyway.
"""

from __future__ import annotations

import io
import logging
import os
import platform
import shlex
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TextIO

from flybench.files import open_regular
from flybench.printable import printable
from flybench.version import __version__
from scenarios.errors import OutputError

_LOGGER = logging.getLogger("flybench.command")
_LIBRARY = logging.getLogger("flybench")
"""Logger of the packages, which may warn outside of any command."""
_LOGGER.propagate = False
_LOGGER.addHandler(logging.NullHandler())  # otherwise Python would print warnings once more
_FORMAT = logging.Formatter("%(asctime)s %(levelname)s %(message)s")


def log_printed(text: str) -> None:
    """Log a line that the command prints as its result."""
    _LOGGER.debug(printable(text))


def log_step(text: str) -> None:
    """Log what the command does, such as a phase that begins; --verbose shows it."""
    _LOGGER.info(printable(text))


def log_complaint(text: str) -> None:
    """Log a warning or an error that the command prints on standard error."""
    _LOGGER.warning(printable(text))


@contextmanager
def logging_to(path: Path | None, *, verbose: bool) -> Iterator[None]:
    """Log while the block runs.

    Args:
        path: log file, to which lines are added; None: no file.
        verbose: True to print what the command does on standard error.

    Raises:
        OutputError: the log file cannot be written.
    """
    _LOGGER.setLevel(logging.DEBUG)
    with ExitStack() as stack:
        if path is not None:
            file = _FileHandler(stack.enter_context(_opened(path)))
            file.setFormatter(_FORMAT)
            _add(stack, _LOGGER, file)
            _add(stack, _LIBRARY, file)
            if logging.lastResort is not None:  # it is used only while there is no other handler
                _add(stack, _LIBRARY, logging.lastResort)
        if verbose:
            _add(stack, _LOGGER, _TerminalHandler())
        log_step(f"flybench {__version__}, Python {platform.python_version()}")
        with suppress(OSError):  # the current folder may be gone
            log_step(f"in {os.getcwd()}: {shlex.join(['flybench', *sys.argv[1:]])}")  # noqa: PTH109
        yield


def _opened(path: Path) -> TextIO:
    try:
        return io.TextIOWrapper(open_regular(path, "ab"), encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"--log {path} cannot be written ({error.strerror}). Allowed is a file in an existing "
            "folder, to which lines are added. Choose another place."
        ) from error


def _add(stack: ExitStack, logger: logging.Logger, handler: logging.Handler) -> None:
    logger.addHandler(handler)
    stack.callback(logger.removeHandler, handler)


class _FileHandler(logging.StreamHandler[TextIO]):
    """Writes each line at once; says once that it cannot, for example because the disk is full."""

    _failed = False

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002, N802
        if not self._failed:
            self._failed = True
            _print(f"warning: the log file cannot be written ({sys.exc_info()[1]}).")


class _TerminalHandler(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno == logging.INFO:
            _print(record.getMessage())


def _print(text: str) -> None:
    with suppress(OSError):
        sys.stderr.write(f"flybench: {text}\n")
        sys.stderr.flush()
