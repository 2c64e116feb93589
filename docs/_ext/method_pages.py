"""Pages of the detectors in the registry and of the sensors by name."""

import inspect
import sys
from typing import Any, get_args

from configuration_pages import as_cell, differences, shown

from emulator import preset
from emulator.presets import WITHOUT_FRAMES, PresetName
from scenarios.pipeline.registry import DETECTORS, DetectorEntry


def method_pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    return {"methods.md": _methods(), "sensors.md": _sensors()}


def _methods() -> str:
    rows = [
        "| `--method` | name | kind | reads | class | study |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    rows += [_method(entry) for entry in DETECTORS.values()]
    intro = (
        "The names that `--method`, `--methods` and `--also` accept, from the registry "
        "([scenarios/pipeline/registry.py](../../../scenarios/pipeline/registry.py)). A filter of "
        "noise can stand before any of them, as in `stcf+fly`. Your own class is "
        "`package.module:Class`."
    )
    parts = ["# Methods", intro, "\n".join(rows)]
    for entry in DETECTORS.values():
        base = type(entry.config)()
        changed = list(differences(entry.config, base))
        if changed:
            parts.append(f"## {entry.name}\n\n{_table(changed, entry.name, type(base).__name__)}")
    return "\n\n".join([*parts, _sources()]) + "\n"


def _sources() -> str:
    """Return where each class comes from, as the docstring of its module states it."""
    rows = []
    for factory in dict.fromkeys(entry.factory for entry in DETECTORS.values()):
        text = inspect.cleandoc(sys.modules[factory.__module__].__doc__ or "")
        rows.append(f"- {{py:class}}`~detector.{factory.__name__}`: {as_cell(text)}")
    return "\n".join(["## Sources", "", *rows])


def _method(entry: DetectorEntry) -> str:
    reads = "events and frames" if entry.looks_at_frames else "events"
    study = {None: "all seeds"}.get(entry.study_sensors, f"{entry.study_sensors} seed")
    cells = (
        f"`{entry.name}`",
        entry.label,
        entry.family.value,
        reads,
        f"{{py:class}}`~detector.{entry.factory.__name__}`",
        study if entry.in_study else "no",
    )
    return f"| {' | '.join(cells)} |"


def _sensors() -> str:
    intro = (
        "The names that `--sensor` and `emulator.preset` accept. Each table lists what differs "
        "from the default, `davis346`. [emulator/presets.py](../../../emulator/presets.py) gives "
        "the source of each value, or says that it is assumed: above all, the pixels of the newer "
        "chips are those of the DAVIS346 where no source gives their parameters.\n\n"
        "All real chips have a 6 mm lens at f/1.4 (assumed), so that a run with another preset has "
        "the field of view of that sensor. The emulator also returns frames for chips without an "
        "APS; ignore them."
    )
    parts = ["# Sensors", intro]
    base = preset("davis346")
    for name in get_args(PresetName):
        config = preset(name)
        size = f"{config.width}×{config.height} px of {config.pixel_pitch_um:g} µm"
        frames = "without APS frames" if name in WITHOUT_FRAMES else "with APS frames"
        changed = list(differences(config, base))
        table = _table(changed, name, "davis346") if changed else "This is the default."
        parts.append(f"## {name}\n\n{size}, {frames}.\n\n{table}")
    return "\n\n".join(parts) + "\n"


def _table(changed: list[tuple[str, Any, Any]], name: str, base: str) -> str:
    rows = [f"| parameter | `{name}` | `{base}` |", "| --- | --- | --- |"]
    rows += [f"| `{key}` | {as_cell(shown(a))} | {as_cell(shown(b))} |" for key, a, b in changed]
    return "\n".join(rows)
