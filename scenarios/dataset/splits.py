"""Splits of a dataset, and values that no two splits share."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

from scenarios.errors import ScenarioError
from scenarios.sweep.random_sample import CHOICE, UNIFORM, Distribution

STREET, VEHICLE = "street", "vehicle"
SHORT_NAMES = {STREET: "crossing.street_seed", VEHICLE: "crossing.vehicle"}
"""Words for parameters in the list of what is disjoint."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_RESERVED = ("annotations", "figures")


def check_name(key: str, name: str) -> None:
    """Check the name of a split, which is the name of a folder.

    Raises:
        ScenarioError: it is not made of small letters, digits and "_", or is reserved.
    """
    if not _NAME.fullmatch(name) or name in _RESERVED:
        raise ScenarioError(
            f"{key} is the name of a split. Allowed are small letters, digits and _, and not "
            f"{' or '.join(_RESERVED)}. Choose another name, such as train."
        )


def apportion(total: int, counts: Sequence[int]) -> list[int]:
    """Divide a total in proportion to counts, with at least one for each (largest remainder).

    Args:
        total: number of values, at least one for each count.
        counts: numbers of sequences.

    Returns:
        Whole numbers that add up to `total`.
    """
    free, whole = total - len(counts), sum(counts)
    exact = [free * count / whole for count in counts]
    shares = [int(share) for share in exact]
    by_remainder = sorted(range(len(counts)), key=lambda k: (shares[k] - exact[k], k))
    for k in by_remainder[: free - sum(shares)]:
        shares[k] += 1
    return [1 + share for share in shares]


def divide(distribution: Distribution, counts: Mapping[str, int]) -> dict[str, Distribution]:
    """Divide the values of a distribution among splits, so that no two of them share a value.

    Each split gets consecutive values, in proportion to its number of sequences.

    Args:
        distribution: a choice, or whole numbers of equal probability.
        counts: number of sequences of each split.

    Raises:
        ScenarioError: the distribution has fewer values than there are splits, or infinitely many.
    """
    values = distribution.values
    is_whole = distribution.kind == UNIFORM and distribution.whole
    if distribution.kind != CHOICE and not is_whole:
        raise ScenarioError(
            f"splits.disjoint holds {distribution.name}, which is {_shown(distribution)}. Allowed "
            "are parameters that are drawn by {choice = [one, another]}, or whole numbers by "
            "{uniform = [low, high]}. Change it, or remove it from the list."
        )
    size = values[1] - values[0] + 1 if is_whole else len(set(values))
    if size < len(counts):
        raise ScenarioError(
            f"splits.disjoint holds {distribution.name}, which is {_shown(distribution)}: "
            f"{size} different values for {len(counts)} splits. Allowed is one value or more for "
            "each split. Add values, or remove it from the list."
        )
    bounds = [0, *accumulate(apportion(size, list(counts.values())))]
    parts = {}
    distinct = tuple(dict.fromkeys(values))
    for name, (start, end) in zip(counts, pairwise(bounds), strict=True):
        part = (values[0] + start, values[0] + end - 1) if is_whole else distinct[start:end]
        parts[name] = replace(distribution, values=part)
    return parts


def _shown(distribution: Distribution) -> str:
    return f"{{{distribution.kind} = {list(map(_plain, distribution.values))}}}"


def _plain(value: object) -> object:
    return value.value if hasattr(value, "value") else value
