"""Read a manifest: a TOML file that lists recordings with windows of known motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from detector.metrics import Box
from flybench.direction import Direction
from scenarios.options.toml_file import read_toml
from scenarios.validate.keys import (
    RECORDING_KEYS,
    RECORDINGS,
    WINDOW_KEYS,
    WINDOWS,
    ManifestError,
    check_keys,
)

PACKAGED = Path(__file__).with_name("recordings.toml")
"""The manifest of public recordings that comes with flybench."""


@dataclass(frozen=True)
class Window:
    """A window of a recording in which the motion is known.

    Attributes:
        direction: true direction of the image motion; `NONE` if nothing moves.
        from_us: start, after the first event of the recording [µs].
        to_us: end, exclusive [µs]; None: the end of the recording.
        crop: (x0, y0, x1, y1) of the part of the sensor to use, half-open [px]; None: all of it.
        conditions: what happens in it; may be empty.
    """

    direction: Direction
    from_us: int = 0
    to_us: int | None = None
    crop: Box | None = None
    conditions: str = ""


@dataclass(frozen=True)
class Recording:
    """A recording of a manifest.

    Attributes:
        name: short name, for tables.
        file: path of the file from the folder of the manifest; its name if there is a URL.
        sha256: SHA-256 of the file, 64 hexadecimal digits.
        licence: licence of the file.
        source: where it was published.
        windows: its windows.
        url: address to fetch it from; None: it is only at `file`.
        conditions: camera, light and motion; may be empty.
        size: sensor columns and rows; None: as the file states [px].
        format: format of the file; None: recognise it.
        time_unit: unit of its timestamps; None: as the file states.
        columns: order of its columns, as `formats.open_events` takes it; None: recognise it.
    """

    name: str
    file: str
    sha256: str
    licence: str
    source: str
    windows: tuple[Window, ...]
    url: str | None = None
    conditions: str = ""
    size: tuple[int, int] | None = None
    format: str | None = None
    time_unit: str | None = None
    columns: str | None = None


@dataclass(frozen=True)
class Manifest:
    """Contents of a manifest.

    Attributes:
        path: path of the file.
        recordings: the recordings that it lists.
    """

    path: Path
    recordings: tuple[Recording, ...]

    def select(self, names: Sequence[str]) -> Manifest:
        """Return the manifest with only the recordings of these names; all if there are none.

        Raises:
            ManifestError: the manifest has no recording of a name.
        """
        known = {recording.name: recording for recording in self.recordings}
        for name in names:
            if name not in known:
                raise ManifestError(
                    f"--recording is {name!r}. Allowed with {self.path} is {', '.join(known)}. "
                    "Choose one of them."
                )
        chosen = tuple(known[name] for name in dict.fromkeys(names))
        return replace(self, recordings=chosen or self.recordings)


def read_manifest(path: Path) -> Manifest:
    """Read a manifest.

    Raises:
        ManifestError: the file does not exist, is not TOML, or holds an unknown key or an invalid
            value. The message names the file, the key, the value and what to do.
    """
    _, tables = read_toml(path, ManifestError)
    try:
        return Manifest(path, _recordings(tables))
    except ManifestError as error:
        raise ManifestError(f"{path}: {error}") from None


def _recordings(tables: dict[str, Any]) -> tuple[Recording, ...]:
    for name, value in tables.items():
        if name != RECORDINGS:
            raise ManifestError(
                f"The key {name} = {value!r} is not a key of a manifest. Allowed at the top level "
                f"is {RECORDINGS}. Put it below [[{RECORDINGS}]] or remove it."
            )
    entries = _tables("the file", tables, RECORDINGS, RECORDINGS)
    recordings = tuple(_recording(number, entry) for number, entry in enumerate(entries, start=1))
    names = [recording.name for recording in recordings]
    for name in names:
        if names.count(name) > 1:
            raise ManifestError(
                f"{names.count(name)} recordings have name = {name!r}. Allowed is each name once. "
                "Rename one of them."
            )
    return recordings


def _recording(number: int, entry: dict[str, Any]) -> Recording:
    place = f"{RECORDINGS} {number}"
    if isinstance(entry.get("name"), str):
        place += f" ({entry['name']})"
    windows = _tables(place, entry, WINDOWS, f"{RECORDINGS}.{WINDOWS}")
    values = {name: value for name, value in entry.items() if name != WINDOWS}
    check_keys(place, values, RECORDING_KEYS)
    if "url" in values and Path(values["file"]).name != values["file"]:
        raise ManifestError(
            f"{place}: file is {values['file']!r} and there is a url. Allowed is then a name "
            f"without folders. Write file = {Path(values['file']).name!r}."
        )
    if "size" in values:
        values["size"] = tuple(values["size"])
    parsed = tuple(_window(f"{place}, window {n}", w) for n, w in enumerate(windows, start=1))
    return Recording(windows=parsed, **values)


def _tables(place: str, table: dict[str, Any], name: str, header: str) -> list[dict[str, Any]]:
    """Return the tables of a list, of which there has to be at least one."""
    value = table.get(name, [])
    if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        return value
    found = f"has {name} = {value!r}" if name in table else f"has no {name}"
    raise ManifestError(
        f"{place} {found}. Allowed is one table or more. Write [[{header}]] above each."
    )


def _window(place: str, entry: dict[str, Any]) -> Window:
    check_keys(place, entry, WINDOW_KEYS)
    from_us = round(entry.get("from_s", 0.0) * 1e6)
    to_us = round(entry["to_s"] * 1e6) if "to_s" in entry else None
    if to_us is not None and to_us <= from_us:
        raise ManifestError(
            f"{place}: to_s is {entry['to_s']!r} and from_s is {entry.get('from_s', 0.0)!r}. "
            "Allowed is an end after the start. Correct one of them."
        )
    return Window(
        direction=Direction(entry["direction"]),
        from_us=from_us,
        to_us=to_us,
        crop=tuple(entry["crop"]) if "crop" in entry else None,
        conditions=entry.get("conditions", ""),
    )
