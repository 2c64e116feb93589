"""The command `flybench`: its sub-commands, typed from dataclasses."""

from __future__ import annotations

from typing import Annotated

from tyro.conf import subcommand

from scenarios.characterise import Characterise
from scenarios.converge import Converge
from scenarios.demo import Demo
from scenarios.detect.command import Detect
from scenarios.doctor import Doctor
from scenarios.emulate.command import Emulate
from scenarios.envelope.command import Envelope
from scenarios.run import Run
from scenarios.study.command import Study
from scenarios.sweep.command import Sweep
from scenarios.terminal import script
from scenarios.velocity_sweep import VelocitySweep
from scenarios.view import View

Commands = (
    Annotated[Run, subcommand("run")]
    | Annotated[Demo, subcommand("demo")]
    | Annotated[Detect, subcommand("detect")]
    | Annotated[Emulate, subcommand("emulate")]
    | Annotated[Study, subcommand("study")]
    | Annotated[Sweep, subcommand("sweep")]
    | Annotated[VelocitySweep, subcommand("velocity-sweep")]
    | Annotated[Envelope, subcommand("envelope")]
    | Annotated[Characterise, subcommand("characterise")]
    | Annotated[Converge, subcommand("converge")]
    | Annotated[View, subcommand("view")]
    | Annotated[Doctor, subcommand("doctor")]
)


def main() -> None:
    """Entry point of `flybench`."""
    script(Commands)


if __name__ == "__main__":
    main()
