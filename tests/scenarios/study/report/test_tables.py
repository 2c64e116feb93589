import re

from scenarios.pipeline.registry import CONTRAST, FLY
from scenarios.study.report.tables import NONE, number, table_by_light, table_by_sequence
from scenarios.study.rows import study_rows
from tests.scenarios.study.hand_made import a_run, a_sequence


def cells(table: str, row: int) -> list[str]:
    line = re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)[1 + row]
    return [
        re.sub(r"<[^>]+>", " ", cell).strip() for cell in re.findall(r"<t[hd].*?</t[hd]>", line)
    ]


def test_numbers_as_people_read_them() -> None:
    assert number(0.0) == "0"
    assert number(-1.2345) == "−1.23"
    assert number(793456.0) == "793\u202f456"
    assert number(0.00041) == "0.00041"


def test_a_row_a_light_and_method_with_mean_and_interval() -> None:
    rows = study_rows([a_sequence("day"), a_sequence("day", 1.61), a_sequence("night")])
    table = table_by_light(rows)
    assert table.count("<tr>") == 1 + 2 * 3
    fly, contrast = cells(table, 0), cells(table, 2)
    assert fly[:3] == ["event-driven fly  day", "6 of 6", "100  100 to 100"]
    assert NONE in fly
    assert "4  1.52 to 6.48" in contrast
    assert table_by_sequence(rows).count("<tr>") == 1 + 3 * 3


def test_what_a_part_of_the_runs_lacks_is_counted() -> None:
    rows = study_rows([a_sequence(runs=(a_run(FLY, 0), a_run(FLY, 1, hs=-0.5)))])
    (latency,) = [cell for cell in cells(table_by_light(rows), 0) if cell.endswith("1 of 2")][1:]
    assert latency.startswith("50 ")
    assert "velocity" not in table_by_light(rows)
    assert CONTRAST not in table_by_light(rows)
