"""Where commands keep light: what the arguments and the environment ask for, and that it is so."""

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


def test_by_default_it_is_in_the_users_cache(monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_the_variable_comes_before_the_default_and_the_argument_before_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("FLYBENCH_CACHE", str(tmp_path / "named"))
    assert opened().folder == tmp_path / "named"
    assert opened(cache=tmp_path / "given").folder == tmp_path / "given"
    assert CacheOptions(no_cache=True).open() is None
    monkeypatch.setenv("FLYBENCH_CACHE", "off")
    assert CacheOptions().open() is None
    assert opened(cache=tmp_path / "given").folder == tmp_path / "given"


def test_without_a_home_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError

    for name in ("FLYBENCH_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    assert default_folder() is None
    assert CacheOptions().open() is None


@pytest.mark.parametrize("command", [Run, VelocitySweep])
def test_commands_take_the_arguments_without_a_prefix(
    command: type[Run | VelocitySweep], tmp_path: Path
) -> None:
    given = ["--cache", str(tmp_path), "--cache-gb", "0.5"]
    assert tyro.cli(command, args=given).light == CacheOptions(tmp_path, 0.5)
    assert tyro.cli(command, args=["--no-cache"]).light == CacheOptions(no_cache=True)


def test_a_folder_and_none_are_refused_together(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="--no-cache is given too; allowed is one of them"):
        CacheOptions(cache=tmp_path, no_cache=True).open()


@pytest.mark.parametrize("size", [-1.0, math.nan, math.inf])
def test_a_size_that_is_none_is_refused(tmp_path: Path, size: float) -> None:
    with pytest.raises(ScenarioError, match="--cache-gb is"):
        CacheOptions(cache=tmp_path, cache_gb=size).open()


def test_a_sweep_done_twice_renders_once_and_says_the_same(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    kept = CacheOptions(cache=tmp_path / "kept")

    def sweep(name: str) -> list[list[str]]:
        out = tmp_path / name
        assert VelocitySweep(omegas=(2.42,), light=kept, out=out, **COARSE).execute() == 0
        assert "light" not in json.loads((out / "summary.json").read_text())["parameters"]
        with (out / "velocities.csv").open(newline="") as file:
            return list(csv.reader(file))

    first = sweep("first")
    monkeypatch.setattr(crossing_module, "FilamentRenderer", NoRenderer)
    assert sweep("second") == first


def test_a_run_from_kept_light_has_the_same_events_and_says_that_it_is_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    light = CacheOptions(cache=tmp_path / "kept")

    def run(name: str) -> tuple[Any, str]:
        out = tmp_path / name
        assert Run(omega=2.42, light=light, out=out, **COARSE).execute() == 0
        said = json.loads((out / "summary.json").read_text())["light"]
        return read_events(out / "events.h5"), said

    first, said = run("first")
    assert said == "rendered"
    monkeypatch.setattr(crossing_module, "FilamentRenderer", NoRenderer)
    second, said = run("second")
    assert said == "kept"
    assert np.array_equal(first, second)
    assert "kept" in capsys.readouterr().out


def test_a_folder_that_cannot_be_made_is_a_sentence_and_the_run_goes_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    light = CacheOptions(cache=tmp_path / "file" / "kept")
    run = Run(omega=2.42, light=light, out=tmp_path / "out", **COARSE)
    assert execute(run) == 0
    (sentence,) = [line for line in capsys.readouterr().err.splitlines() if "stored in" in line]
    assert sentence.startswith("flybench: luminance cannot be stored in")
