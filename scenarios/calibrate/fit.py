"""The result of one fit: parameters of the sensor with their evidence, and its part of the page."""

from __future__ import annotations

from dataclasses import dataclass

from emulator.characterisation import Section


@dataclass(frozen=True)
class Parameter:
    """A parameter of the sensor, by its name in `emulator.SensorConfig`.

    Attributes:
        name: its name; dotted for a parameter of frames or readout.
        unit: its unit; empty for a pure number.
        value: estimate; None if the recording cannot tell it.
        interval: 95 % interval of the estimate; None if it has none.
        evidence: how much data the estimate rests on; or why there is none. A sentence without a
            capital and a full stop.
    """

    name: str
    unit: str
    value: float | int | None
    interval: tuple[float, float] | None
    evidence: str

    @property
    def text(self) -> str:
        """Evidence, with the interval before it."""
        if self.value is None:
            return f"not told by the recording: {self.evidence}"
        if self.interval is None:
            return self.evidence
        low, high = (f"{value:.3g}" for value in self.interval)
        unit = f" {self.unit}" if self.unit else ""
        return f"{low} to {high}{unit} (95 %), {self.evidence}"


def unknown(name: str, unit: str, reason: str) -> Parameter:
    """Return a parameter that the recording cannot tell, for a reason."""
    return Parameter(name, unit, None, None, reason)


@dataclass(frozen=True, eq=False)
class Fit:
    """One fit.

    Attributes:
        key: name in JSON and in the page.
        parameters: parameters of the sensor that it estimates.
        section: method, other figures and plots, for the page.
    """

    key: str
    parameters: tuple[Parameter, ...]
    section: Section

    def value(self, name: str) -> float | int | None:
        """Return the estimate of a parameter; None if the recording cannot tell it."""
        return next(p.value for p in self.parameters if p.name == name)
