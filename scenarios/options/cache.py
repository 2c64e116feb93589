"""Where commands keep rendered light, so that the same sequence is drawn once."""

from __future__ import annotations

import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from scenarios.errors import ScenarioError
from sim import LuminanceCache
from sim.cache.luminance_cache import LIMIT_BYTES

VARIABLE = "FLYBENCH_CACHE"
OFF = "off"


@dataclass(frozen=True)
class CacheOptions:
    """Where rendered light is kept; another run of the same sequence then renders nothing."""

    cache: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder; where not given $FLYBENCH_CACHE ("off" for none), or flybench in the user's cache."""
    cache_gb: float = LIMIT_BYTES / 1e9
    """How much may be kept [GB]; what was used longest ago goes first."""
    no_cache: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Render anew, and keep nothing."""

    def open(self) -> LuminanceCache | None:
        """The cache that the arguments ask for; None for none.

        Raises:
            ScenarioError: a folder is given together with none, or the size is not 0 or more.
        """
        if self.no_cache and self.cache is not None:
            raise ScenarioError(
                f"--cache is {self.cache} and --no-cache is given too; allowed is one of them; "
                "leave the other out"
            )
        if not 0 <= self.cache_gb < math.inf:
            raise ScenarioError(
                f"--cache-gb is {self.cache_gb:g}; allowed is 0 GB or more; to keep nothing, give "
                "--no-cache"
            )
        folder = None if self.no_cache else self.cache or default_folder()
        if folder is None:
            return None
        return LuminanceCache(folder.absolute(), limit_bytes=round(self.cache_gb * 1e9), warn=_warn)


def default_folder() -> Path | None:
    """The folder that the environment names; None where it says "off", or there is no home."""
    named = os.environ.get(VARIABLE)
    if named == OFF:
        return None
    if named:
        return Path(named)
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if base.is_absolute():  # as the XDG base directory specification asks
        return base / "flybench"
    try:
        return Path.home() / ".cache" / "flybench"
    except RuntimeError:
        return None


def _warn(sentence: str) -> None:
    print(f"flybench: {sentence}", file=sys.stderr)
