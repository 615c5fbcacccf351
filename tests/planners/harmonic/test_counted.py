"""What synthesis counts: the laws of the demand against rows of blocks that they are not fitted to."""

from __future__ import annotations

import numpy as np
import pytest

from codesign.planners.harmonic.styles import resources
from codesign.planners.harmonic.styles.resources import ARRAY, DIGITS
from codesign.planners.measured import resource_rows


@pytest.mark.parametrize("resource", ["lut4", "flip_flops"])
@pytest.mark.parametrize(("family", "of_digits"), [("ecp5", False), ("gowin", False), ("xc4v", False), ("ecp5", True)])
def test_counts_of_sizes_held_out_are_met(family: str, resource: str, of_digits: bool) -> None:
    """The whole array within 5 % in the mean and 10 % at worst on blocks that no line is fitted to."""
    rows = [row for row in resource_rows("harmonic", "bit_serial") if row.family == family]
    held = [
        row for row in rows if ARRAY.held_out(row.variables) and (row.variables.get("DIGIT_BITS", 1) > 1) is of_digits
    ]
    laws, errors = DIGITS if of_digits else ARRAY, []
    for row in held:
        law = sum(laws.value(piece, resource, row.variables, family) for piece in laws.pieces)
        errors.append(abs(law / sum(row.count(piece, resource) for piece in row.pieces) - 1))
    assert len(errors) >= 3
    assert np.mean(errors) < 0.05
    assert max(errors) < 0.1


@pytest.mark.parametrize("family", ["ecp5"])
def test_rows_of_digits_move_no_fit_of_bit_serial_circuits(family: str) -> None:
    fits = (laws.fit("nodes", "lut4", laws.rows[0].variables, family) for laws in (ARRAY, DIGITS))
    taken = [len(law.residuals + law.held_out) for law in fits]
    counts = [
        row.variables.get("DIGIT_BITS", 1) for row in resource_rows("harmonic", "bit_serial") if row.family == family
    ]
    assert taken == [counts.count(1), len(counts)]
    assert len(counts) > counts.count(1)


def test_block_rams_are_those_of_synthesis() -> None:
    for row in resource_rows("harmonic", "bit_serial"):
        values = row.variables
        block = values["ROWS"], values["COLUMNS"]
        bits, grid = values.get("DIGIT_BITS", 1), (values["DOWN"], values["ACROSS"])
        assert row.count("clusters", "block_rams") == bits * resources.cluster_count(*block)
        assert row.count("borders", "block_rams") == bits * resources.border_rams(*block, *grid)
    for row in resource_rows("harmonic", "bit_serial", "decide"):
        values = row.variables
        shape, last = (values["ROWS"], values["COLUMNS"]), values["LAST_PRECISION"]
        rams = resources.field_rams_a_memory(*shape, last, [(1 << 14, 1)])
        assert row.count("field", "block_rams") == resources.FIELD_MEMORIES * rams
