"""Help texts of the commands."""

import ast
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import scenarios

SCENARIOS = Path(str(scenarios.__file__)).parent
SOURCES = [*SCENARIOS.glob("commands/**/*.py"), *SCENARIOS.glob("options/*.py")]


def field_texts() -> Iterator[tuple[str, str]]:
    """Name and help text of every option that has its text below it."""
    for source in SOURCES:
        for node in ast.parse(source.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                for field, text in pairwise(node.body):
                    if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
                        name = f"{source.stem}.{ast.unparse(field.target)}"
                        yield name, ast.literal_eval(text.value)


def test_a_help_text_is_one_line_of_source_because_the_parser_keeps_line_breaks() -> None:
    texts = dict(field_texts())
    assert len(texts) > 50
    assert [name for name, text in texts.items() if "\n" in text] == []
    assert [name for name, text in texts.items() if not text.endswith((".", "]."))] == []
