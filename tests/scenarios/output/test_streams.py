"""The standard streams of a command: closed, in other encodings, and shared with other code."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FLYBENCH = [sys.executable, "-m", "flybench"]
ROOT = Path(__file__).parents[3]
MIXED = """
import os, sys
from scenarios.output.streams import claim_output, own_output, prepare_streams, say
prepare_streams()
print("before")
claim_output()
claim_output()
say("own")
print("other")
os.system("echo child")
print("end", file=own_output(), flush=True)
"""


def run(command: list[str], *, encoding: str = "utf-8") -> subprocess.CompletedProcess[bytes]:
    environment = os.environ | {"PYTHONIOENCODING": encoding, "COLUMNS": "100"}
    return subprocess.run(command, capture_output=True, check=False, cwd=ROOT, env=environment)


def test_only_our_own_output_reaches_standard_output_once_it_is_claimed() -> None:
    done = run([sys.executable, "-c", MIXED])
    assert done.stdout == b"before\nown\nend\n"
    assert sorted(done.stderr.split()) == [b"child", b"other"]


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_characters_that_an_encoding_lacks_are_replaced(encoding: str) -> None:
    text = "→ 5 µs × 2 ≤ ω Δ façade − │ \\udcff 猫"
    script = f"from scenarios.output.streams import *; prepare_streams(); print('{text}')"
    done = run([sys.executable, "-c", script], encoding=encoding)
    assert done.returncode == 0, done.stderr
    if encoding == "ascii":
        assert done.stdout == b"> 5 us x 2 <= omega delta facade - | ? ?\n"
    assert done.stdout.decode(encoding).startswith("> 5 ")


@pytest.mark.parametrize(
    ("encoding", "arguments"), [("latin-1", "run --help"), ("ascii", "sweep --parameters")]
)
def test_help_and_tables_need_no_unicode(encoding: str, arguments: str) -> None:
    done = run([*FLYBENCH, *arguments.split()], encoding=encoding)
    assert done.returncode == 0, done.stderr
    assert done.stderr == b""
    assert len(done.stdout.decode(encoding).splitlines()) > 20


@pytest.mark.parametrize("arguments", ["run --help", "sweep --parameters"])
def test_a_closed_pipe_gives_no_traceback(arguments: str) -> None:
    """As `flybench run --help | head` does."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run(
            [*FLYBENCH, *arguments.split()],
            stdout=writer,
            stderr=subprocess.PIPE,
            check=False,
            cwd=ROOT,
        )
    finally:
        os.close(writer)
    assert done.returncode in (1, 2)
    for word in (b"Traceback", b"BrokenPipe", b"Exception"):
        assert word not in done.stderr


def test_closed_streams_are_no_error() -> None:
    program = " ".join(FLYBENCH)
    done = run(["sh", "-c", f"{program} sweep --parameters <&- >&- 2>&-; echo $?"])
    assert done.stdout == b"0\n"
