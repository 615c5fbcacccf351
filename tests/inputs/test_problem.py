"""Maps of a problem that are no regular file."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import ON_A_MAP

from codesign import load_workload
from codesign.ground.errors import SpecError


@pytest.mark.parametrize(("file", "what"), [("/dev/zero", "a device or a pipe"), (".", "a folder")])
def test_what_is_no_regular_file_is_not_asked_whether_it_was_meant(tmp_path: Path, file: str, what: str) -> None:
    (tmp_path / "w.yaml").write_text(ON_A_MAP.format(file=file))
    with pytest.raises(SpecError, match=f"is not a file but {what}") as caught:
        load_workload(tmp_path / "w.yaml")
    assert "did you mean" not in str(caught.value)
