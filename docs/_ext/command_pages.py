"""One page for each command of flybench, from the parser that the command itself uses."""

import argparse
import re
import warnings
from collections.abc import Iterator
from typing import Any

import tyro

from scenarios.cli import COMMANDS, command_class
from scenarios.output.terminal import arguments_of

DETAILS = {
    "detect": "detect",
    "convert": "convert",
    "compare": "compare",
    "emulate": "emulate",
    "sweep": "sweep",
    "denoise": "filters",
    "view": "viewer",
    "run": "outputs",
}
"""Page of the reference that says more about a command."""
TITLES = {"positional arguments": "Arguments", "options": "Options"}


def command_pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    commands = {name: _parser(name) for name in COMMANDS}
    pages = {f"commands/{name}.md": _page(name, parser) for name, parser in commands.items()}
    rows = [f"| [`flybench {n}`]({n}.md) | {_text(p.description)} |" for n, p in commands.items()]
    table = "\n".join(["| command | what it does |", "| --- | --- |", *rows])
    toctree = "\n".join(["```{toctree}", ":hidden:", "", *commands, "```"])
    intro = (
        "These pages are generated from the parser of the command, as is `flybench COMMAND --help`."
    )
    pages["commands/index.md"] = f"# Commands\n\n{intro}\n\n{table}\n\n{toctree}\n"
    return pages


def _parser(name: str) -> argparse.ArgumentParser:
    command = command_class(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return tyro.extras.get_parser(
            arguments_of(command),
            prog=f"flybench {name}",
            description=command.__doc__,
            config=(tyro.conf.CascadeSubcommandArgs,),
        )


def _page(name: str, parser: argparse.ArgumentParser) -> str:
    parts = [
        f"# flybench {name}",
        _text(parser.description),
        f"```{{program}} flybench {name}\n```",
    ]
    parts += [f"```text\n{' '.join(['flybench', name, '[OPTIONS]', *_positional(parser)])}\n```"]
    if name in DETAILS:
        parts.append(f"More about it: [](../../{DETAILS[name]}.md).")
    for group in parser._action_groups:
        actions = [a for a in group._group_actions if "--help" not in a.option_strings]
        if actions:
            title = group.title or "Options"
            parts.append(f"## {TITLES.get(title, title[0].upper() + title[1:])}")
            parts += [_text(group.description)] if group.description else []
            parts += [_option(action) for action in actions]
    return "\n\n".join(parts) + "\n"


def _positional(parser: argparse.ArgumentParser) -> Iterator[str]:
    for action in parser._actions:
        if not action.option_strings and action.metavar:
            yield str(action.metavar)


def _option(action: argparse.Action) -> str:
    """Return one option with its value, text and default."""
    value: Any = "" if action.nargs == 0 else action.metavar or ""
    value = " ".join(value) if isinstance(value, tuple) else str(value)
    names = ", ".join(f"{flag} {value}".strip() for flag in action.option_strings) or value
    text, _, hint = (action.help or "").rpartition(" (")
    if not hint.startswith(("default", "required", "optional", "repeatable")):
        text, hint = action.help or "", ""
    hint = hint.removesuffix(")")
    body = _text(text) + (f"\n\n*{_text(hint[0].upper() + hint[1:])}*" if hint else "")
    return f"````{{option}} {names}\n{body}\n````"


def _text(help_text: str | None) -> str:
    """Return a help text as Markdown."""
    text = re.sub(r"\s+", " ", (help_text or "").replace("%%", "%")).strip()
    text = re.sub(r"(?<![`\w-])--[a-z][\w.-]*\w", r"`\g<0>`", text)
    parts = text.split("`")  # the odd parts are code
    parts[::2] = [re.sub(r"([\\*<>$\[\]|_])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)
