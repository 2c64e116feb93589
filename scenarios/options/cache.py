"""Options of the cache of rendered luminance, so that a sequence is rendered only once."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from scenarios.errors import ScenarioError
from scenarios.output.streams import complain
from sim import LuminanceCache
from sim.cache.luminance_cache import LIMIT_BYTES

VARIABLE = "FLYBENCH_CACHE"
OFF = "off"


@dataclass(frozen=True)
class CacheOptions:
    """Cache of rendered luminance. A sequence that is in the cache is not rendered again."""

    cache: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="DIR",
            help_behavior_hint=f"(default: ${VARIABLE}, or flybench in the user's cache folder)",
        ),
    ] = None
    """Folder of the cache. Set the environment variable FLYBENCH_CACHE to off to disable it."""
    cache_gb: float = LIMIT_BYTES / 1e9
    """Size limit of the cache [GB], 0 or more; the least recently used entries are removed."""
    no_cache: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Render everything and store nothing in the cache."""

    def open(self) -> LuminanceCache | None:
        """Return the cache that the options describe; None if it is turned off.

        Raises:
            ScenarioError: both a folder and `no_cache` are given, or the limit is negative or not
                finite.
        """
        if self.no_cache and self.cache is not None:
            raise ScenarioError(
                f"--cache is {self.cache} and --no-cache is given too. Allowed is one of them. "
                "Leave the other out."
            )
        if not 0 <= self.cache_gb < math.inf:
            raise ScenarioError(
                f"--cache-gb is {self.cache_gb:g}. Allowed is 0 GB or more. To store nothing, give "
                "--no-cache."
            )
        folder = None if self.no_cache else self.cache or default_folder()
        if folder is None:
            return None
        return LuminanceCache(folder.absolute(), limit_bytes=round(self.cache_gb * 1e9), warn=_warn)


def default_folder() -> Path | None:
    """Return the cache folder that the environment sets; None if it is "off" or there is no home.

    The folder is that of `VARIABLE`, or `flybench` in the user's cache folder.
    """
    named = os.environ.get(VARIABLE)
    if named == OFF:
        return None
    if named:
        return Path(named)
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if base.is_absolute():  # the XDG base directory specification ignores relative paths
        return base / "flybench"
    try:
        return Path.home() / ".cache" / "flybench"
    except RuntimeError:
        return None


def _warn(message: str) -> None:
    complain(message)
