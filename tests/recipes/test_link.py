"""A kind of link is a law and a model: all else follows, and the suite over kinds holds it."""

from __future__ import annotations

import pytest
from recipes import Recipe

LAW = '''@dataclass(frozen=True)
class LvdsLaw(Law):
    """Several pairs of wires, after a preamble: preamble + ceil(bits / lanes) cycles."""

    aligned = True
    least: ClassVar[Mapping[str, int]] = {"lanes": 1, "preamble": 0}

    clock: Number
    lanes: Number
    preamble: Number

    def rate(self) -> Number:
        """The clock of the wires, Hz."""
        return self.clock

    def ticks(self, bits: int) -> Number:
        """Cycles of a message."""
        return self.preamble + ceil_div(bits, self.lanes)


'''

MODEL = '''class LvdsLink(AnyLink):
    """Pairs of wires."""

    law = LvdsLaw

    type: Literal["lvds"] = Field(description="Pairs of wires.")
    clock: FrequencyFigure = Field(description="Clock of the wires.")
    lanes: PositiveFigure = Field(description="Pairs of wires.")
    preamble: CountFigure = Field(description="Cycles before each message.")


'''


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Recipe:
    recipe = Recipe(tmp_path_factory.mktemp("tree"), "a kind of link")
    recipe.edit("laws/acts.py", ("@dataclass(frozen=True)\nclass IdealLaw", LAW))
    recipe.edit(
        "inputs/links.py", ("BusLaw, IdealLaw, SerialLaw\n", "LvdsLaw, "), ("LINKS: dict[str, type[AnyLink]]", MODEL)
    )
    recipe.edit("docs/spec.md", ("`ideal` takes no time.", "`lvds` is a link of pairs of wires. "))
    return recipe


@pytest.mark.slow
def test_a_new_link_is_held_to_what_every_kind_is(tree: Recipe) -> None:
    out = tree.python("-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider", "tests/kinds", "-k", "lvds")
    assert "test_no_bound_exceeds_a_value[lvds]" in out
    assert "failed" not in out
    tree.python("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/docs/test_spec.py")


@pytest.mark.slow
def test_a_link_that_is_simulated_by_another_law_is_found(tree: Recipe) -> None:
    """The suite can fail: simulated with a preamble twice as long, a message is not what is priced."""
    script = (
        "import kinds, codesign\n"
        "from codesign.components import link\n"
        "from codesign.study import explore\n"
        "from codesign.study.check import check_points\n"
        "true = link.Link.ticks\n"
        "link.Link.ticks = lambda self, bits: true(self, bits) + self.law.preamble\n"
        "axes = {'line.preamble': [4, 16]}\n"
        "study = explore(kinds.platform(kinds.link('lvds')), kinds.workload(axes), workers=1)\n"
        "print(check_points(study, 2).sentence)\n"
    )
    tree_path = tree.folder / "tests" / "support"
    assert "differ" in tree.python("-c", f"import sys; sys.path.insert(0, {str(tree_path)!r})\n{script}")
