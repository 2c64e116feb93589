"""Random samples of parameters, and the distributions that they are drawn from."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.errors import ScenarioError
from scenarios.sweep.parameters import Settings, converted

UNIFORM, LOG_UNIFORM, CHOICE = "uniform", "log_uniform", "choice"
_FORMS = "{uniform = [low, high]}, {log_uniform = [low, high]} or {choice = [one, another]}"


@dataclass(frozen=True)
class Distribution:
    """Distribution of one parameter.

    Attributes:
        name: name of the parameter.
        kind: "uniform", "log_uniform" or "choice".
        values: lowest and highest value, or the values to choose from, of the parameter's type. For
            a whole number, both bounds can be drawn.
    """

    name: str
    kind: str
    values: tuple[Any, ...]

    @property
    def whole(self) -> bool:
        """True if all values are whole numbers."""
        return all(type(value) is int for value in self.values)

    def draw(self, count: int, seed: int) -> list[Any]:
        """Draw values.

        The values depend only on name, distribution and seed. Adding another parameter does not
        change them, and a larger count only appends values.
        """
        name_seed = int.from_bytes(hashlib.sha256(self.name.encode()).digest()[:8], "big")
        random = np.random.default_rng([seed, name_seed]).random(count)
        if self.kind == CHOICE:
            return [self.values[int(u * len(self.values))] for u in random]
        low, high = self.values
        whole = self.whole
        if whole:
            low, high = low, high + 1
        if self.kind == UNIFORM:
            drawn = [low + (high - low) * float(u) for u in random]
        else:
            drawn = [low * math.exp(float(u) * math.log(high / low)) for u in random]
        return [min(int(value), self.values[1]) if whole else value for value in drawn]


def parse_distribution(
    name: str,
    entry: Any,
    place: str = "[sample]",
    convert: Callable[[str, Any], Any] = converted,
) -> Distribution:
    """Return the distribution of a parameter from its entry in the file.

    Args:
        name: name of the parameter.
        entry: its value in the file.
        place: table of the file that it is in, for messages.
        convert: function that checks a value of a parameter and converts it.

    Raises:
        ScenarioError: the entry is not one of the known forms, or its bounds are invalid.
    """
    known = (UNIFORM, LOG_UNIFORM, CHOICE)
    if not (isinstance(entry, Mapping) and len(entry) == 1 and next(iter(entry)) in known):
        raise ScenarioError(
            f"{name} is {entry!r}. Allowed in {place} is {_FORMS}. Choose one of these forms."
        )
    ((kind, values),) = entry.items()
    if not isinstance(values, list) or not values:
        raise ScenarioError(
            f"{name} is {entry!r}. Allowed is {_FORMS}. Write the values in square brackets."
        )
    typed = tuple(convert(name, value) for value in values)
    if kind != CHOICE:
        _check_bounds(name, entry, kind, typed)
    return Distribution(name, kind, typed)


def _check_bounds(name: str, entry: Any, kind: str, bounds: tuple[Any, ...]) -> None:
    if not all(type(value) in (int, float) for value in bounds):
        raise ScenarioError(
            f"{name} is {entry!r}. Allowed is {{choice = [one, another]}}, because this parameter "
            "is not a number. List the values to choose from."
        )
    least = 0.0 if kind == LOG_UNIFORM else -math.inf
    if len(bounds) != 2 or not least < bounds[0] < bounds[1] < math.inf:
        above = " and above 0" if kind == LOG_UNIFORM else ""
        raise ScenarioError(
            f"{name} is {entry!r}. Allowed is {{{kind} = [low, high]}} with low below high{above}. "
            "Correct the two numbers."
        )


@dataclass(frozen=True)
class RandomSample:
    """A random sample of points.

    Attributes:
        distributions: distribution of every parameter that is drawn.
        count: number of points.
        seed: seed of the draws.
    """

    distributions: tuple[Distribution, ...]
    count: int
    seed: int = 0

    def settings(self) -> list[Settings]:
        """Return the values of every point, in the order of drawing."""
        columns = {d.name: d.draw(self.count, self.seed) for d in self.distributions}
        return [{name: drawn[n] for name, drawn in columns.items()} for n in range(self.count)]
