"""Find the order of columns by their values."""

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from flybench.events import Events
from formats import FormatError, read_events
from formats.column_order import ORDERS_IN_USE, check_order, column_order
from formats.columns import EventColumns, ReadOptions
from formats.readers import reader_of
from tests.formats.sample_files import SIZE, random_events

PATH = Path("a.npy")
E = random_events(5000)
SHORT = random_events(5000, last_us=20_000)
"""Whole times below every limit of a coordinate."""

FORMAT = {"h5": "hdf5", "npy": "npy", "npz": "npz"}
ALL_ORDERS = (*ORDERS_IN_USE, "ptxy", "xpyt", "tpxy")


def table(events: Events, order: str, *, time_unit_us: float = 1) -> Any:
    columns = {name: events[name].astype(float) for name in "txyp"}
    columns["t"] /= time_unit_us
    return np.stack([columns[name] for name in order], axis=1)


def found(rows: Any, **options: Any) -> str:
    return column_order(rows, options.pop("option", None), options.pop("size", None), path=PATH)[0]


@pytest.mark.parametrize("order", ALL_ORDERS)
@pytest.mark.parametrize("events", [E, SHORT], ids=["long", "short"])
def test_an_order_is_found_by_the_values(events: Events, order: str) -> None:
    for rows in (table(events, order), table(events, order, time_unit_us=1e6)):
        assert found(rows) == order
        signed = rows.copy()
        signed[:, order.index("p")] = rows[:, order.index("p")] * 2 - 1
        assert found(signed) == order


def test_a_few_damaged_rows_do_not_hide_the_order() -> None:
    rows = table(SHORT, "xytp")
    rows[100, 2] += 5000
    rows[200, 3] = 7
    rows[300, 0] = 1.5
    assert found(rows) == "xytp"


def test_the_size_of_the_sensor_shows_that_y_comes_first() -> None:
    assert found(table(E, "tyxp"), size=SIZE) == "tyxp"
    assert found(table(E, "txyp"), size=SIZE) == "txyp"
    assert found(table(E, "txyp"), size=(128, 128)) == "txyp"  # too small in either order


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (np.array([[1, 2, 3, 1], [2, 3, 4, 0]]), "Possible are t x y p and x y t p. State"),
        (np.zeros((1000, 4)), "do not show the order.*--columns txyp"),
        (table(E, "txyp") * 1.5, "no order .* fits"),
        (table(E, "txyp")[::-1], "no order .* fits"),
    ],
)
def test_values_that_do_not_decide_are_refused(rows: Any, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        found(rows)


def test_rows_of_one_frame_after_another_are_not_taken_for_times() -> None:
    k, y, x = (index.ravel() for index in np.indices((5, 9, 9)))
    frames = np.stack([k, x, y, (x + y) % 2], axis=1)
    assert found(frames) == "txyp"
    with pytest.raises(FormatError, match="Possible are t x y p and x y t p"):
        found(frames[:81])  # the time does not change, and y does not fall


@pytest.mark.parametrize("order", ["txy", "txypp", "txyq", "", "t x y z"])
def test_a_wrong_order_is_refused(order: str) -> None:
    with pytest.raises(FormatError, match="Correct --columns"):
        check_order(order)


def test_an_order_may_have_separators_and_skip_columns() -> None:
    assert check_order("T, x, -, y; p") == "tx-yp"
    assert found(np.zeros((1, 6)), option="xy-tp") == "xy-tp-"
    with pytest.raises(FormatError, match="has 4 columns"):
        found(np.zeros((1, 4)), option="xy-tp")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")  # the parser closes at its end
@pytest.mark.parametrize("order", ORDERS_IN_USE)
@pytest.mark.parametrize("ending", ["txt", "csv", "npy", "npz", "h5"])
def test_every_kind_of_table_is_read(tmp_path: Path, order: str, ending: str) -> None:
    path, rows = tmp_path / f"a.{ending}", table(SHORT, order)
    if ending == "h5":
        with h5py.File(path, "w") as file:
            file["events"] = rows.astype(np.uint32)  # as v2e writes it
    elif ending == "npy":
        np.save(path, rows)
    elif ending == "npz":
        np.savez(path, rows)
    elif ending == "txt":
        np.savetxt(path, rows)  # with 18 decimals
    else:
        np.savetxt(path, rows, fmt="%d", delimiter=",")
    header, items = reader_of(FORMAT.get(ending, "text"))(path, ReadOptions(SIZE))
    shown = header.facts["columns"]
    got = [item for item in items if isinstance(item, EventColumns)]
    for name in "txyp":
        assert np.array_equal(np.concatenate([getattr(c, name) for c in got]), SHORT[name])
    assert re.fullmatch(rf"{' '.join(order)}, found in the values of [2-5],\d+ rows", shown)


@pytest.mark.parametrize("ending", ["txt", "npy"])
def test_a_stated_order_is_taken(tmp_path: Path, ending: str) -> None:
    path, rows = tmp_path / f"a.{ending}", table(SHORT, "txyp")
    np.save(path, rows) if ending == "npy" else np.savetxt(path, rows)
    got = read_events(path, size=(346, 346), columns="t,y,x,p")
    assert np.array_equal(got["x"], SHORT["y"])
    assert np.array_equal(read_events(path, size=SIZE), SHORT)


@pytest.mark.parametrize("words", [("False", "True"), ("false", "true"), ("FALSE", "TRUE")])
def test_true_and_false_are_polarities(tmp_path: Path, words: tuple[str, str]) -> None:
    lines = [f"{t} {x} {y} {words[p]}\n" for t, x, y, p in E[:200].tolist()]
    (tmp_path / "a.txt").write_text("".join(lines))
    assert np.array_equal(read_events(tmp_path / "a.txt", size=SIZE), E[:200])
    (tmp_path / "b.txt").write_text("t x y p\n" + "".join(lines))
    assert np.array_equal(read_events(tmp_path / "b.txt", size=SIZE), E[:200])


def test_an_order_is_refused_where_the_columns_have_names(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", E)
    columns: Any = {name: E[name] for name in "txyp"}
    np.savez(tmp_path / "a.npz", **columns)
    for name in ("a.npy", "a.npz"):
        with pytest.raises(FormatError, match="names its columns"):
            read_events(tmp_path / name, columns="txyp")
    (tmp_path / "a.txt").write_text("x,y,t,p\n5001,2,3,1\n")  # a header may be wrong
    assert read_events(tmp_path / "a.txt", columns="txyp")["t"].tolist() == [5001]
