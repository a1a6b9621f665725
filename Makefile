# Every target sets itself up: on a fresh machine `make run` and `make test` are enough.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
ARGS ?=
BENCH = .venv-bench
PAGE = .venv-page
AUDIT = .venv-audit
PYRIGHT = .venv-pyright

SEED := $(or $(SEED),$(shell date +%s))
CASES ?= 100000
HOUSES ?= 100
DAYS ?= 1000

.PHONY: help run test coverage test-fast test-peers page fuzz houses days nightly check pyright format docs wheel release bench lock audit test-lowest test-newest clean

## Prints this list.
help:
	@awk '/^## / { what = substr($$0, 4) } /^[a-z-]+:/ && what { sub(":.*", ""); printf "  make %-12s %s\n", $$0, what; what = "" }' Makefile
	@echo "ARGS=\"…\" is passed on to the program of a target: make test ARGS=\"tests/graph -k topic\""

## Runs homebot with a simulated house, until Ctrl-C.
run: $(VENV)/.run
	@$(BIN)/python -m homebot run $(ARGS)

# With PYTHONDONTWRITEBYTECODE set, each worker would compile all of homebot: a third of the time.
# Three workers for each core: many tests wait for a program or a network.
## Runs all tests: about twelve minutes on two cores.
test: $(VENV)/.dev
	env -u PYTHONDONTWRITEBYTECODE $(BIN)/python -m pytest -n 6 --dist worksteal -m "not peers" $(ARGS)

# To measure which lines run takes more than twice the time of the tests.
## Runs all tests and shows the lines that none of them reaches.
coverage:
	@$(MAKE) test ARGS="--cov --cov-report=term $(ARGS)"

## Runs the quick tests (no other programs, no load, no generated cases): four minutes of one processor.
test-fast: $(VENV)/.dev
	env -u PYTHONDONTWRITEBYTECODE $(BIN)/python -m pytest -n logical --dist worksteal -m "not slow and not system and not peers" $(ARGS)

# Each test has a network of its own, which needs root; .ci/run installs the programs.
## Runs the gateways against other people's programs, those that are installed.
test-peers: $(VENV)/.peers
	env -u PYTHONDONTWRITEBYTECODE $(BIN)/python -m pytest -n 4 --dist loadfile -m peers tests/peers $(wildcard tests/integrations/*/peers tests/features/*/peers) $(ARGS)

# The result is committed: who installs homebot needs no Node.
## Builds the web page from src/homebot/web/source and the folders page of features, with npm.
page:
	@mkdir -p $(PAGE) && find $(PAGE) -mindepth 1 -maxdepth 1 ! -name node_modules -exec rm -r {} +
	@cp -r src/homebot/web/source/. $(PAGE)
	@cd $(PAGE) && npm install --silent --no-audit --no-fund --no-package-lock
	@rm -f src/homebot/web/page/*.js
	@cd $(PAGE) && FEATURES=$(CURDIR)/src/homebot/features npm run --silent build -- --outdir=$(CURDIR)/src/homebot/web/page

# 100,000 cases for each target; `make fuzz SEED=...` repeats a run.
## Runs generated cases against everything that handles untrusted input: about an hour.
fuzz: $(VENV)/.dev
	@echo "seed $(SEED), $(CASES) cases for each target"
	@FUZZ_SEED=$(SEED) FUZZ_CASES=$(CASES) $(BIN)/python -m pytest -n 2 --timeout 7200 --show-capture no tests/fuzz $(wildcard tests/integrations/*/fuzz) tests/mqtt/broker/test_fuzz_seeded.py $(ARGS)

# Days of the family home; `make houses HOUSES=1000` runs more.
## Simulates a hundred random days of a house.
houses: $(VENV)/.dev
	@HOUSES=$(HOUSES) $(BIN)/python -m pytest -n logical --show-capture no tests/testing/test_family_day.py $(ARGS)

# Random houses, faults, apps and policies; `make days DAYS=100 ARGS="--seed 7"` lives others.
## Lives a thousand random days, and counts offs over people, violated policies and broken chains.
days: $(VENV)/.dev
	@$(BIN)/python -m tests.days.table --days $(DAYS) $(ARGS)

