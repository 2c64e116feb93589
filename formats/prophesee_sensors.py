"""The size of a Prophesee sensor, from a file's header without its width and height.

Plug-ins and system numbers are those of Prophesee's OpenEB (openeb,
hal_psee_plugins/include/devices/utils/device_system_id.h and
hal_psee_plugins/src/boards/rawfile/psee_raw_file_header.cpp; plug-ins by name: Metavision 2,
raw_constants.h). Files from before `_FIRST_640_YEAR` are of an ATIS if their events fit on it,
such as those of N-CARS (Sironi et al., HATS, CVPR 2018).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from formats.columns import Size

ATIS: Size = (304, 240)
GEN3: Size = (640, 480)
GEN4: Size = (1280, 720)
GENX320: Size = (320, 320)

_FIRST_640_YEAR = 2018
"""First year of recordings of 640x480 px (assumed: the year after Prophesee announced Gen3)."""

_BY_NAME: dict[str, Size] = {
    r"gen_?x_?320": GENX320,
    r"gen_?4|imx_?(636|637|646|647)": GEN4,
    r"gen_?3": GEN3,
    r"atis": ATIS,
}
"""Sizes by a part of the name of a plug-in or sensor, such as hal_plugin_gen31_fx3 [px]."""

_MAKERS = ("integrator_name", "camera_integrator_name", "plugin_integrator_name")
"""Who built the camera: the system numbers are Prophesee's own."""

_BY_GENERATION: dict[str, Size] = {"3": GEN3, "4": GEN4, "320": GENX320}

_BY_SYSTEM: dict[Size, tuple[int, ...]] = {
    GEN3: (21, 23, 25, 28, 29, 33, 34, 35, 40, 41, 151, 153, 161, 162),
    GEN4: (26, 30, 31, 32, 39, 46, 48, 49, 50, 52, 53, 54, 58, 65, 66, 154),
    GENX320: (59, 64),
}
"""Numbers of camera systems by the size of their sensor [px]."""


def stated_size(facts: Mapping[str, str]) -> tuple[Size, str] | None:
    """Return the size that a header states or implies, and what says so; None if unknown.

    Args:
        facts: values of the header by keyword in lower case.
    """
    form = dict(part.split("=", 1) for part in facts.get("format", "").split(";") if "=" in part)
    width, _, height = facts.get("geometry", "").partition("x")
    pairs = ((form.get("width"), form.get("height")), (width, height))
    for columns, rows in (*pairs, (facts.get("width"), facts.get("height"))):
        if columns and rows and columns.strip().isdigit() and rows.strip().isdigit():
            return (int(columns), int(rows)), "the file"
    for key in ("plugin_name", "sensor_name"):
        for pattern, size in _BY_NAME.items():
            if re.search(pattern, facts.get(key, ""), re.IGNORECASE):
                return size, f"the file's {key} {facts[key]}"
    generation = facts.get("sensor_generation", "").partition(".")[0]
    if generation in _BY_GENERATION:
        return _BY_GENERATION[generation], f"the file's sensor_generation {generation}"
    makers = {facts[key].strip().lower() for key in _MAKERS if facts.get(key)}
    system = facts.get("system_id", "") if makers <= {"prophesee"} else ""
    for size, numbers in _BY_SYSTEM.items():
        if system.isdigit() and int(system) in numbers:
            return size, f"the file's system_ID {system}"
    return None


def possible_sizes(facts: Mapping[str, str]) -> tuple[Size, ...]:
    """Return the sizes of the sensors that existed at a file's date, smallest first; empty: any.

    Args:
        facts: values of the header by keyword in lower case.
    """
    year = re.match(r"(\d{4})", facts.get("date", ""))
    return (ATIS, GEN3) if year is not None and int(year[1]) < _FIRST_640_YEAR else ()
