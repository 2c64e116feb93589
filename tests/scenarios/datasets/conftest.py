"""A rendered dataset that the tests of this folder share."""

from functools import partial
from pathlib import Path

import pytest

from scenarios.dataset.plan import read_plan
from scenarios.dataset.run import run_dataset
from scenarios.pipeline.parallel import run_locally
from tests.scenarios.dataset.tiny import write_spec


@pytest.fixture(scope="session")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a tiny dataset."""
    path = tmp_path_factory.mktemp("streets")
    plan = read_plan(write_spec(path / "streets.toml"))
    run_dataset(plan, path / "streets", partial(run_locally, jobs=1))
    return path / "streets"
