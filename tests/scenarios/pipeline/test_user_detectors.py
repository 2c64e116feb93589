"""Finding detectors by name."""

from pathlib import Path

import pytest

from flybench.memory import MemoryBudgetError
from scenarios.errors import MethodError
from scenarios.pipeline.registry import DETECTORS
from scenarios.pipeline.user_detectors import find_method

pytestmark = pytest.mark.usefixtures("user_modules")


def test_a_registered_name_is_found() -> None:
    assert find_method("wide") is DETECTORS["wide"]


def test_a_users_class_gets_the_sensors_size() -> None:
    method = find_method("some_detectors:Good")
    assert method.name == "some_detectors:Good"
    assert method.make(width=64, height=48).size == (64, 48)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("bee", ("'bee'", "fly, wide", "package.module:Class")),
        ("some_detectors", ("'some_detectors'", "package.module:Class")),
        ("some_detectors:", ("package.module:Class",)),
        ("nowhere:Good", ("no module nowhere", "PYTHONPATH")),
        ("nowhere.deeper:Good", ("no module nowhere",)),
        ("some_detectors.deeper:Good", ("no module some_detectors.deeper",)),
        ("broken:Good", ("broken", "cannot be imported", "some_library_that_is_not_there", "line")),
        ("quitting:Good", ("quitting", "cannot be imported", "SystemExit: 0 (quitting.py, line 1")),
        ("misspelt:Good", ("misspelt", "cannot be imported", "SyntaxError")),
        ("some_detectors:Bad", ("no class Bad", "Available in this module: Good")),
        ("some_detectors:NoAdvance", ("has no method advance", "Available in this module: Good")),
        ("some_detectors:function", ("has no method push or advance",)),
        ("some_detectors:Direction", ("has no method",)),
        ("some_detectors:NeedsGain", ("NeedsGain(width=346, height=260)", "'gain'")),
    ],
)
def test_an_unusable_name_is_refused_with_the_reason(name: str, words: tuple[str, ...]) -> None:
    with pytest.raises(MethodError) as refused:
        find_method(name)
    for word in words:
        assert word in str(refused.value)


def test_too_little_memory_is_no_error_of_a_users_class() -> None:
    make = find_method("some_detectors:Large").make
    with pytest.raises(MemoryBudgetError, match=r"^A large detector needs 9e"):
        make(width=346, height=260)


def test_an_error_in_a_users_class_is_reported_with_its_place() -> None:
    make = find_method("some_detectors:Breaking").make
    with pytest.raises(MethodError, match=r"ZeroDivisionError: no room \(some_detectors.py, line"):
        make(width=346, height=260)


OWN = "import {name}\nclass Own:\n    def push(self, events): return []\n"
OWN += "    def advance(self, t_us): return []\n    def __init__(self, *, width, height): pass\n"


@pytest.mark.parametrize("is_package", [True, False])
def test_a_users_module_in_a_package_of_our_name_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_package: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "detector"
    folder.mkdir()
    if is_package:
        (folder / "__init__.py").touch()
    (folder / "mine.py").write_text(OWN.format(name="detector.fly"))  # ours, not theirs
    made = find_method("detector.mine:Own").make(width=346, height=260)
    assert type(made).__name__ == "Own"
    assert find_method("fly") is DETECTORS["fly"]
    with pytest.raises(MethodError, match=r"no module detector\.other"):
        find_method("detector.other:Own")


def test_the_users_folder_comes_before_the_search_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here := tmp_path / "here").mkdir()
    (here / "some_detectors.py").write_text(OWN.format(name="sys"))
    monkeypatch.chdir(here)
    monkeypatch.delitem(__import__("sys").modules, "some_detectors", raising=False)
    assert find_method("some_detectors:Own").make(width=346, height=260)
    monkeypatch.delitem(__import__("sys").modules, "some_detectors")
