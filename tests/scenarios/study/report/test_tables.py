from scenarios.pipeline.registry import FLY
from scenarios.study.report.tables import (
    NO_VALUE,
    Cell,
    Table,
    table_by_lighting,
    table_by_sequence,
)
from scenarios.study.rows import study_rows
from tests.scenarios.study.synthetic_results import make_run, make_sequence


def cell_of(table: Table, row: int, heading: str) -> Cell:
    return table.rows[row].cells[table.headings.index(heading) - 1]


def test_a_row_for_each_lighting_and_method_with_mean_and_interval() -> None:
    rows = study_rows([make_sequence("day"), make_sequence("day", 1.61), make_sequence("night")])
    table = table_by_lighting(rows)
    assert len(table.rows) == 2 * 3
    assert (table.rows[0].method, table.rows[0].condition) == ("event-driven fly", "day")
    assert cell_of(table, 0, "correct verdicts") == Cell("6 of 6")
    assert cell_of(table, 0, "correct steps after 100 ms [%]") == Cell("100", "100 to 100")
    assert cell_of(table, 0, "velocity error, RMS [px/s]") == Cell(NO_VALUE)
    assert cell_of(table, 2, "velocity error, RMS [px/s]") == Cell("4", "1.52 to 6.48")
    by_sequence = table_by_sequence(rows)
    assert [row.condition for row in by_sequence.rows[::3]] == [
        "day 1.21 rad/s",
        "day 1.61 rad/s",
        "night 1.21 rad/s",
    ]


def test_runs_with_a_value_are_counted_if_some_have_none() -> None:
    rows = study_rows([make_sequence(runs=(make_run(FLY, 0), make_run(FLY, 1, hs=-0.5)))])
    table = table_by_lighting(rows)
    assert cell_of(table, 0, "onset latency [ms]") == Cell("50", "", "1 of 2")
    assert [heading for heading in table.headings if "velocity" in heading] == []
    assert [row.method for row in table.rows] == ["event-driven fly"]
