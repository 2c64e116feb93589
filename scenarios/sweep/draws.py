"""A random sample: how each of its parameters is drawn."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.errors import ScenarioError
from scenarios.sweep.parameters import Settings, converted, parameter_types

UNIFORM, LOG_UNIFORM, CHOICE = "uniform", "log_uniform", "choice"
_FORMS = "{uniform = [low, high]}, {log_uniform = [low, high]} or {choice = [one, another]}"


@dataclass(frozen=True)
class Draw:
    """How one parameter is drawn.

    Attributes:
        name: of the parameter.
        law: "uniform", "log_uniform" or "choice".
        values: low and high, or all that there is to choose from; of the parameter's type. Of a
            whole number, low and high are drawn too.
    """

    name: str
    law: str
    values: tuple[Any, ...]

    def draw(self, count: int, seed: int) -> list[Any]:
        """Draw values.

        They depend on nothing but the name, the law and the seed, so that a further parameter
        leaves these as they are, and a greater count only adds to them.
        """
        own = int.from_bytes(hashlib.sha256(self.name.encode()).digest()[:8], "big")
        random = np.random.default_rng([seed, own]).random(count)
        if self.law == CHOICE:
            return [self.values[int(u * len(self.values))] for u in random]
        low, high = self.values
        whole = parameter_types()[self.name] is int
        if whole:
            low, high = low, high + 1
        if self.law == UNIFORM:
            drawn = [low + (high - low) * float(u) for u in random]
        else:
            drawn = [low * math.exp(float(u) * math.log(high / low)) for u in random]
        return [min(int(value), self.values[1]) if whole else value for value in drawn]


def parse_draw(name: str, law: Any) -> Draw:
    """How a parameter is drawn, from its entry in the file.

    Raises:
        ScenarioError: it is none of the forms there are, or the bounds are no bounds.
    """
    known = (UNIFORM, LOG_UNIFORM, CHOICE)
    if not (isinstance(law, Mapping) and len(law) == 1 and next(iter(law)) in known):
        raise ScenarioError(f"{name} is {law!r}; allowed in [sample] is {_FORMS}; give one of them")
    ((form, values),) = law.items()
    if not isinstance(values, list) or not values:
        raise ScenarioError(f"{name} is {law!r}; allowed is {_FORMS}; put values in the brackets")
    typed = tuple(converted(name, value) for value in values)
    if form != CHOICE:
        _check_bounds(name, law, form, typed)
    return Draw(name, form, typed)


def _check_bounds(name: str, law: Any, form: str, bounds: tuple[Any, ...]) -> None:
    kind = parameter_types()[name]
    if kind not in (int, float):
        raise ScenarioError(
            f"{name} is {law!r}; allowed for what is no number is {{choice = [one, another]}}; "
            "list what to choose from"
        )
    least = 0.0 if form == LOG_UNIFORM else -math.inf
    if len(bounds) != 2 or not least < bounds[0] < bounds[1] < math.inf:
        above = " and above 0" if form == LOG_UNIFORM else ""
        raise ScenarioError(
            f"{name} is {law!r}; allowed is {{{form} = [low, high]}} with low below high{above}; "
            "give two such numbers"
        )


@dataclass(frozen=True)
class Sample:
    """A random sample.

    Attributes:
        draws: of every parameter that is drawn.
        count: how many points.
        seed: of the draws.
    """

    draws: tuple[Draw, ...]
    count: int
    seed: int = 0

    def settings(self) -> list[Settings]:
        """The values of every point, in the order of drawing."""
        columns = {draw.name: draw.draw(self.count, self.seed) for draw in self.draws}
        return [{name: drawn[n] for name, drawn in columns.items()} for n in range(self.count)]
