"""The structure of the code: which packages and folders may import which, and which package may
import a heavy library."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("flybench", "sim", "emulator", "detector", "formats", "scenarios")

ALLOWED = {
    "flybench": set(),
    "sim": {"flybench"},
    "emulator": {"flybench"},
    "detector": {"flybench"},
    "formats": {"flybench", "emulator"},
    "scenarios": {"flybench", "sim", "emulator", "detector", "formats"},
}
"""Packages that each package may import. `flybench/__init__.py`, the public interface, is an
exception."""

LAYERS = {
    "sim": (
        "errors geometry raster motion distractors config scene render truth cache shadows "
        "compositing keyframes crossing event_truth photometric_camera moving_model preview"
    ),
    "emulator": (
        "errors aps.config readout.config config noise arguments biases readout.event_keys "
        "luminance_frames grey_levels readout pixel presets aps thread_pool sensor "
        "characterisation"
    ),
    "detector": (
        "errors estimate cells event_checks denoise windowed decision fly metrics frame_fly "
        "contrast_maximisation plane_fit space_time_filters spiking_delays time_difference"
    ),
    "formats": (
        "errors bytes_read samples columns identify column_order time_unit event_order sensor_size "
        "prophesee_sensors readers parser_process isolated_reader held_back chunk event_file "
        "writers"
    ),
    "scenarios": (
        "errors output pipeline styles options recording runs datasheet convergence "
        "detect convert validate event_statistics compare emulate calibrate envelope sweep "
        "velocity_sweep study dataset datasets denoise film commands cli"
    ),
}
"""Folders and modules inside a package, lowest first. Each may import those before it.

A module of a folder may stand apart from it, such as `aps.config`.
"""


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def sources(folder: str) -> Iterator[tuple[Path, str]]:
    for path in sorted((ROOT / folder).rglob("*.py")):
        yield from ((path.relative_to(ROOT), name) for name in imports(path))


@pytest.mark.parametrize(("library", "owner"), [("mujoco", "sim"), ("rerun", "scenarios")])
def test_only_one_package_imports_a_heavy_library(library: str, owner: str) -> None:
    users = {p for p in PACKAGES for _, name in sources(p) if name.split(".")[0] == library}
    assert users == {owner}


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_import_one_way(package: str) -> None:
    others = set(PACKAGES) - ALLOWED[package] - {package}
    front_door = {Path("flybench/__init__.py"), Path("flybench/__main__.py")}
    wrong = [
        (path, name)
        for path, name in sources(package)
        if name.split(".")[0] in others and path not in front_door
    ]
    assert wrong == []


@pytest.mark.parametrize("package", LAYERS)
def test_folders_import_one_way(package: str) -> None:
    layers = LAYERS[package].split()

    def layer(name: str) -> int:
        """Place of a dotted name below the package: the longest entry that it begins with."""
        found = [entry for entry in layers if f"{name}.".startswith(f"{entry}.")]
        assert found, f"{package}.{name} is in no layer; add it to LAYERS"
        return layers.index(max(found, key=len))

    wrong = []
    for path, name in sources(package):
        own = ".".join(path.with_suffix("").parts[1:]).removesuffix(".__init__")
        theirs = name.removeprefix(f"{package}.")
        if own == "__init__" or not name.startswith(f"{package}."):
            continue
        if layer(theirs) > layer(own):
            wrong.append(f"{path} imports {name}")
    assert wrong == []


def test_parsers_import_only_the_errors_of_flybench() -> None:
    modules = {path.relative_to(ROOT) for path in (ROOT / "formats").glob("*.py")}
    others = ("__init__.py", "chunk.py", "held_back.py", "event_file.py")
    parsers = modules - {Path("formats") / name for name in others}
    parsers |= {path.relative_to(ROOT) for path in (ROOT / "formats" / "readers").rglob("*.py")}
    used = {name for path, name in sources("formats") if path in parsers}
    used = {name for name in used if name.split(".")[0] in PACKAGES}
    assert {name for name in used if not name.startswith("formats.")} == {"flybench.errors"}


@pytest.mark.parametrize("package", ["flybench", "emulator", "detector", "formats", "scenarios"])
def test_a_package_loads_no_heavy_library_that_it_does_not_need(package: str) -> None:
    heavy = {"mujoco", "rerun", "pyarrow", "matplotlib", "tyro", "rich"}
    script = f"import sys, {package}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr


def test_no_folder_holds_more_than_fifteen_modules() -> None:
    folders = {path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    counts = {f: len([p for p in f.glob("*.py") if p.name != "__init__.py"]) for f in folders}
    assert {f: n for f, n in counts.items() if n > 15} == {}


def test_the_emulator_needs_only_the_libraries_that_every_installation_has() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    installed = {re.split(r"[<>=\[]", one)[0] for one in project["dependencies"]}
    assert installed == {"numba", "numpy"}
    used = {
        name.split(".")[0]
        for package in ("flybench", "emulator")
        for path, name in sources(package)
        if "characterisation" not in path.parts
    }
    assert used - sys.stdlib_module_names - set(PACKAGES) == installed
