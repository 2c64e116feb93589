# `make study` runs the study, `make test` runs all tests. Both install flybench first if needed.
VENV ?= .venv
PYTHON ?= python3
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: study demo test lint bench docs setup clean

study: setup
	$(BIN)/flybench study

# One sequence by day and one by night, for a first look.
demo: setup
	$(BIN)/flybench demo

# One process per core, at most four: each may need a renderer and 1 GB of memory. A process that
# crashes ends the tests, which would otherwise wait for it for ever.
test: setup
	$(BIN)/python -m pytest --numprocesses logical --maxprocesses 4 --dist loadfile \
	    --no-loadscope-reorder --max-worker-restart 0

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# One core and a fixed number of threads, so that runs are comparable. Values are CPU times where stated.
bench: setup
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,peers]'
	OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(BIN)/python -m pytest tests/benchmarks \
	    --benchmark-only --benchmark-disable-gc --benchmark-columns=min,median,iqr,rounds

# The documentation site, in docs/_build/html. A warning, such as a broken link, fails the build.
docs: setup
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,docs]'
	$(BIN)/python -m sphinx -W --keep-going --quiet -j 2 -b html docs docs/_build/html
	@echo "Open docs/_build/html/index.html."

setup: $(READY)

$(READY): pyproject.toml constraints.txt .ci/setup
	PYTHON="$(PYTHON)" VENV="$(VENV)" .ci/setup
	touch $@
	@echo "flybench is ready in $(VENV)."

clean:
	rm -rf $(VENV) build docs/_build docs/auto_gallery *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
