"""Distractors as command-line options."""

from __future__ import annotations

from dataclasses import dataclass, fields

from sim import Distractors


@dataclass(frozen=True)
class DistractorOptions(Distractors):  # noqa: D101  (the docstring is that of the base class)
    __doc__ = Distractors.__doc__

    def __post_init__(self) -> None:
        """Skip the checks of the base class; `checked` does them, where commands report errors."""

    def checked(self) -> Distractors:
        """Return the distractors that the options describe.

        Raises:
            SceneConfigError: a value is out of its range.
        """
        return Distractors(**{item.name: getattr(self, item.name) for item in fields(self)})
