import os
import subprocess
import sys
from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.options.toml_file import parse_toml, read_toml

HOSTILE = {
    "nested arrays": ("a = " + "[" * 3000 + "]" * 3000, "nested too deep"),
    "nested tables": ("a = " + "{a=" * 3000 + "1" + "}" * 3000, "nested too deep"),
    "decimal digits": ("a = " + "9" * 5000, "more than 64 bits"),
    "hexadecimal digits": ("a = [{b = 0x" + "f" * 5000 + "}]", "more than 64 bits"),
    "one bit too many": (f"a = {2**63}", "more than 64 bits"),
}


@pytest.mark.parametrize(("text", "reason"), HOSTILE.values(), ids=HOSTILE)
def test_hostile_text_gives_one_sentence(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(ScenarioError, match=reason):
        read_toml(path, ScenarioError)
    with pytest.raises(ScenarioError, match="has a value that cannot be read"):
        SensorOptions(set=("theta_on=" + text.removeprefix("a = "),)).config()


def test_integers_of_64_bits_are_read() -> None:
    assert parse_toml(f"a = [{2**63 - 1}, {-(2**63)}]") == {"a": [2**63 - 1, -(2**63)]}


def test_a_device_and_a_large_file_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ScenarioError, match="it is not a file or a pipe"):
        read_toml(Path("/dev/zero"), ScenarioError)
    monkeypatch.setattr("flybench.files.TEXT_MAX_BYTES", 10)
    path = tmp_path / "a.toml"
    path.write_text("a = 12345678")
    with pytest.raises(ScenarioError, match="it has more than 10 bytes"):
        read_toml(path, ScenarioError)


def test_a_fifo_without_writer_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flybench.files._WAIT_S", 0.1)
    os.mkfifo(tmp_path / "a.toml")
    with pytest.raises(ScenarioError, match="it sends no data for"):
        read_toml(tmp_path / "a.toml", ScenarioError)


def test_a_pipe_is_read() -> None:
    script = (
        "from pathlib import Path; from scenarios.errors import ScenarioError; "
        "from scenarios.options.toml_file import read_toml; "
        "print(read_toml(Path('/dev/stdin'), ScenarioError)[1])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], input="a = 1\r\n", capture_output=True, text=True
    )
    assert done.stdout == "{'a': 1}\n", done.stderr
