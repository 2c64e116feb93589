"""Manifests: what they hold, and one clear message for everything that is wrong."""

import os
import re
from pathlib import Path
from typing import Any

import pytest

from flybench import files
from flybench.direction import Direction
from scenarios.validate.keys import RECORDING_KEYS, WINDOW_KEYS, ManifestError
from scenarios.validate.manifest import PACKAGED, Window, read_manifest
from tests.scenarios.validate.made_recordings import entry, write_manifest

SHA = "0" * 64
DOCUMENTATION = Path(__file__).parents[3] / "docs" / "explanation" / "real-recordings.md"


def test_a_manifest_holds_recordings_and_windows(tmp_path: Path) -> None:
    window = {"from_s": 0.06, "to_s": 0.21, "direction": "left", "crop": [1, 2, 30, 40]}
    path = write_manifest(
        tmp_path / "m.toml",
        (
            entry("a", "data/a.npz", SHA, size=[346, 260], time_unit="1/30s", columns="t-xyp"),
            [window],
        ),
        (entry("b", "b.raw", SHA, url="https://example.org/b"), [{"direction": "none"}]),
    )
    manifest = read_manifest(path)
    first, second = manifest.recordings
    assert first.windows == (Window(Direction.LEFT, 60_000, 210_000, (1, 2, 30, 40)),)
    assert (first.size, first.url) == ((346, 260), None)
    assert (first.time_unit, first.columns) == ("1/30s", "t-xyp")
    assert second.windows == (Window(Direction.NONE),)
    assert [r.name for r in manifest.select(["b"]).recordings] == ["b"]
    assert manifest.select([]) == manifest
    with pytest.raises(ManifestError, match=r"--recording is 'c'\. Allowed with .* is a, b"):
        manifest.select(["c"])


RIGHT = {"direction": "right"}
TIMES = {**RIGHT, "from_s": 0.2}


@pytest.mark.parametrize(
    ("keys", "windows", "words"),
    [
        ({"name": "a b"}, [RIGHT], "recording 1 (a b): name is 'a b'. Allowed is letters"),
        ({"name": 3}, [RIGHT], "recording 1: name is 3. Allowed is letters, digits"),
        ({"file": "folder/"}, [RIGHT], "(a): file is 'folder/'. Allowed is the name or path"),
        ({"sha256": "97ea"}, [RIGHT], "(a): sha256 is '97ea'. Allowed is the 64 digits"),
        ({"sha256": SHA[1:] + "G"}, [RIGHT], "Allowed is the 64 digits that `sha256sum"),
        ({"url": "ftp.org/a"}, [RIGHT], "url is 'ftp.org/a'. Allowed is an address that begins"),
        ({"file": "x/a.npz", "url": "https://b.org"}, [RIGHT], "Write file = 'a.npz'"),
        ({"licence": ""}, [RIGHT], "licence is ''. Allowed is the name of the licence"),
        ({"license": "MIT"}, [RIGHT], "has the key license = 'MIT'. .* Did you mean licence?"),
        ({"size": [346]}, [RIGHT], "size is [346]. Allowed is width and height"),
        ({"format": "avi"}, [RIGHT], "format is 'avi'. Allowed is one of "),
        ({"time_unit": "min"}, [RIGHT], "time_unit is 'min'. Allowed is one of s, ms, us, ns"),
        ({"time_unit": 33}, [RIGHT], "time_unit is 33. Allowed is one of s, ms, us, ns"),
        ({"columns": "txy"}, [RIGHT], "columns is 'txy'. Allowed is the letters t, x, y and p"),
        ({"window": 3}, [], "(a) has window = 3. Allowed is one table or more"),
        ({}, [], "(a) has no window. Allowed is one table or more. Write [[recording.window]]"),
        ({}, [{}], "(a), window 1 has no direction. Every one needs it: one of right"),
        ({}, [RIGHT, {"direction": "north"}], "window 2: direction is 'north'. Allowed is"),
        ({}, [{**RIGHT, "form_s": 1}], "the key form_s = 1. .* Did you mean from_s?"),
        ({}, [{**RIGHT, "zzz": 1}], "the key zzz = 1. .* Remove it."),
        ({}, [{**RIGHT, "from_s": -0.1}], "from_s is -0.1. Allowed is a time after"),
        ({}, [{**RIGHT, "to_s": "1"}], "to_s is '1'. Allowed is a time after"),
        ({}, [{**RIGHT, "to_s": True}], "to_s is True. Allowed is a time after"),
        ({}, [{**TIMES, "to_s": 0.2}], "to_s is 0.2 and from_s is 0.2. Allowed is an end after"),
        ({}, [{**RIGHT, "crop": [9, 0, 9, 5]}], "crop is [9, 0, 9, 5]. Allowed is [x0, y0"),
        ({}, [{**RIGHT, "crop": [0.5, 0, 9, 5]}], "crop is [0.5, 0, 9, 5]. Allowed is [x0, y0"),
    ],
)
def test_a_wrong_value_is_named_with_its_key_and_remedy(
    tmp_path: Path, keys: dict[str, Any], windows: list[Any], words: str
) -> None:
    path = write_manifest(tmp_path / "m.toml", (entry("a", "a.npz", SHA) | keys, windows))
    with pytest.raises(ManifestError) as caught:
        read_manifest(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    assert re.search(re.escape(words).replace(r"\.\*", ".*").replace(r"\ ", " "), message), message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file has no recording. Allowed is one table or more. Write [[recording]]"),
        ("recording = 3", "the file has recording = 3"),
        ("title = 'x'", "The key title = 'x' is not a key of a manifest"),
        ("[[recording]\n", "is not valid TOML"),
        ("\xff", "is not a text file"),
    ],
)
def test_a_file_that_is_no_manifest_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "m.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ManifestError, match=re.escape(words)):
        read_manifest(path)


