"""TOML from users: files and values, read with limits so that any text gives one sentence."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from flybench.files import read_small_text
from scenarios.errors import ScenarioError

_INT_MIN, _INT_MAX = -(2**63), 2**63 - 1


def read_toml(path: Path, error: type[ScenarioError]) -> tuple[str, dict[str, Any]]:
    """Return the text of a TOML file, and its values.

    Args:
        path: path of the file.
        error: class to raise.

    Raises:
        ScenarioError: of class `error`, if the file cannot be read or is not TOML.
    """
    try:
        text = read_small_text(path)
    except UnicodeDecodeError:
        raise error(
            f"{path} is not a text file. Allowed is a TOML file in UTF-8. Choose another file."
        ) from None
    except OSError as cause:
        raise error(
            f"{path} cannot be read ({cause.strerror}). Allowed is a TOML file. Choose another "
            "file."
        ) from cause
    try:
        return text, parse_toml(text)
    except ValueError as cause:
        raise error(
            f"{path} is not valid TOML: {cause}. Allowed is the format that toml.io describes, "
            "with every key once. Correct this line."
        ) from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the values of a text in TOML.

    Raises:
        ValueError: the text is not TOML, is nested too deep, or contains an integer of more than 64
            bits, which TOML does not have.
    """
    try:
        values = tomllib.loads(text)
    except RecursionError:
        raise ValueError("arrays or tables are nested too deep") from None
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # Python converts no more than 4300 digits
        raise ValueError("an integer has more than 64 bits") from None
    remaining: list[Any] = [values]
    while remaining:
        value = remaining.pop()
        if isinstance(value, dict):
            remaining += value.values()
        elif isinstance(value, list):
            remaining += value
        elif isinstance(value, int) and not _INT_MIN <= value <= _INT_MAX:
            raise ValueError("an integer has more than 64 bits")
    return values
