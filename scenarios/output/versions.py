"""Versions of the libraries that a result depends on."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import version

_LIBRARIES = (
    "flybench",
    "mujoco",
    "numpy",
    "numba",
    "opencv-python-headless",
    "h5py",
    "rerun-sdk",
)


def versions(libraries: Sequence[str] = _LIBRARIES) -> dict[str, str]:
    """Return the versions of Python and of the libraries, by name.

    Args:
        libraries: names of installed packages; by default those that a run uses.

    Raises:
        importlib.metadata.PackageNotFoundError: a package is not installed.
    """
    return {"python": platform.python_version()} | {name: version(name) for name in libraries}
