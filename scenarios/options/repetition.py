"""An option given twice: all but the last value would be lost without a word."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from scenarios.errors import ScenarioError

TAKES_SEVERAL = frozenset({"--set"})
"""Options that collect what they are given, in every command that has them."""


def refuse_repetition(arguments: Sequence[str], *, also_several: Collection[str] = ()) -> None:
    """Refuse an option that is given more than once, and takes one value.

    Args:
        arguments: of the command line.
        also_several: further options that may be given several times.

    Raises:
        ScenarioError: one is.
    """
    options = [a.partition("=")[0].replace("_", "-") for a in arguments if a.startswith("--")]
    for option, times in Counter(options).items():
        if option != "--" and times > 1 and option not in TAKES_SEVERAL.union(also_several):
            raise ScenarioError(
                f"{option} is given {times} times; allowed is once, since only the last would "
                "count; where it takes several values, give them after one another"
            )
