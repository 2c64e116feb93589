"""The Rerun viewer as a process: its program, its ports, and its end."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import rerun_cli

HOST = "127.0.0.1"
_PR_SET_PDEATHSIG = 1
"""Option of prctl(2): the signal that a process gets when its parent ends."""


def viewer_program() -> str:
    """Return the path of the Rerun viewer.

    Its Python entry point would start it as another process, which would survive this command.
    """
    return str(Path(rerun_cli.__file__).with_name("rerun"))


def end_with_parent() -> Callable[[], None] | None:
    """Return the `preexec_fn` of a child that is to end when this process ends, even by SIGKILL.

    The thread that starts the child must live as long as it. None where the system is not Linux.
    """
    if not sys.platform.startswith("linux"):
        return None
    parent, prctl = os.getpid(), ctypes.CDLL(None).prctl

    def prepare() -> None:
        prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it has ended already
            os._exit(1)

    return prepare


def is_free(port: int) -> bool:
    """Return True if nothing listens at a port of this machine."""
    try:
        socket.create_server((HOST, port)).close()
    except OSError:
        return False
    return True


def free_port(preferred: int = 0, *, reserved: int | None = None) -> int:
    """Return a port at which nothing listens: the preferred one, if it is free.

    Args:
        preferred: a port; 0: any.
        reserved: port to leave free for another server; None: there is none.
    """
    if preferred not in (0, reserved) and is_free(preferred):
        return preferred
    with socket.create_server((HOST, 0)) as probe:
        port = int(probe.getsockname()[1])
    return free_port(reserved=reserved) if port == reserved else port
