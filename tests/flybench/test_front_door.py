"""`import flybench` offers every public name, and imports it when it is first used."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import flybench
import scenarios

PACKAGES = {"flybench": flybench, "scenarios": scenarios}


@pytest.mark.parametrize("name", flybench.__all__)
def test_every_name_resolves(name: str) -> None:
    assert getattr(flybench, name) is not None
    assert name in dir(flybench)


@pytest.mark.parametrize("package", PACKAGES)
def test_type_checkers_see_the_same_names(package: str) -> None:
    module = PACKAGES[package]
    tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
    (block,) = [n for n in tree.body if isinstance(n, ast.If) and "not" not in ast.unparse(n.test)]
    froms = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    seen = {(node.module, alias.name) for node in froms for alias in node.names}
    offered = {(source, name) for source, names in module._MODULES.items() for name in names}
    assert seen == offered
    assert sorted(name for _, name in offered) == sorted(module.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'flybench' has no attribute 'Bee'"):
        flybench.Bee  # type: ignore[attr-defined]  # noqa: B018


def test_importing_it_loads_nothing_heavy() -> None:
    script = "import sys, flybench; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n"


def test_python_m_flybench_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "flybench", "--version"], capture_output=True, text=True
    )
    assert done.stdout == f"flybench {flybench.__version__}\n"


def test_a_home_that_cannot_be_written_to_costs_one_line(tmp_path: Path) -> None:
    blocked = tmp_path / "blocked"
    blocked.write_text("a file, where no folder can be created")
    environment = os.environ | {"HOME": str(blocked), "NUMBA_CACHE_DIR": str(blocked)}
    done = subprocess.run(
        [sys.executable, "-m", "flybench", "doctor", "--help"],
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0
    assert done.stderr.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in done.stderr


def without(library: str, script: str) -> subprocess.CompletedProcess[str]:
    """Run a script where a library is not installed."""
    blocked = f"import sys; sys.modules[{library!r}] = None; {script}"
    return subprocess.run([sys.executable, "-c", blocked], capture_output=True, text=True)


def test_the_version_needs_no_library() -> None:
    script = "sys.argv = ['flybench', '--version']; from flybench.__main__ import main; main()"
    assert without("tyro", script).stdout == f"flybench {flybench.__version__}\n"


def test_the_command_names_a_library_that_is_missing() -> None:
    done = without("tyro", "from flybench.__main__ import main; main()")
    assert done.returncode == 1
    assert done.stderr == (
        "flybench: the command needs the library tyro, which is not installed. "
        "Install all that it needs with: pip install 'flybench[all]'\n"
    )


def test_a_name_whose_library_is_missing_raises_an_import_error() -> None:
    done = without("mujoco", "import flybench; flybench.FlyDetector; flybench.Crossing")
    assert "flybench.Crossing needs the library mujoco, which is not installed." in done.stderr
