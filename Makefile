# Two commands do everything: `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# Processes that run tests: one per core.
WORKERS := logical

.PHONY: demo test test-types test-code docs check lock clean

demo: $(STAMP)
	$(BIN)/softsoil study --vehicle paper --out runs/study-paper
	$(BIN)/softsoil study

test: $(STAMP)
	$(BIN)/ruff check .
	$(MAKE) --no-print-directory -j2 test-types test-code

test-types: $(STAMP)
	$(BIN)/mypy

test-code: $(STAMP)
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal tests

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
