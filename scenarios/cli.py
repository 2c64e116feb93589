"""The command `flybench`: its sub-commands, typed from dataclasses."""

from __future__ import annotations

from typing import Annotated

from tyro.conf import subcommand

from scenarios.characterise import Characterise
from scenarios.converge import Converge
from scenarios.demo import Demo
from scenarios.doctor import Doctor
from scenarios.envelope.command import Envelope
from scenarios.run import Run
from scenarios.terminal import script
from scenarios.velocity_sweep import VelocitySweep
from scenarios.view import View

Commands = (
    Annotated[Run, subcommand("run")]
    | Annotated[Demo, subcommand("demo")]
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
