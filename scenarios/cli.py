"""The command `flybench` and its sub-commands."""

from __future__ import annotations

from typing import Annotated

from tyro.conf import subcommand

from flybench.version import __version__
from scenarios.commands.characterise import Characterise
from scenarios.commands.compare import Compare
from scenarios.commands.converge import Converge
from scenarios.commands.convert import Convert
from scenarios.commands.data.dataset import Dataset
from scenarios.commands.data.denoise import Denoise
from scenarios.commands.demo import Demo
from scenarios.commands.detect import Detect
from scenarios.commands.doctor import Doctor
from scenarios.commands.emulate import Emulate
from scenarios.commands.envelope import Envelope
from scenarios.commands.run import Run
from scenarios.commands.sensor.calibrate import Calibrate
from scenarios.commands.study import Study
from scenarios.commands.sweep import Sweep
from scenarios.commands.validate import Validate
from scenarios.commands.velocity_sweep import VelocitySweep
from scenarios.commands.view import View
from scenarios.commands.viewing.video import Video
from scenarios.output.terminal import run_cli

DESCRIPTION = f"""\
Test bench for event-camera motion detectors, version {__version__}.

flybench COMMAND --help explains a command. flybench --version prints the version."""

Commands = (
    Annotated[Run, subcommand("run")]
    | Annotated[Demo, subcommand("demo")]
    | Annotated[Detect, subcommand("detect")]
    | Annotated[Validate, subcommand("validate")]
    | Annotated[Compare, subcommand("compare")]
    | Annotated[Convert, subcommand("convert")]
    | Annotated[Emulate, subcommand("emulate")]
    | Annotated[Study, subcommand("study")]
    | Annotated[Sweep, subcommand("sweep")]
    | Annotated[Dataset, subcommand("dataset")]
    | Annotated[Denoise, subcommand("denoise")]
    | Annotated[VelocitySweep, subcommand("velocity-sweep")]
    | Annotated[Envelope, subcommand("envelope")]
    | Annotated[Calibrate, subcommand("calibrate")]
    | Annotated[Characterise, subcommand("characterise")]
    | Annotated[Converge, subcommand("converge")]
    | Annotated[View, subcommand("view")]
    | Annotated[Video, subcommand("video")]
    | Annotated[Doctor, subcommand("doctor")]
)


def main() -> None:
    """Run `flybench`."""
    run_cli(Commands, prog="flybench", description=DESCRIPTION)


if __name__ == "__main__":
    main()
