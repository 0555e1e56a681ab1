# The two commands of the README, and what they are made of. `make help` lists the targets.
.DEFAULT_GOAL := help
SAMPLE  := samples/bracket.step
PICTURE := out/bracket.png

.PHONY: help setup setup-tests picture test test-cpp test-python check bench clean

help: ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

setup: ## install what is missing: system packages, .venv, the built package
	@scripts/setup

picture: setup ## render a sample and say where the picture is
	@mkdir -p out
	@.venv/bin/trimray render $(SAMPLE) -o $(PICTURE) --size 1024,768
	@echo "The picture is in $(abspath $(PICTURE))"

test: test-cpp test-python ## all tests

setup-tests:
	@scripts/setup --tests

test-cpp: setup-tests
	@cmake --preset release -DPython_EXECUTABLE=$(abspath .venv/bin/python) >/dev/null
	@cmake --build --preset release
	@ctest --preset release -j 2 --output-on-failure

test-python: setup-tests
	@.venv/bin/python -m pytest

check: setup ## format, lint, types and tests: all that CI runs
	@scripts/check

bench: setup ## the measured figures of the README
	@scripts/bench

clean: ## remove what was built (not .venv)
	rm -rf build out
