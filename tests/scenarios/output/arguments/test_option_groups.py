"""Groups of options: the help shows them, and the command gets the same values as without."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import pytest
import tyro

from scenarios.cli import COMMANDS, command_class
from scenarios.output.arguments.option_groups import flat, grouped


@dataclass(frozen=True)
class Inner:
    """The inner options."""

    depth: int = 3
    """Depth of the inner thing."""


@dataclass(frozen=True)
class Command:
    """Do something."""

    GROUPS: ClassVar = {"look": ("colour", "size"), "inner": ("width",)}
    name: Annotated[str, tyro.conf.Positional]
    """Name of the thing."""
    colour: str = "red"
    """Colour of the thing."""
    size: Annotated[float | None, tyro.conf.arg(help_behavior_hint="(default: any)")] = None
    """Size of the thing."""
    width: int = 1
    """Width of the thing."""
    inner: tyro.conf.OmitArgPrefixes[Inner] = field(default_factory=Inner)


def test_the_values_are_those_of_the_flat_command() -> None:
    words = ["this", "--size", "2", "--depth", "4", "--width", "5"]
    parsed = flat(Command, tyro.cli(grouped(Command), args=words))
    assert parsed == Command("this", "red", 2.0, 5, Inner(4))
    assert flat(Command, tyro.cli(grouped(Command), args=["this"])) == Command("this")


def test_the_help_shows_the_groups_with_the_texts(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        tyro.cli(grouped(Command), args=["--help"])
    text = capsys.readouterr().out.partition("\n")[2]  # without the usage
    assert text.index("look options") < text.index("--colour") < text.index("inner options")
    assert text.index("inner options") < text.index("--depth") < text.index("--width")
    assert "Size of the thing. (default: any)" in text
    assert "Name of the thing." in text


def test_a_command_without_groups_is_left_as_it_is() -> None:
    assert grouped(Inner) is Inner
    assert flat(Inner, Inner(5)) == Inner(5)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_field_of_a_group_exists(name: str) -> None:
    command = command_class(name)
    groups = getattr(command, "GROUPS", {})
    names = [name for members in groups.values() for name in members]
    assert set(names) <= set(command.__dataclass_fields__)
    assert len(set(names)) == len(names)
    empty = [group for group, members in groups.items() if not members]
    assert set(empty) <= set(command.__dataclass_fields__)
