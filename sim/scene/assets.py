"""The asset folder: MJCF files, textures and meshes."""

from __future__ import annotations

from pathlib import Path

import mujoco

from flybench.errors import first_line
from sim.errors import SceneConfigError

ASSETS = Path(__file__).parents[1] / "assets"
"""Folder of all assets."""


def open_asset(name: str) -> mujoco.MjSpec:
    """Open an MJCF file from `ASSETS` with its textures and meshes.

    Raises:
        SceneConfigError: the file, or a file that it names, is missing or damaged.
    """
    path = ASSETS / name
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, FileNotFoundError) as error:
        raise SceneConfigError(
            f"Cannot open {path}: {first_line(error)}. Allowed is a valid MJCF file. "
            "Install flybench again, or repair the file."
        ) from error
    for item in (*spec.textures, *spec.meshes):
        if item.file and not (ASSETS / item.file).is_file():
            raise SceneConfigError(
                f"{name} names {item.file}, which is missing from {ASSETS}. Allowed are files in "
                "that folder. Install flybench again, or run `python -m tools.make_textures`."
            )
    return spec
