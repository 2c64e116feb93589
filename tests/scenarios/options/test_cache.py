"""The cache options: folder and limit from arguments and environment, and use by commands."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tyro

from formats import read_events
from scenarios.commands.run import Run
from scenarios.commands.velocity_sweep import VelocitySweep
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions, default_folder
from scenarios.output.terminal import execute
from sim import LuminanceCache
from sim import crossing as crossing_module
from sim.cache.luminance_cache import LIMIT_BYTES

COARSE: dict[str, Any] = {"step_px": 8.0, "supersample": 1}


class NoRenderer:
    def __init__(self, *_: Any) -> None:
        raise AssertionError("rendered")


def opened(**options: Any) -> LuminanceCache:
    cache = CacheOptions(**options).open()
    assert cache is not None
    return cache


def test_the_default_folder_is_in_the_users_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FLYBENCH_CACHE")
    monkeypatch.setenv("HOME", "/home/fly")
    for base, folder in (
        ("/tmp/kept", "/tmp/kept/flybench"),
        ("relative", "/home/fly/.cache/flybench"),
        ("", "/home/fly/.cache/flybench"),
    ):
        monkeypatch.setenv("XDG_CACHE_HOME", base)
        assert opened().folder == Path(folder)
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert opened().folder == Path("/home/fly/.cache/flybench")
    assert opened().limit_bytes == LIMIT_BYTES == 4_000_000_000


def test_the_argument_overrides_the_variable_and_that_the_default(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("FLYBENCH_CACHE", str(tmp_path / "named"))
    assert opened().folder == tmp_path / "named"
    assert opened(cache=tmp_path / "given").folder == tmp_path / "given"
    assert CacheOptions(no_cache=True).open() is None
    monkeypatch.setenv("FLYBENCH_CACHE", "off")
    assert CacheOptions().open() is None
    assert opened(cache=tmp_path / "given").folder == tmp_path / "given"


def test_without_a_home_folder_there_is_no_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_home() -> Path:
        raise RuntimeError

    for name in ("FLYBENCH_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    assert default_folder() is None
    assert CacheOptions().open() is None


@pytest.mark.parametrize("command", [Run, VelocitySweep])
def test_commands_take_the_options_without_a_prefix(
    command: type[Run | VelocitySweep], tmp_path: Path
) -> None:
    given = ["--cache", str(tmp_path), "--cache-gb", "0.5"]
    assert tyro.cli(command, args=given).cache == CacheOptions(tmp_path, 0.5)
    assert tyro.cli(command, args=["--no-cache"]).cache == CacheOptions(no_cache=True)


def test_cache_and_no_cache_together_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="--no-cache is given too"):
        CacheOptions(cache=tmp_path, no_cache=True).open()


@pytest.mark.parametrize("limit_gb", [-1.0, math.nan, math.inf])
def test_an_invalid_limit_is_refused(tmp_path: Path, limit_gb: float) -> None:
    with pytest.raises(ScenarioError, match="--cache-gb is"):
        CacheOptions(cache=tmp_path, cache_gb=limit_gb).open()


def test_a_repeated_sweep_renders_once_and_gives_the_same_table(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    cache = CacheOptions(cache=tmp_path / "cache")

    def sweep(name: str) -> list[list[str]]:
        out = tmp_path / name
        assert VelocitySweep(omegas=(4.0,), cache=cache, out=out, **COARSE).execute() == 0
        assert "cache" not in json.loads((out / "summary.json").read_text())["parameters"]
        with (out / "velocities.csv").open(newline="") as file:
            return list(csv.reader(file))

    first = sweep("first")
    monkeypatch.setattr(crossing_module, "FilamentRenderer", NoRenderer)
    assert sweep("second") == first


def test_a_run_from_the_cache_has_the_same_events_and_reports_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    cache = CacheOptions(cache=tmp_path / "cache")

    def run(name: str, *, recording: bool) -> tuple[Any, str]:
        out = tmp_path / name
        command = Run(omega=4.0, cache=cache, recording=recording, out=out, **COARSE)
        assert command.execute() == 0
        source = json.loads((out / "summary.json").read_text())["luminance"]
        return read_events(out / "events.h5"), source

    first, source = run("first", recording=False)
    assert source == "rendered"
    monkeypatch.setattr(crossing_module, "FilamentRenderer", NoRenderer)
    second, source = run("second", recording=True)
    assert source == "from the cache"
    assert np.array_equal(first, second)
    assert "from the cache" in capsys.readouterr().out


def test_a_cache_folder_that_cannot_be_created_is_a_warning(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    cache = CacheOptions(cache=tmp_path / "file" / "cache")
    run = Run(omega=4.0, cache=cache, recording=False, out=tmp_path / "out", **COARSE)
    assert execute(run) == 0
    folder = str(tmp_path / "file")
    (warning,) = [line for line in capsys.readouterr().err.splitlines() if folder in line]
    assert warning.startswith("flybench: ")
