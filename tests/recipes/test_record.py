"""A record is one class: its role and its fields say all that others show of it, and the suite over kinds holds it."""

from __future__ import annotations

import pytest
from recipes import Recipe

ROLE = """    ROLE = Role(
        Subject.PATH, Level.MESSAGES, end="end", work="task", lane="{source}: detours", label="detour {number}"
    )
"""

RECORD = f'''@dataclass(frozen=True)
class DetourRecord(Record):
    """A way around an obstacle, driven from ``time`` to ``end`` (ps): ``points``, n × 2, (row, column) in cells."""

{ROLE}    IN_CELLS = ("points",)
    TIMES = ("end",)

    end: int
    number: int
    points: Points
    arrived: bool


'''

SAMPLE = "        DetourRecord(2 * 10**11, 'robot', 3 * 10**11, 1, way, True),\n"
IMPORT = "from codesign.ground.records import DetourRecord\n\n\n"
LINE = "| `/fpga/detour` | `DetourRecord` | `codesign.DetourRecord` | a way around an obstacle |\n"

SUITE = (
    "import pytest\n"
    "print(pytest.main(['-rA', '-p', 'no:cacheprovider', 'tests/kinds/test_records.py', '-k', 'Detour']))\n"
)


def tree(folder: pytest.TempPathFactory, record: str) -> Recipe:
    recipe = Recipe(folder.mktemp("tree"), "a record in the trace")
    recipe.edit("ground/records.py", ("RECORD_TYPES: dict[str, type[Record]]", record))
    recipe.edit("docs/traces.md", ("| `/fpga/utilisation`", LINE))
    recipe.edit(
        "tests/support/trace_samples.py",
        ("def a_run(seed", IMPORT),
        ('        MissionRecord(18 * 10**11, "robot", "ended"', SAMPLE),
    )
    return recipe


@pytest.mark.slow
def test_a_new_record_is_seen_as_every_record_is(tmp_path_factory: pytest.TempPathFactory) -> None:
    recipe = tree(tmp_path_factory, RECORD)
    out = recipe.python("-c", SUITE)
    assert "passed" in out
    assert "failed" not in out
    files = ("tests/views/trace/test_show.py", "tests/views/trace/test_mcap.py")
    recipe.python("-m", "pytest", "-q", "-p", "no:cacheprovider", *files)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("said", "instead"), [(ROLE, ""), ("Subject.PATH", "Subject.POSE"), ('end="end"', 'end="end", counts=("cells",)')]
)
def test_a_record_that_says_too_little_is_found(
    tmp_path_factory: pytest.TempPathFactory, said: str, instead: str
) -> None:
    """The suite can fail: for a class without a role, one drawn as what it lacks, one that tells what it lacks."""
    assert said in RECORD
    out = tree(tmp_path_factory, RECORD.replace(said, instead)).python("-c", SUITE)
    assert "failed" in out
