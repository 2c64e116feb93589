"""Distractors as options of a command."""

from __future__ import annotations

from dataclasses import dataclass, fields

from sim import Distractors


@dataclass(frozen=True)
class DistractorOptions(Distractors):  # noqa: D101, since it has that of its parent
    __doc__ = Distractors.__doc__

    def __post_init__(self) -> None:
        """Leave the checks to `checked`, whose refusals the commands turn into a sentence."""

    def checked(self) -> Distractors:
        """The distractors that the options ask for.

        Raises:
            SceneConfigError: a value is outside its range.
        """
        return Distractors(**{item.name: getattr(self, item.name) for item in fields(self)})