def test_missing_files_missing_keys_and_equal_names_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ManifestError, match=r"none\.toml cannot be read \(No such file"):
        read_manifest(tmp_path / "none.toml")
    for key in ("name", "file", "sha256", "licence", "source"):
        keys = {k: v for k, v in entry("a", "a.npz", SHA).items() if k != key}
        path = write_manifest(tmp_path / "m.toml", (keys, [RIGHT]))
        with pytest.raises(ManifestError, match=rf"has no {key}\. Every one needs it: .* Add, for"):
            read_manifest(path)
    one = (entry("a", "a.npz", SHA), [RIGHT])
    with pytest.raises(ManifestError, match="2 recordings have name = 'a'"):
        read_manifest(write_manifest(tmp_path / "m.toml", one, one))


def test_the_example_of_the_documentation_is_valid(tmp_path: Path) -> None:
    text = DOCUMENTATION.read_text(encoding="utf-8")
    path = tmp_path / "m.toml"
    path.write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    (recording,) = read_manifest(path).recordings
    assert recording.windows[0].direction is Direction.RIGHT
    for key in [*RECORDING_KEYS, *WINDOW_KEYS]:
        assert f"`{key}`" in text


def test_the_manifest_of_the_project_is_valid_and_complete() -> None:
    manifest = read_manifest(PACKAGED)
    assert {r.name: len(r.windows) for r in manifest.recordings} == {
        "cradle": 2,
        "lab": 1,
        "pipe": 4,
    }
    for recording in manifest.recordings:
        assert recording.conditions
        assert recording.url
    directions = {w.direction for r in manifest.recordings for w in r.windows}
    assert directions == set(Direction)


@pytest.mark.parametrize(
    ("text", "words"),
    [("a = " + "[" * 3000, "nested too deep"), ("a = " + "1" * 5000, "more than 64 bits")],
)
def test_a_hostile_file_gives_one_sentence(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "m.toml").write_text(text)
    with pytest.raises(ManifestError, match=words):
        read_manifest(tmp_path / "m.toml")


def test_a_fifo_does_not_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "_WAIT_S", 0.05)
    os.mkfifo(tmp_path / "m.toml")
    with pytest.raises(ManifestError, match="it sends no data for"):
        read_manifest(tmp_path / "m.toml")
