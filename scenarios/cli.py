"""The command `flybench` and its sub-commands."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable
from dataclasses import make_dataclass
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any

from rich.table import Table
from rich.text import Text
from tyro.conf import subcommand

from flybench.version import __version__
from scenarios.output.streams import SafeConsole, prepare_streams, say
from scenarios.output.terminal import run_cli

DESCRIPTION = f"Test bench for event-camera motion detectors, version {__version__}."

COMMANDS = {
    "run": "run:Run",
    "demo": "demo:Demo",
    "detect": "detect:Detect",
    "validate": "validate:Validate",
    "compare": "compare:Compare",
    "convert": "convert:Convert",
    "emulate": "emulate:Emulate",
    "study": "study:Study",
    "sweep": "sweep:Sweep",
    "dataset": "data.dataset:Dataset",
    "denoise": "data.denoise:Denoise",
    "velocity-sweep": "velocity_sweep:VelocitySweep",
    "envelope": "envelope:Envelope",
    "calibrate": "sensor.calibrate:Calibrate",
    "characterise": "characterise:Characterise",
    "converge": "converge:Converge",
    "view": "view:View",
    "video": "viewing.video:Video",
    "doctor": "doctor:Doctor",
}
"""Module and class of each command in `scenarios.commands`. Only that of the chosen command is
imported, because all of them together take 3 s of CPU."""

GROUPS = {
    "Simulate crossings": "run demo study sweep velocity-sweep dataset",
    "Use recordings and videos": "detect validate compare convert emulate",
    "Measure detectors and sensors": "envelope denoise characterise calibrate converge",
    "Look": "view video doctor",
}
"""All commands, by what they are for, as the help lists them."""

_FOLDER = Path(__file__).parent / "commands"


def main() -> None:
    """Run `flybench`."""
    first = sys.argv[1] if len(sys.argv) > 1 else "--help"
    if first in ("-h", "--help"):
        print_help()
        return
    if first in COMMANDS:
        run_cli(command_class(first), prog=f"flybench {first}", arguments=sys.argv[2:])
    run_cli(
        _union(command_class if first.startswith("-") else _outline),  # options may come first
        prog="flybench",
        description=DESCRIPTION,
    )


def print_help() -> None:
    """Print all commands with their descriptions."""
    prepare_streams()
    console = SafeConsole()
    console.print("usage: flybench COMMAND [OPTIONS]\n", DESCRIPTION, sep="\n", markup=False)
    for title, names in GROUPS.items():
        table = Table(title=title, title_justify="left", title_style="bold", box=None)
        table.show_header = False
        table.add_column(width=max(map(len, COMMANDS)))
        for name in names.split():
            table.add_row(name, _outline(name).__doc__)
        console.print(Text(), table)
    say("\nMore: flybench COMMAND --help. The version: flybench --version.")


def command_class(name: str) -> Any:
    """Return the class of a command, such as `scenarios.commands.run.Run` of "run"."""
    module, _, kind = COMMANDS[name].partition(":")
    return getattr(importlib.import_module(f"scenarios.commands.{module}"), kind)


def _union(make: Callable[[str], Any]) -> Any:
    """Return the type that stands for one of all commands."""
    return reduce(or_, (Annotated[make(name), subcommand(name)] for name in COMMANDS))


def _outline(name: str) -> Any:
    """Return a class with the description of a command, without the libraries that it needs."""
    module, _, kind = COMMANDS[name].partition(":")
    source = _FOLDER.joinpath(*module.split(".")).with_suffix(".py")
    classes = {
        node.name: node
        for node in ast.parse(source.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef)
    }
    text = ast.get_docstring(classes[kind])
    return make_dataclass(kind, [], namespace={"__doc__": text})


if __name__ == "__main__":
    main()
