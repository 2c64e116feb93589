"""The option that chooses a detector."""

import re
from typing import Any

import pytest
import tyro

from scenarios.commands.demo import Demo
from scenarios.commands.detect import Detect
from scenarios.commands.envelope import Envelope
from scenarios.commands.run import Run
from scenarios.commands.study import Study
from scenarios.commands.velocity_sweep import VelocitySweep
from scenarios.pipeline.registry import DETECTORS


@pytest.mark.parametrize("command", [Run, Demo, Detect, VelocitySweep, Envelope, Study])
def test_help_lists_every_detector(command: Any, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        tyro.cli(command, args=["--help"])
    text = re.sub(r"[\s│]+", " ", capsys.readouterr().out)
    for name in DETECTORS:
        assert f" {name}," in text
