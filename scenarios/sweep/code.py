"""The code that a result is of: another version, or an edited file, makes another result."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from functools import cache
from pathlib import Path

from flybench.sources import SWEEP_POINT, feed, sources_digest
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.summary import versions


@cache
def code_digest() -> str:
    """Digest of this process's versions, and of the sources that results depend on."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    digest.update(sources_digest(*SWEEP_POINT).encode())
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
        feed(digest, Path(spec.origin).name, Path(spec.origin).read_bytes())
    return digest.hexdigest()
