"""The code that a result is of: another version, or an edited file, makes another result."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from functools import cache
from pathlib import Path

from scenarios.config import RunConfig
from scenarios.summary import versions

_ROOT = Path(__file__).parents[2]
_FILES = ("sim/**/*.py", "sim/assets/**/*", "emulator/**/*.py", "detector/**/*.py")
MEASURING = ("config", "judgement", "methods", "pipeline", "repeats", "summary", "sweep.measure")
"""Of scenarios, what a result depends on; it depends on no other command, figure or report."""


@cache
def code_digest() -> str:
    """Digest of this process's versions, and of the files of flybench that results depend on."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    paths = {path for pattern in _FILES for path in _ROOT.glob(pattern) if path.is_file()}
    paths |= {_ROOT / "scenarios" / f"{name.replace('.', '/')}.py" for name in MEASURING}
    for path in sorted(paths):
        _feed(digest, path)
    return digest.hexdigest()


def point_key(config: RunConfig) -> str:
    """Digest of all that a point's result depends on, but for the machine it is computed on.

    Of a detector of one's own, the file that holds its class is among it; what that file imports
    is not.
    """
    said = {"parameters": config.parameters(), "code": code_digest()}
    said["method"] = _method_digest(config.method)
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()


@cache
def _method_digest(method: str) -> str:
    module, colon, _ = method.partition(":")
    if not colon:
        return ""
    spec = importlib.util.find_spec(module)
    digest = hashlib.sha256()
    if spec is not None and spec.origin is not None and Path(spec.origin).is_file():
        _feed(digest, Path(spec.origin))
    return digest.hexdigest()


def _feed(digest: hashlib._Hash, path: Path) -> None:
    content = path.read_bytes()
    digest.update(f"{path.name} {len(content)} ".encode() + content)
