"""A law of what synthesis counts is a line of a table: the suite over styles holds it to the rows."""

from __future__ import annotations

from pathlib import Path

import pytest
from recipes import Recipe

TABLE = "planners/breadth_first/measured/laws.yaml"
TESTS = "-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider", "tests/kinds/test_styles.py", "-k"
LAWS = "breadth_first and (term or interval)"


def tree(folder: Path, *changes: tuple[str, str]) -> Recipe:
    recipe = Recipe(folder, "a law of what synthesis counts")
    recipe.edit(TABLE, *changes)
    return recipe


@pytest.mark.slow
def test_a_new_term_is_fitted_and_held_to_every_row(tmp_path: Path) -> None:
    changed = tree(
        tmp_path,
        ("  pieces:\n", "    square: ADDRESS_BITS * ADDRESS_BITS\n"),
        ("LINEAR, LINEAR * ADDRESS_BITS", "square, "),
    )
    assert "failed" not in changed.python(*TESTS, LAWS)


@pytest.mark.slow
def test_a_term_that_no_row_has_is_found(tmp_path: Path) -> None:
    changed = tree(tmp_path, ("LINEAR, LINEAR * ADDRESS_BITS", "0 * LINEAR, "))
    with pytest.raises(AssertionError, match="state machine"):
        changed.python(*TESTS, LAWS)
