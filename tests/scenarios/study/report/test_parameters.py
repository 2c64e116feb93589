from dataclasses import dataclass, field

from detector.fly.config import FlyConfig
from scenarios.pipeline.registry import DETECTORS
from scenarios.study.report.parameters import attribute_notes, flat, method_config, opening


@dataclass(frozen=True)
class Inner:
    """What is inside."""

    a: tuple[int, ...] = (1, 2)


@dataclass(frozen=True)
class Outer:
    """What is outside,
    in two lines.

    Attributes:
        x: first line
            and second [px].
        inner: the other.

    Raises:
        ValueError: never.
    """

    x: float = 0.5
    is_so: bool = True
    nothing: None = None
    inner: Inner = field(default_factory=Inner)


def test_notes_and_opening_come_from_the_docstring() -> None:
    assert attribute_notes(Outer) == {"x": "first line and second [px].", "inner": "the other."}
    assert opening(Outer) == "What is outside, in two lines."
    assert attribute_notes(Inner) == {}


def test_nested_parameters_become_a_flat_list() -> None:
    found = [(p.name, p.value, p.note) for p in flat({"n": 3, "outer": Outer(), "empty": {}})]
    assert found == [
        ("n", "3", ""),
        ("outer.x", "0.5", "first line and second [px]."),
        ("outer.is_so", "yes", ""),
        ("outer.nothing", "none", ""),
        ("outer.inner.a", "1, 2", ""),
    ]


def test_every_parameter_of_our_methods_names_its_meaning() -> None:
    for method in DETECTORS:
        config = method_config(method)
        assert config is not None
        assert all(parameter.note for parameter in flat(config)), method
    assert isinstance(method_config("fly"), FlyConfig)
    assert method_config("somebody.elses:Detector") is None
