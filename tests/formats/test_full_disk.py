"""A full disk while a recording is written: one error, and nothing half-written."""

import subprocess
import sys
from pathlib import Path

import pytest

from formats import ENDINGS

LIMIT = 400_000
"""More than one frame, and less than each of the files [bytes]."""
WRITE = f"""
import resource, signal, sys
from pathlib import Path
import numpy as np
from emulator import ApsFrame
from formats import FormatError, open_writer
from tests.formats.sample_files import random_events, random_frames

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, ({LIMIT}, {LIMIT}))
frames = sys.argv[2] == "frames"
try:
    with open_writer(Path(sys.argv[1]), width=346, height=260) as writer:
        for n in range(200):
            events = random_events(3000)
            events["t"] += n * 100_000
            writer.write(events)
            if frames:
                start_us, image = n * 100_000, random_frames(1)[0].image
                writer.write_frame(ApsFrame(start_us, start_us + 9, image))
except FormatError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("ending", "content"),
    [*((ending, "events") for ending in sorted(ENDINGS)), (".aedat4", "frames")],
)
def test_a_full_disk_is_one_error(tmp_path: Path, ending: str, content: str) -> None:
    path = tmp_path / f"a{ending}"
    path.write_text("old")
    command = [sys.executable, "-c", WRITE, str(path), content]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"The disk of {path} is full. ")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
