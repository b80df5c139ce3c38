# make demo: a first flight on a fresh machine. make test: the whole suite. The rest is for working on the testbed.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed

.PHONY: demo test robustness check bench bench-long blind strangers format docs clean

demo: $(STAMP)
	@rm -rf runs/demo
	@$(BIN)/testbed run scenarios/zero_g.toml --out runs/demo

# Tests start the command some hundred times; without bytecode each start compiles the package anew.
test: $(STAMP)-dev
	@PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses logical --dist loadfile

# make robustness gives the commands all that can be wrong with what they are given; CASES="MJCF" only what has this in its name.
robustness: $(STAMP)-dev
	@OMP_NUM_THREADS=1 $(BIN)/python -m tests.robustness "$(CASES)"

check: $(STAMP)-dev
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check .
	@$(BIN)/mypy
	@$(BIN)/mypy --package benchmarks
	@$(BIN)/lint-imports

bench: $(STAMP)-dev
	@OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --write

bench-long: $(STAMP)-dev
	@OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --long --write
	@OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --figures

# make blind makes, diagnoses and scores the blind set, and writes docs/blind.md; with FIRST=400 only so many of its cases,
# which are in random order; with CASES=24 a smaller set, in runs/ only.
blind: $(STAMP)-dev
	@$(BIN)/python -m benchmarks.blind $(if $(CASES),--cases $(CASES),--write) $(if $(FIRST),--first $(FIRST))

# make strangers makes, diagnoses and scores the cases that Basilisk flies, and writes docs/strangers.md; it can be interrupted,
# and goes on where it was; with FIRST=20 only so many of each satellite's cases, in random order, in runs/ only.
strangers: $(STAMP)-dev
	@$(BIN)/python -m benchmarks.strangers make $(if $(FIRST),--first $(FIRST))
	@$(BIN)/python -m benchmarks.strangers run $(if $(FIRST),--first $(FIRST))
	@$(BIN)/python -m benchmarks.strangers card $(if $(FIRST),,--write)

format: $(STAMP)-dev
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

# make docs brings the published tables up to date and builds the site; search in it needs: python -m http.server -d build/site
docs: $(STAMP)-dev
	@$(BIN)/python -m testbed.scenario.published
	@$(BIN)/python -m testbed.effects.published
	@$(BIN)/python -m testbed.logs.published
	@$(BIN)/python -m testbed.formats.published
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "build/site/index.html"

clean:
	rm -rf $(VENV) runs build

# The first line refuses an interpreter that is too old before anything is downloaded for it.
$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed, this is " + sys.version.split()[0] + "; name another with: make PYTHON=python3.12")'
	@echo "Installing into $(VENV) (a minute or two, once) ..."
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

$(STAMP)-dev: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@
