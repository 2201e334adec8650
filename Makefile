# Two commands do everything: `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# Two halves of about the same length, one per core; a new folder of tests falls into the second.
FIRST := $(addprefix tests/,calibration cases checking codegen estimator identification plant recording windows)

# Tests start hundreds of processes: each would compile every library's Python anew.
export PYTHONDONTWRITEBYTECODE =

.PHONY: demo test test-types test-first test-rest studies docs check lock clean

demo: $(STAMP)
	$(BIN)/softsoil study --vehicle paper --out runs/study-paper
	$(BIN)/softsoil study

test: $(STAMP)
	$(BIN)/ruff check .
	$(MAKE) --no-print-directory -j3 test-types test-first test-rest

test-types: $(STAMP)
	$(BIN)/mypy

test-first: $(STAMP)
	$(BIN)/python -m pytest -m "not study" $(FIRST)

test-rest: $(STAMP)
	$(BIN)/python -m pytest -m "not study" tests $(addprefix --ignore=,$(FIRST))

# What `make test` leaves out: accuracy and whole roads, whose code faster tests run.
studies: $(STAMP)
	$(BIN)/python -m pytest -m study tests

docs: $(STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet

check: test

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; assert sys.version_info >= (3, 11), f"softsoil needs Python 3.11 or newer, found {sys.version}"'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt -e '.[dev]'
	touch $@

# Write the versions of the present environment as the new constraints.
lock:
	$(BIN)/python -m pip freeze --all --exclude-editable | grep -v -E '^(softsoil|pip)==' > constraints.txt

clean:
	rm -rf $(VENV) build *.egg-info runs
