"""Key of a finished point: a digest of everything that determines its result."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from functools import cache
from pathlib import Path

from flybench.sources import SWEEP_POINT_SOURCES, add_file, sources_digest
from scenarios.output.versions import versions
from scenarios.pipeline.run_config import RunConfig


@cache
def code_digest() -> str:
    """Return a digest of this process's versions and of the sources that determine a result."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    digest.update(sources_digest(*SWEEP_POINT_SOURCES).encode())
    return digest.hexdigest()


def point_key(config: RunConfig) -> str:
    """Return a digest of everything that determines a point's result, except the machine.

    It covers the file of a user's detector class, but not what that file imports.
    """
    inputs = {"parameters": config.parameters(), "code": code_digest()}
    inputs["method"] = method_digest(config.method)
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


@cache
def method_digest(method: str) -> str:
    """Return a digest of the file of a user's detector; empty for a built-in one."""
    module, colon, _ = method.rpartition("+")[2].partition(":")  # without filters before it
    if not colon:
        return ""
    spec = importlib.util.find_spec(module)
    digest = hashlib.sha256()
    if spec is not None and spec.origin is not None and Path(spec.origin).is_file():
        add_file(digest, Path(spec.origin).name, Path(spec.origin).read_bytes())
    return digest.hexdigest()