# NIGHTLY: floods, kills and generated cases in full number, and other ones in each run; see tests/sizes.py.
## Runs the long sets: generated cases, random days, all tests in full size, lowest and newest versions. Takes hours.
nightly: fuzz days test-lowest $(BENCH)-ha/.tried
	@NIGHTLY=1 $(MAKE) --keep-going coverage test-peers audit test-newest

## Checks format, lint, types, and which package may import which.
check: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

## Checks the types of the programs of the guides and examples by pyright, strictly.
pyright: $(VENV)/.dev $(PYRIGHT)/bin/pyright
	@rm -rf $(PYRIGHT)/guides && mkdir $(PYRIGHT)/guides && $(BIN)/python -m tests.guides.write_programs $(PYRIGHT)/guides
	@echo '{"typeCheckingMode": "strict", "venvPath": "$(CURDIR)", "venv": "$(VENV)", "extraPaths": ["$(CURDIR)/src"], "exclude": ["**/test_*.py"]}' > $(PYRIGHT)/guides/pyrightconfig.json
	@$(PYRIGHT)/bin/pyright -p $(PYRIGHT)/guides $(ARGS)

$(PYRIGHT)/bin/pyright:
	@$(PYTHON) -m venv $(PYRIGHT) && $(PYRIGHT)/bin/pip install --quiet --disable-pip-version-check pyright

## Formats the code, and applies automatic lint fixes.
format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

## Builds the documentation as a site, in site/; a broken link or cross reference is an error.
docs: $(VENV)/.dev
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict $(ARGS)
	@echo "open site/index.html, or: $(BIN)/mkdocs serve"

