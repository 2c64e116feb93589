"""Refuse options that are given more than once; the parser would silently use the last value."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from scenarios.errors import ScenarioError

REPEATABLE = frozenset({"--set"})
"""Options that may be repeated in every command that has them."""


def check_repetition(arguments: Sequence[str], *, also_repeatable: Collection[str] = ()) -> None:
    """Check that no option is given more than once, unless it may be repeated.

    Args:
        arguments: arguments of the command line.
        also_repeatable: options that may be repeated, besides `REPEATABLE`.

    Raises:
        ScenarioError: an option is repeated.
    """
    options = [a.partition("=")[0].replace("_", "-") for a in arguments if a.startswith("--")]
    for option, count in Counter(options).items():
        if option != "--" and count > 1 and option not in REPEATABLE.union(also_repeatable):
            raise ScenarioError(
                f"{option} is given {count} times. Allowed is one occurrence. If it takes several "
                "values, give them after one another."
            )
