# Every target makes what it needs: a virtual environment with the locked versions, from Python, git and make alone.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
READY := $(VENV)/.ready
PIP := PIP_CONSTRAINT=constraints.txt $(BIN)/pip install --quiet --disable-pip-version-check
OUT := out
# Processes that tests and workers start load compiled modules, where Python was told to write none too.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-all test-versions test-newest bench docs site gallery lint clean
.DEFAULT_GOAL := test

# What a user has, and what the developers add to it. Installed once, and again where the two files change.
$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "Python 3.11 or newer is needed, this is " + sys.version.split()[0] + ": make PYTHON=python3.12 ...")'
	@echo "Installing the package into $(VENV) (once; a minute or two) ..."
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) -e .
	@touch $@

$(READY): $(INSTALLED)
	@echo "Installing the tools of developers into $(VENV) (once; a minute or two) ..."
	@$(PIP) -e '.[dev,docs,rtl]'
	@touch $@

demo: $(INSTALLED)
	@mkdir -p $(OUT)
	$(BIN)/hwsw advise floor-plan --goal 150,60 --rate 2kHz --boards raspberry-pi-5,jetson-orin-nano,pynq-z2,kv260 --html $(OUT)/advice.html --write $(OUT)/advice
	$(BIN)/hwsw run virtex4-pci labyrinth --trace $(OUT)/labyrinth.mcap --html $(OUT)/labyrinth-run.html
	$(BIN)/hwsw trace show $(OUT)/labyrinth.mcap --limit 12
	$(BIN)/hwsw explore virtex4-pci labyrinth --store $(OUT)/labyrinth.sqlite --html $(OUT)/labyrinth.html --csv $(OUT)/labyrinth.csv
	@echo
	@echo "Which board:      $(OUT)/advice.html  (open it in a browser; the designs: $(OUT)/advice)"
	@echo "One design point: $(OUT)/labyrinth-run.html"
	@echo "The exploration:  $(OUT)/labyrinth.html  (every point: $(OUT)/labyrinth.csv)"
	@echo "Its trace:        $(OUT)/labyrinth.mcap  (hwsw trace show, or Foxglove)"

test: $(READY)
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not slow"

test-all: $(READY)
	HYPOTHESIS_NEW_EXAMPLES=1 $(BIN)/python -m pytest -n 2 --dist worksteal

# The wheel in empty environments: the newest versions that pyproject.toml admits, and the lowest.
test-versions: $(READY)
	$(BIN)/python tests/support/versions.py newest
	$(BIN)/python tests/support/versions.py lowest

test-newest: $(READY)
	$(BIN)/python tests/support/versions.py smoke

bench: $(READY)
	$(BIN)/python -m benchmarks

docs: $(READY)
	$(BIN)/python -m docs.make_reference
	$(BIN)/python -m docs.make_tour

gallery: $(READY)
	$(BIN)/python -m docs.make_gallery

site: $(READY)
	$(BIN)/python -m docs.make_site $(OUT)/site

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -m slow tests/docs/test_python.py

clean:
	rm -rf $(VENV) out
