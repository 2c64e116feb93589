"""How kernels are compiled, and where they are cached."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import flybench
from flybench.kernels import compiled

ROOT = Path(flybench.__file__).parent.parent
OUTER = """
from flybench.kernels import compiled
from inner import inner

@compiled
def outer(x):
    return inner(x) + 1
"""
INNER = """
from flybench.kernels import compiled

@compiled
def inner(x):
    return {} * x
"""


def run(script: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join([str(folder), str(ROOT)])
    return subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"PYTHONPATH": paths} | environment,
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.mark.parametrize("elsewhere", [False, True])
def test_an_edited_inner_kernel_is_compiled_again(tmp_path: Path, elsewhere: bool) -> None:
    environment = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")} if elsewhere else {}
    (tmp_path / "outer.py").write_text(OUTER)
    script = "from outer import outer; print(outer(4), sum(outer.stats.cache_hits.values()))"
    said = []
    for factor in (2, 2, 3):
        (tmp_path / "inner.py").write_text(INNER.format(factor))
        said.append(run(script, tmp_path, **environment).stdout.split())
    assert said == [["9", "0"], ["9", "1"], ["13", "0"]]


def test_kernels_cached_with_a_renamed_class_are_compiled_again(tmp_path: Path) -> None:
    """The index of Numba contains the names of the arguments' classes, which may no longer exist
    when it is read."""
    source = """
from typing import NamedTuple
from flybench.kernels import compiled

class {0}(NamedTuple):
    x: float

@compiled
def first(pair):
    return pair.x

print(first({0}(1.5)))
"""
    for name in ("Pair", "Couple"):
        (tmp_path / "pairs.py").write_text(source.format(name))
        assert run("import pairs", tmp_path).stdout == "1.5\n"


def test_no_writable_folder_costs_one_line_and_nothing_else(tmp_path: Path) -> None:
    blocked = tmp_path / "blocked"
    blocked.write_text("a file, where no folder can be created")
    (tmp_path / "outer.py").write_text(OUTER)
    (tmp_path / "inner.py").write_text(INNER.format(2))
    environment = {"NUMBA_CACHE_DIR": str(blocked), "HOME": str(blocked)}
    done = run("from outer import outer; print(outer(4))", tmp_path, **environment)
    assert done.stdout == "9\n"
    assert done.stderr.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in done.stderr


def test_every_kernel_is_compiled_by_one_function() -> None:
    packages = ("sim", "emulator", "detector", "formats", "scenarios")
    sources = [path for package in packages for path in (ROOT / package).rglob("*.py")]
    assert len(sources) > 200
    assert [p for p in sources if "njit" in p.read_text(encoding="utf-8")] == []


def test_a_kernel_is_compiled_once_whatever_constants_it_is_called_with() -> None:
    @compiled
    def inner(number: int, scale: float) -> float:
        return number * scale

    @compiled
    def outer(size: int) -> float:
        found, total = 0, 0.0
        while found < size:
            total += inner(found, 2.0) + inner(5, 3.0)
            found += 1
        return total

    assert outer(3) == 2.0 * 3 + 15.0 * 3
    assert len(inner.signatures) == 1  # type: ignore[attr-defined]
