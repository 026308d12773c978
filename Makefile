# `make check` does all that CI does. Numba's cache on disk can be stale after a kernel changed that
# another file's kernel calls, so checks start from an empty one.
PYTHON ?= python

.PHONY: check lint format types floors test docs figures gallery bench clean

check: lint types floors docs test

lint:
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .

format:
	$(PYTHON) -m ruff check --fix .
	$(PYTHON) -m ruff format .

types:
	$(PYTHON) -m pyright

floors:
	$(PYTHON) -c "from importlinter.cli import lint_imports_command; lint_imports_command()"

test:
	cache=$$(mktemp -d) && trap 'rm -rf "$$cache"' EXIT && NUMBA_CACHE_DIR=$$cache $(PYTHON) -m pytest

docs:
	NO_MKDOCS_2_WARNING=1 $(PYTHON) -m mkdocs build --strict --quiet

figures:
	$(PYTHON) docs/figures/make_figures.py
	$(PYTHON) docs/make_warp_pictures.py
	$(PYTHON) docs/make_before_after.py

gallery:
	$(PYTHON) docs/make_gallery.py

bench:
	$(PYTHON) -m belvedere.cli bench

clean:
	rm -rf site build dist .pytest_cache .ruff_cache .import_linter_cache
	find . -name __pycache__ -type d -not -path './.venv/*' -prune -exec rm -rf {} +
