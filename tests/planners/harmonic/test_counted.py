"""What synthesis counts: the laws of the demand against rows of blocks that they are not fitted to."""

from __future__ import annotations

import numpy as np
import pytest

from codesign.planners.harmonic.styles import counted, geometry
from codesign.planners.measured import resource_rows


@pytest.mark.parametrize("family", ["ecp5", "gowin"])
@pytest.mark.parametrize("resource", ["lut4", "flip_flops"])
def test_counts_of_sizes_held_out_are_met(family: str, resource: str) -> None:
    """The whole array within 5 % in the mean and 10 % at worst on blocks that no line is fitted to."""
    rows = [row for row in resource_rows("harmonic", "bit_serial") if row.family == family]
    held = [row for row in rows if counted.held_out(row.variables)]
    index, errors = resource == "flip_flops", []
    for row in held:
        laws = (
            (counted.fit_of(family, piece, resource), terms[index]) for piece, terms in counted.ARRAY.items()
        )
        law = sum(line.value(terms(row.variables)) for line, terms in laws)
        errors.append(abs(law / sum(row.count(piece, resource) for piece in row.pieces) - 1))
    assert len(errors) >= 3
    assert np.mean(errors) < 0.05
    assert max(errors) < 0.1


def test_block_rams_are_those_of_synthesis() -> None:
    for row in resource_rows("harmonic", "bit_serial"):
        values = row.variables
        block = values["ROWS"], values["COLUMNS"]
        assert row.count("clusters", "block_rams") == geometry.cluster_count(*block)
        grid = values["DOWN"], values["ACROSS"]
        assert row.count("borders", "block_rams") == geometry.border_rams(*block, *grid)
    for row in resource_rows("harmonic", "bit_serial", "decide"):
        values = row.variables
        shape, last = (values["ROWS"], values["COLUMNS"]), values["LAST_PRECISION"]
        rams = geometry.field_rams_a_memory(*shape, last, [(1 << 14, 1)])
        assert row.count("field", "block_rams") == geometry.FIELD_MEMORIES * rams
