"""The source files that determine a result, as one digest: the key of every cache."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
"""The folder that holds all packages of flybench."""
PACKAGES = ("sim", "emulator", "detector", "formats", "scenarios")
"""Our packages, besides flybench itself."""

LUMINANCE_SOURCES = ("flybench", "sim")
"""Sources that determine rendered luminance."""
SWEEP_POINT_SOURCES = (
    "flybench",
    "sim",
    "emulator",
    "detector",
    "scenarios/options",
    "scenarios/pipeline",
    "scenarios/sweep/measure.py",
)
"""Sources that determine the result of one point of a sweep; reports and figures do not."""


@cache
def sources_digest(*parts: str) -> str:
    """Return the SHA-256 digest of the names and contents of source files.

    The digest is computed once per process, because a file that is edited later no longer matches
    the running code.

    Args:
        parts: packages, folders or files, as paths relative to `ROOT`. A folder stands for its
            Python files and its `assets`, at any depth.

    Returns:
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for path in sorted({path for part in parts for path in _files(ROOT / part)}):
        name = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
        add_file(digest, name.as_posix(), path.read_bytes())
    return digest.hexdigest()


def add_file(digest: hashlib._Hash, name: str, content: bytes) -> None:
    """Add a named file to a digest, so that no two lists of files give the same bytes."""
    digest.update(f"{name} {len(content)} ".encode() + content)


def _files(path: Path) -> Iterator[Path]:
    if path.is_file():
        yield path
        return
    for found in path.rglob("*"):
        is_source = found.suffix == ".py" or "assets" in found.parts
        if is_source and found.is_file() and "__pycache__" not in found.parts:
            yield found
