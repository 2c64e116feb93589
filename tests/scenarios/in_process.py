"""Run flybench in the process of the tests, with arguments as a user types them.

A process of its own takes 1 to 3 s to start. It is needed only where a test looks at the streams,
the signals or the exit of the process itself.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

import pytest

from flybench.memory import VARIABLE
from scenarios.cli import main
from scenarios.output import terminal


def exit_status(arguments: Sequence[str]) -> Any:
    """Return the exit status of `flybench ARGUMENTS`; what it prints is left to `capsys`."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("prepare_streams", "claim_output"):  # pytest has its own streams
            patch.setattr(terminal, name, lambda: None)
        patch.setenv(VARIABLE, os.environ.get(VARIABLE, ""))  # --memory-gb sets it
        patch.setattr(sys, "argv", ["flybench", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
    return end.value.code
