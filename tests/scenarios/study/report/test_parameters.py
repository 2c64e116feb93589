from dataclasses import dataclass, field

from detector.fly.config import FlyConfig
from scenarios.pipeline.registry import DETECTORS
from scenarios.study.report.parameters import (
    attribute_notes,
    class_description,
    flatten_parameters,
    method_config,
)


@dataclass(frozen=True)
class Inner:
    """An inner class."""

    a: tuple[int, ...] = (1, 2)


@dataclass(frozen=True)
class Outer:
    """An outer class,
    in two lines.

    Attributes:
        x: first line
            and second [px].
        inner: the other.

    Raises:
        ValueError: never.
    """

    x: float = 0.5
    enabled: bool = True
    nothing: None = None
    inner: Inner = field(default_factory=Inner)


def test_notes_and_description_come_from_the_docstring() -> None:
    assert attribute_notes(Outer) == {"x": "first line and second [px].", "inner": "the other."}
    assert class_description(Outer) == "An outer class, in two lines."
    assert attribute_notes(Inner) == {}


def test_nested_parameters_become_a_flat_list() -> None:
    found = [
        (p.name, p.value, p.note)
        for p in flatten_parameters({"n": 3, "outer": Outer(), "empty": {}})
    ]
    assert found == [
        ("n", "3", ""),
        ("outer.x", "0.5", "first line and second [px]."),
        ("outer.enabled", "yes", ""),
        ("outer.nothing", "none", ""),
        ("outer.inner.a", "1, 2", ""),
    ]


def test_every_parameter_of_our_methods_has_a_note() -> None:
    for method in DETECTORS:
        config = method_config(method)
        assert config is not None
        assert all(parameter.note for parameter in flatten_parameters(config)), method
    assert isinstance(method_config("fly"), FlyConfig)
    assert method_config("somebody.elses:Detector") is None
