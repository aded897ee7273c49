# Front door. Every target sets up .venv first when that is needed.
.DEFAULT_GOAL := help
SHELL := /bin/bash
BIN := .venv/bin
READY := .venv/.ready
PACKAGES := geometry fem tmm validation
# as the command line does for itself: small products gain nothing from more threads
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: help setup report report-quick docs test test-heavy test-witnesses lint format lock clean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-14s %s\n", $$1, $$2}' Makefile

setup: $(READY) ## prepare .venv and the system libraries (the other targets do so by themselves)

# the stamp names its checkout, so a copied or moved one is set up anew
ifneq ($(shell tail -n 1 $(READY) 2>/dev/null),$(CURDIR))
.PHONY: $(READY)
endif
$(READY): .setup/lock.txt .setup/bootstrap.sh pyproject.toml
	@PYTHON='$(PYTHON)' bash .setup/bootstrap.sh

report: $(READY) ## write the full report to report/
	$(BIN)/tactgen report --out report

report-quick: $(READY) ## write the reduced report to report-quick/
	$(BIN)/tactgen report --quick --out report-quick

docs: $(READY) ## write the documentation site to site/
	@bash .setup/docs/build.sh

# one file's tests stay together: they share solved models
test: $(READY) ## run the tests, less the heavy ones
	@# each worker compiles the tests anew, some ten seconds, where Python is told to keep no bytecode
	env -u PYTHONDONTWRITEBYTECODE $(BIN)/pytest --numprocesses auto --dist loadfile \
		--no-loadscope-reorder

test-heavy: $(READY) ## run the heavy tests
	$(BIN)/pytest -m heavy

PEERS := .venv-peers
ASKED = import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]\
["optional-dependencies"]["peers"], sep="\n")

# an environment of their own: SfePy asks for an older mpmath than the lock has, and a C compiler
$(PEERS)/.ready: $(READY) pyproject.toml
	$(BIN)/uv venv --quiet --clear --python $(BIN)/python $(PEERS)
	$(BIN)/python -c '$(ASKED)' > $(PEERS)/asked.txt
	$(BIN)/uv pip install --quiet --python $(PEERS)/bin/python --requirement $(PEERS)/asked.txt
	touch $@

test-witnesses: $(PEERS)/.ready ## let public programs solve random devices beside this one
	TACTGEN_PEERS=$(CURDIR)/$(PEERS)/bin/python $(BIN)/pytest -m heavy -s tests/witnesses \
		tests/validation/evidence/test_witnesses.py

lint: $(READY) ## check style, types and layering
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(READY) ## put the code in shape
	$(BIN)/ruff check --fix-only
	$(BIN)/ruff format

COMPILE = $(BIN)/uv pip compile --quiet --no-config --universal --fork-strategy fewest \
	--python-version 3.11 --generate-hashes --custom-compile-command 'make lock' \
	$(if $(UPGRADE),--upgrade)

lock: $(READY) ## renew the locks in .setup from pyproject.toml (UPGRADE=1: newest versions)
	$(COMPILE) --group dev --output-file .setup/lock.txt pyproject.toml
	$(COMPILE) --group docs --constraints .setup/lock.txt --output-file .setup/docs-lock.txt

clean: ## remove reports and caches (not .venv)
	rm -rf report report-quick site .sphinx dist .hypothesis .import_linter_cache .mypy_cache \
		.pytest_cache .ruff_cache
	find $(PACKAGES) tests -name __pycache__ -prune -exec rm -rf {} +
