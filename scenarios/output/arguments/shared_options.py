"""The options that every command has."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from flybench.memory import DEFAULT_GB, VARIABLE, budget_gb, set_budget
from scenarios.errors import ScenarioError
from scenarios.output.log import logging_to
from scenarios.output.progress import show_progress


@dataclass(frozen=True)
class SharedOptions:
    """Options of every command."""

    verbose: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Print what the command does as it goes, and where an error was raised, on standard error."""
    quiet: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Show no progress. Results, warnings and errors are still printed."""
    log: Annotated[
        Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="(default: no log file)")
    ] = None
    """Add what the command does and prints to this file, with the time; tables are left out."""
    memory_gb: Annotated[
        float | None,
        tyro.conf.arg(
            metavar="GB", help_behavior_hint=f"(default: ${VARIABLE}, or {DEFAULT_GB:g})"
        ),
    ] = None
    """Memory for large arrays in each process [GB]. What would need more is refused."""

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Apply the options while the block runs.

        Raises:
            ScenarioError: a command cannot be both verbose and quiet.
            OutputError: the log file cannot be written.
            MemoryBudgetError: the memory budget is not a positive number.
        """
        if self.verbose and self.quiet:
            raise ScenarioError(
                "--verbose and --quiet are given. Allowed is one of them. Leave the other out."
            )
        set_budget(budget_gb() if self.memory_gb is None else self.memory_gb)
        with logging_to(self.log, verbose=self.verbose), show_progress(not self.quiet):
            yield
