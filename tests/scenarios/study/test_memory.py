import ctypes

import pytest

from scenarios.study.memory import give_back


def test_it_asks_the_c_library_and_bears_one_that_cannot(monkeypatch: pytest.MonkeyPatch) -> None:
    give_back()
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    give_back()