## Builds the wheel into dist/ and checks it for a package index.
wheel: $(VENV)/.dev
	@rm -rf dist
	@$(BIN)/pip wheel --quiet --disable-pip-version-check --no-deps -w dist .
	@$(BIN)/twine check --strict dist/*

# SIGN=1 signs each file by sigstore, as the person in a browser or as the CI.
## Builds what is published into dist/: wheel, sdist, documentation, bill of materials, image, and the hashes of all.
release: docs wheel $(AUDIT)/.ready
	@cat requirements/run.txt requirements/all.txt | $(AUDIT)/bin/cyclonedx-py requirements --pyproject pyproject.toml --output-reproducible -o dist/homebot.cdx.json -
	@$(BIN)/python -m hatchling build -t sdist -d dist && $(BIN)/twine check --strict dist/*.tar.gz
	@tar -czf dist/homebot-site.tar.gz -C site .
	@for engine in podman docker ""; do [ -z "$$engine" ] || ! $$engine info > /dev/null 2>&1 || break; done; \
		if [ -z "$$engine" ]; then echo "no image: neither podman nor docker works here"; else \
		BUILDAH_FORMAT=docker $$engine build --quiet --tag homebot . && $$engine save --output dist/homebot-image.tar homebot; fi
	@cd dist && sha256sum * > SHA256SUMS && cat SHA256SUMS
	@[ -z "$(SIGN)" ] || { $(AUDIT)/bin/pip install --quiet --disable-pip-version-check sigstore && $(AUDIT)/bin/sigstore sign dist/*; } || \
		{ echo "not signed, as sigstore.dev or an identity was not to be had; all else is in dist/: $(AUDIT)/bin/sigstore sign dist/*" >&2; exit 1; }

## Measures speed and memory, compared with Home Assistant if it can be installed.
bench: $(BENCH)/.ready $(VENV)/.peers $(BENCH)-ha/.tried $(BENCH)-zigbee/.tried
	@$(BENCH)/bin/python benchmarks/run.py --extras $(BIN)/python --home-assistant $(BENCH)-ha/bin/python $(ARGS)

## Updates the versions that CI installs to the newest.
lock:
	rm -rf .venv-lock && $(PYTHON) -m venv .venv-lock
	.venv-lock/bin/pip install --quiet --disable-pip-version-check uv
	.venv-lock/bin/python requirements/lock.py
	rm -rf .venv-lock

# The names of packages are sent to PyPI, which answers with their advisories.
## Looks up advisories on every locked package.
audit: $(AUDIT)/.ready
	$(AUDIT)/bin/pip-audit --strict --require-hashes --disable-pip $(call LOCKED,run all dev peers)

## Runs all tests with the lower bounds of pyproject.toml.
test-lowest:
	$(PYTHON) -m venv .venv-lowest
	.venv-lowest/bin/pip install --quiet --disable-pip-version-check -c constraints-lowest.txt -e ".[dev,all]"
	.venv-lowest/bin/python -m pytest -n 3 -p no:cacheprovider -m "not peers" $(ARGS)

# pyproject.toml keeps some packages back, as tests/test_library_insides.py says why: those are printed.
## Runs the quick tests, and one with a peer for each extra, with the newest version of every package.
test-newest:
	rm -rf .venv-newest && $(PYTHON) -m venv .venv-newest
	.venv-newest/bin/pip install --quiet --disable-pip-version-check --upgrade -e ".[dev,all,peers]"
	.venv-newest/bin/pip list --disable-pip-version-check --outdated
	.venv-newest/bin/python -m pytest -n 3 -p no:cacheprovider -m "newest or not slow and not system and not peers" $(ARGS)

## Removes everything that these targets created.
clean:
	rm -rf dist $(VENV) $(AUDIT) $(PYRIGHT) .venv-lowest .venv-newest .venv-lock $(BENCH) $(BENCH)-ha $(BENCH)-zigbee site .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis

$(AUDIT)/.ready:
	$(PYTHON) -m venv $(AUDIT)
	$(AUDIT)/bin/pip install --quiet --disable-pip-version-check pip-audit==2.10.1 cyclonedx-bom==7.5.0
	@touch $@

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

# Every file that is installed has a hash in requirements/, and homebot is built by what is installed already.
PIP = -m pip install --quiet --disable-pip-version-check
LOCKED = $(patsubst %,-r requirements/%.txt,$(1))
OWN = --no-deps --no-build-isolation -e .

$(VENV)/.run: pyproject.toml $(wildcard requirements/*.txt) | $(VENV)/bin/python
	@$(BIN)/python $(PIP) --no-deps --require-hashes $(call LOCKED,run)
	@$(BIN)/python $(PIP) $(OWN)
	@touch $@

$(VENV)/.dev: pyproject.toml $(wildcard requirements/*.txt) | $(VENV)/bin/python
	@$(BIN)/python $(PIP) --no-deps --require-hashes $(call LOCKED,run all dev)
	@$(BIN)/python $(PIP) $(OWN)
	@touch $@ $(VENV)/.run

# Most modules of the packages are never imported, so none is compiled.
$(VENV)/.peers: pyproject.toml $(wildcard requirements/*.txt) | $(VENV)/bin/python
	@$(BIN)/python $(PIP) --no-deps --no-compile --require-hashes $(call LOCKED,run all dev peers)
	@$(BIN)/python $(PIP) $(OWN)
	@touch $@ $(VENV)/.run $(VENV)/.dev

# Only what users install, so that start-up and memory are those of a user's installation.
$(BENCH)/.ready: pyproject.toml requirements/run.txt
	@$(PYTHON) -m venv $(BENCH)
	@$(BENCH)/bin/python $(PIP) --no-deps --require-hashes $(call LOCKED,run)
	@$(BENCH)/bin/python $(PIP) $(OWN)
	@touch $@

# A peer, in a venv of its own because it pins its packages: the newest that this Python can install. Takes minutes, once.
$(BENCH)-ha/.tried:
	@echo "installing Home Assistant into $(BENCH)-ha, to compare with; this takes some minutes, once"
	@$(PYTHON) -m venv $(BENCH)-ha
	@$(BENCH)-ha/bin/python -m pip install --quiet --disable-pip-version-check homeassistant \
		&& $(BENCH)-ha/bin/python benchmarks/home_assistant_requirements.py > $(BENCH)-ha/mqtt.txt \
		&& $(BENCH)-ha/bin/python -m pip install --quiet --disable-pip-version-check -r $(BENCH)-ha/mqtt.txt \
		|| { echo "Home Assistant cannot be installed here: the benchmarks skip it"; rm -rf $(BENCH)-ha/bin; }
	@touch $@

# The program whose messages are the input of a benchmark; it is run without a radio. GPL-3.0, so it is not in the repository.
$(BENCH)-zigbee/.tried:
	@mkdir -p $(BENCH)-zigbee
	@npm install --silent --ignore-scripts --prefix $(BENCH)-zigbee zigbee2mqtt@2.14.1 \
		|| echo "Zigbee2MQTT cannot be installed here: the benchmark zigbee_house is skipped"
	@touch $@
