"""Digests of the tables that commands write, without measured times."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import partial
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mujoco
import numpy as np

from emulator import SensorConfig
from emulator.characterisation import EXPERIMENTS, Datasheet
from formats import Chunk, read_events, write_events
from scenarios.commands.detect import Detect
from scenarios.commands.emulate import Emulate
from scenarios.commands.envelope import Envelope
from scenarios.commands.run import Run
from scenarios.commands.study import Study
from scenarios.commands.sweep import Sweep
from scenarios.commands.velocity_sweep import VelocitySweep
from scenarios.convergence.measure import COLUMNS, Rendering, measure_convergence
from scenarios.datasheet.json_export import datasheet_dict
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.event_camera import EventCamera
from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY, PLANE_FIT, WIDE
from sim import CrossingConfig, Lighting
from tests.digests.detectors import HEIGHT, WIDTH, stream
from tests.digests.exact import Case
from tests.digests.luminance import MODEL
from tests.digests.sensor import moving_box

NO_CACHE = CacheOptions(no_cache=True)
CLOCKS = ("cpu", "wall", "ms_per_estimate", "ns_per_event")
"""What the names of columns with times of a clock contain."""
PARAMETERS = ("crossing.", "sensor.", "fly.")
"""What the names of columns with parameters of a sweep begin with; they may be renamed."""
SWEEP = """
seeds = 2
[fixed]
crossing.omega_rad_s = 3.0
crossing.step_px = 8
crossing.supersample = 1
crossing.lead_s = 0.05
sensor.width = 96
sensor.height = 64
[grid]
method = ["fly", "plane-fit"]
sensor.theta_on = [0.18, 0.3]
"""


def is_result(column: str) -> bool:
    """Return True for a column of results, and not of parameters or measured times."""
    return not column.startswith(PARAMETERS) and not any(clock in column for clock in CLOCKS)


def table(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file, results only."""
    with path.open(newline="", encoding="utf-8") as file:
        return [{k: v for k, v in row.items() if is_result(k)} for row in csv.DictReader(file)]


def written(execute: Callable[[Path], int], *names: str) -> list[Any]:
    """Return the named tables and figures from the folder that a command writes."""
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        out = Path(folder) / "out"
        status = execute(out)
        if status != 0:
            raise RuntimeError(f"the command ended with status {status}")
        files = [out / name for name in names]
        return [table(f) if f.suffix == ".csv" else f.read_bytes() for f in files]


def numbers(value: Any) -> Iterator[float]:
    """Yield the numbers in nested lists and dictionaries, in order; text is ignored, because it may
    be rewritten."""
    if isinstance(value, dict | list | tuple):
        for part in value.values() if isinstance(value, dict) else value:
            yield from numbers(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value


def study() -> Any:
    """Table of a small study by day and night."""
    methods = (FLY, WIDE, FRAME_FLY, CONTRAST, PLANE_FIT)
    return written(
        lambda out: Study(
            lighting="both",
            omegas=(2.3,),
            methods=methods,
            seeds=1,
            recordings=False,
            step_px=8.0,
            supersample=1,
            jobs=1,
            out=out,
            cache=NO_CACHE,
        ).execute(),
        "results.csv",
    )


def sweep() -> Any:
    """The table of a small sweep."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "small.toml"
        file.write_text(SWEEP, encoding="utf-8")
        return written(
            lambda out: Sweep(file, out=out, jobs=2, cache=NO_CACHE).execute(), "results.csv"
        )


def run() -> Any:
    """Truth and estimates of a single run."""
    return written(
        lambda out: Run(
            omega=2.3, step_px=8, supersample=1, seed=7, out=out, cache=NO_CACHE
        ).execute(),
        "truth.csv",
        "estimates.csv",
    )


def velocity_sweep() -> Any:
    """The table of a small velocity sweep."""
    return written(
        lambda out: VelocitySweep(
            lighting="night",
            omegas=(2.3,),
            seeds=1,
            step_px=8.0,
            supersample=1,
            out=out,
            cache=NO_CACHE,
        ).execute(),
        "velocities.csv",
    )


def envelope() -> Any:
    """Table of a small envelope."""
    return written(
        lambda out: Envelope(
            method=(FLY, WIDE),
            speeds=(2000.0,),
            noises=(1.0,),
            seeds=1,
            jobs=2,
            out=out,
        ).execute(),
        "envelope.csv",
    )


def characterised(name: str) -> list[float]:
    """All figures and curves of an experiment."""
    config = SensorConfig()
    sheet = Datasheet(config, 4, {name: EXPERIMENTS[name](config, seed=4)})
    return list(numbers(datasheet_dict(sheet, changes={}, versions={})["sections"]))


def converged() -> Any:
    """Compare the events of two renderings with those of a third, by day and at night."""
    renderings = (
        Rendering("full", 2, 0.5),
        Rendering("full", 1, 0.5),
        Rendering("keyframes", 1, 0.5, 8.0),
    )
    clock = COLUMNS.index("cpu_ms_per_sample")
    return [
        [*row[:clock], *row[clock + 1 :]]
        for lighting in (Lighting.DAY, Lighting.NIGHT)
        for row in measure_convergence(CrossingConfig(lighting=lighting), 1.0, renderings)
    ]


def event_camera() -> Any:
    """Return the output of an event camera in a small model."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    data.qvel[:] = 2.0
    sensor = SensorConfig(width=96, height=64)
    with EventCamera(model, "eye", sensor=sensor, seed=4) as camera:
        found = []
        for _ in range(60):
            mujoco.mj_step(model, data)
            found.append(camera.step(data))
        return found, camera.samples, camera.luminance


def emulated() -> Any:
    """Return the events of grey pictures, with and without interpolated pictures."""
    levels = [np.clip(image, 0, 255) for _, image in moving_box(WIDTH, HEIGHT, steps=6)]
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        pictures, out = Path(folder) / "pictures.npy", Path(folder) / "events.npz"
        np.save(pictures, np.array(levels, np.uint8))
        found = []
        for between in (False, True):
            command = Emulate(pictures, out, fps=100.0, seed=3, interpolate=between)
            replace(command, overwrite=True).execute()
            found.append(read_events(out))
        return found


def detected() -> Any:
    """Numbers of the estimates and verdicts on a file."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "events.aedat4"
        chunks = [Chunk(output.events, output.aps_frames) for output in stream()]
        write_events(file, chunks, width=WIDTH, height=HEIGHT)
        found = []
        for command in (
            Detect(file, json=True),
            Detect(file, json=True, method=WIDE, scale_to_sensor=True, time_scale=2.0),
        ):
            with redirect_stdout(StringIO()) as printed, redirect_stderr(StringIO()):
                command.execute()
            found.append(list(numbers(json.loads(printed.getvalue()))))
        return found


CASES: dict[str, Case] = {
    "commands.study": Case(study, slow=True),
    "commands.sweep": Case(sweep),
    "commands.run": Case(run, slow=True),
    "commands.velocity_sweep": Case(velocity_sweep),
    "commands.envelope": Case(envelope, slow=True),
    "commands.converge": Case(converged, slow=True),
    "commands.emulate": Case(emulated),
    "commands.detect": Case(detected),
    "commands.event_camera": Case(event_camera),
} | {f"commands.characterise.{name}": Case(partial(characterised, name)) for name in EXPERIMENTS}
