# Every target sets itself up: on a fresh machine `make run` and `make test` are enough.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
ARGS ?=
BENCH = .venv-bench

SEED := $(or $(SEED),$(shell date +%s))
CASES ?= 100000
HOUSES ?= 100

.PHONY: run test fuzz houses check format bench lock test-lowest clean

run: $(VENV)/.run
	@$(BIN)/python -m homebot run $(ARGS)

test: $(VENV)/.dev
	$(BIN)/python -m pytest -n 3 --dist worksteal --cov --cov-report=term $(ARGS)

# Generated cases for all that strangers say, 100,000 for each of 14 targets; `make fuzz SEED=...` repeats a run.
fuzz: $(VENV)/.dev
	@echo "seed $(SEED), $(CASES) cases for each target"
	@FUZZ_SEED=$(SEED) FUZZ_CASES=$(CASES) $(BIN)/python -m pytest -n 2 --timeout 7200 --show-capture no tests/fuzz tests/mqtt/broker/test_fuzz_seeded.py $(ARGS)

# Days of the family home, a hundred of them; `make houses HOUSES=1000` takes more.
houses: $(VENV)/.dev
	@HOUSES=$(HOUSES) $(BIN)/python -m pytest -n auto --timeout 600 --show-capture no tests/testing/test_family_day.py $(ARGS)

check: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(BENCH)/.ready $(BENCH)-ha/.tried
	@$(BENCH)/bin/python benchmarks/run.py --home-assistant $(BENCH)-ha/bin/python $(ARGS)

# Moves the versions that CI installs forward to the newest.
lock:
	rm -rf .venv-lock && $(PYTHON) -m venv .venv-lock
	.venv-lock/bin/pip install --quiet --disable-pip-version-check -e ".[dev,all]"
	.venv-lock/bin/pip freeze --exclude-editable > constraints.txt
	rm -rf .venv-lock

# Tests the lower bounds of pyproject.toml.
test-lowest:
	$(PYTHON) -m venv .venv-lowest
	.venv-lowest/bin/pip install --quiet --disable-pip-version-check -c constraints-lowest.txt -e ".[dev,all]"
	.venv-lowest/bin/python -m pytest -n 3 -p no:cacheprovider $(ARGS)

clean:
	rm -rf $(VENV) .venv-lowest .venv-lock $(BENCH) $(BENCH)-ha .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml constraints.txt | $(VENV)/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev,all]"
	@touch $@ $(VENV)/.run

# Nothing but what users install, so that start-up and memory are theirs.
$(BENCH)/.ready: pyproject.toml constraints.txt
	@$(PYTHON) -m venv $(BENCH)
	@$(BENCH)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

# A peer, in a venv of its own because it pins its packages: the newest that this Python can install. Takes minutes, once.
$(BENCH)-ha/.tried:
	@echo "installing Home Assistant into $(BENCH)-ha, to compare with; this takes some minutes, once"
	@$(PYTHON) -m venv $(BENCH)-ha
	@$(BENCH)-ha/bin/python -m pip install --quiet --disable-pip-version-check homeassistant \
		&& $(BENCH)-ha/bin/python benchmarks/home_assistant_requirements.py > $(BENCH)-ha/mqtt.txt \
		&& $(BENCH)-ha/bin/python -m pip install --quiet --disable-pip-version-check -r $(BENCH)-ha/mqtt.txt \
		|| { echo "Home Assistant cannot be installed here: the benchmarks go without it"; rm -rf $(BENCH)-ha/bin; }
	@touch $@
