"""The reach of the model: laws against circuits that were simulated, synthesised and placed, and against papers.

``measure`` runs the circuits and reads the rows. Nothing is left out because it does not fit: what does not match has a
reason and an experiment in ``reasons``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property

from codesign.ground.units import counted
from codesign.hardware.fidelity.claims import Claim, claims
from codesign.hardware.fidelity.mismatches import Mismatch, Spread, mismatches, spreads
from codesign.hardware.fidelity.points import Point, points
from codesign.hardware.rtl.campaign import Asked, Checked, StyleChecked, samples, verify_all
from codesign.system import catalog

# Why something does not match, and the experiment that would settle it: one table, by what it explains.

REPORT = "hwsw rtl for such a part, the vendor's tool, and hwsw calibrate fpga --report of its reports"

ISE = "ISE 9 on the Verilog of hwsw rtl for an XC2V6000, through hwsw calibrate fpga --report"


@dataclass(frozen=True)
class Reason:
    """The reason of a mismatch.

    - ``what``: a pattern of the keys of mismatches. ``why``, and the ``experiment``: sentences.
    - ``shown``: what shows ``why``: a file, a command, or how the law is made. "" if nothing does.
    """

    what: str
    why: str
    experiment: str
    shown: str = ""

    @property
    def words(self) -> str:
        """The cause, with what shows it; or as a likely one."""
        return f"{self.why} (shown by {self.shown})" if self.shown else f"Likely: {self.why}"


REASONS: tuple[Reason, ...] = (
    Reason(
        "resources/harmonic/bit_serial/nodes/lut4",
        "On Virtex-II and Virtex-4, the families of the paper, the law keeps the published node. The Verilog of this"
        " package has a smaller one. On all other families the law is that of the rows.",
        ISE,
        shown="the rows in codesign/planners/harmonic/measured/resources.json",
    ),
    Reason(
        "resources/harmonic/bit_serial/others/*",
        "the published node has the logic of its cluster in it. The Verilog of this package has that logic apart, and"
        " on Virtex-II and Virtex-4 the law has no line for it.",
        ISE,
    ),
    Reason(
        "resources/harmonic/bit_serial/array control/*",
        "On Virtex-II and Virtex-4 the law is what the paper's largest block leaves for one set of counters, however"
        " large the block is. On the 7 series a line of a few hundred LUT is fitted to few sizes.",
        "More blocks: python -m benchmarks.measure resources harmonic; and the paper's block, 48 × 96, through ISE.",
        shown="docs/laws.md, where the law is made",
    ),
    Reason(
        "resources/harmonic/bit_serial/OR trees/lut4",
        "a tree is a whole number of LUT on each level. The law is a straight line through these steps, and pipelined"
        " trees are a few LUT in all.",
        "More sizes of this line: python -m benchmarks.measure resources ROOM.",
    ),
    Reason(
        "resources/harmonic/bit_serial/control/*",
        "the widths of the counters step at powers of two, of precision, stages and blocks. The law is a straight"
        " line.",
        "More sizes of this line: python -m benchmarks.measure resources ROOM.",
    ),
    Reason(
        "resources/harmonic/bit_serial/border addresses/lut4",
        "the addresses are a few tens of LUT. Their widths step at powers of two of blocks and precision, and the law"
        " is a straight line.",
        "More sizes of this line: python -m benchmarks.measure resources harmonic.",
    ),
    Reason(
        "resources/harmonic/decide bit_serial/decision/lut4",
        "a decision by itself is some thirty LUT beside its counters, and synthesis merges the two in other ways on"
        " each size of map.",
        "More sizes of this line: python -m benchmarks.measure resources harmonic.",
    ),
    Reason(
        "resources/harmonic/decide bit_serial/others/*",
        "a large map takes several memories. The logic that selects one of them has no line in the demand.",
        "A line of the demand for it, fitted to the rows of codesign/planners/harmonic/measured/.",
    ),
    Reason(
        "resources/wavefront/tiled/halo/lut4",
        "A cell around the tile is a comparator. Synthesis gives all cells of one width as many LUT, but not in a line"
        " with the width: 7 at 8 bits of the ECP5, 14 at 9, 10 at 10, 13 at 11, 18 at 12. The law is a straight line.",
        "A row for each width that a map may ask for: python -m benchmarks.measure resources wavefront.",
        shown="the rows in codesign/planners/wavefront/measured/resources.json",
    ),
    Reason(
        "resources/wavefront/tiled/*",
        "these lines are a few tens of LUT each, and synthesis moves logic between them: their sum is within 4.7 % on"
        " the sizes that were held out.",
        "More sizes of tiles: python -m benchmarks.measure resources wavefront.",
    ),
    Reason(
        "resources/wavefront/*/read-out/lut4",
        "the read-out is a tree of AND and OR over the words of all nodes. Synthesis shares more of it in arrays of"
        " some sizes than of others, which a sum of terms does not follow.",
        "More sizes of this line: python -m benchmarks.measure resources ROOM.",
    ),
    Reason(
        "resources/velocity_obstacle/*",
        "On Spartan-3E the law adds what Table I of the paper has beyond the circuit of this package. The paper does"
        " not say what that is.",
        "The Verilog of the authors, or a synthesis report by module: hwsw calibrate fpga --report holds it against"
        " the law line by line.",
        shown="docs/velocity_obstacle.md, where the law is made",
    ),
    Reason(
        "paper/velocity obstacles LUT*",
        "links to the robots are in the published count. The paper gives only shares of the part, by style, and does"
        " not say what the rest of Table I does. The circuit of this package does the same work in fewer LUT.",
        "A synthesis report of the authors' design by module, or their Verilog through hwsw calibrate fpga --report.",
    ),
    Reason(
        "paper/harmonic control",
        "the published count includes what the text does not describe, such as the link to the host. The control here"
        " counts visits, stages and cycles, and loads the map from a stream.",
        "The authors' design, synthesised by module.",
    ),
    Reason(
        "paper/harmonic decision",
        "the authors' module squares or multiplies. The published count grows with the precision, and the paper does"
        " not explain it. Here the larger difference of each pair of opposite neighbours is found bit by bit as the"
        " words leave the memory, without a square.",
        "The authors' decision module, synthesised alone; or one that squares, run by hwsw verify on the same maps.",
    ),
    Reason(
        "paper/harmonic LUT a node",
        "the published node is the mapping of another tool, and of a node alone. Here Yosys maps the node in its"
        " array.",
        ISE,
    ),
    Reason(
        "paper/* clock, *",
        "another part, another tool, or other registers. A paper gives no critical path, so nothing says which of the"
        " three it is.",
        REPORT + ", for the part of the paper",
    ),
    Reason(
        "paper/wavefront cycles a cell",
        "other work is counted. The figure here counts the load of the map, the wave and the path to the start; the"
        " paper's covers its transform of an image alone, and its elements are not described in full.",
        "The same image through both circuits, with the same cycles counted.",
    ),
    Reason(
        "clock/wide/harmonic/*",
        "one size is faster than the others by a fifth, and the median of five placements does not level that. The law"
        " of the family knows no more than its three sizes.",
        "More sizes on this part: python -m benchmarks.measure clocks harmonic GW2A-18-7.",
    ),
    Reason(
        "clock/wide/wavefront/*",
        "most designs were placed with one seed, and seeds of one design lie up to a fifth apart. Where fewer than"
        " three placements of a circuit are held out on a family, the errors of other circuits count too.",
        "Five and more seeds of each size: python -m benchmarks.measure clocks wavefront.",
    ),
    Reason(
        "clock/wide/breadth_first/*",
        "the path goes through one memory, wherever its block RAMs lie. So a placement moves it by more than the size"
        " of the map does, and three seeds do not level that.",
        "Five and more seeds of each size: python -m benchmarks.measure clocks breadth_first.",
    ),
    Reason(
        "clock/alone/*",
        "No other placement has this pipeline on this part, or none has it in another size: the fit meets such a clock"
        " by construction, and nothing holds it out.",
        "More sizes of the same pipeline: python -m benchmarks.measure clocks ROOM.",
        shown="codesign/planners/ROOM/measured/clocks.json",
    ),
    Reason(
        "never placed/xc7",
        "Open timing of the 7 series is not to be trusted yet: it is several times too pessimistic.",
        REPORT,
        shown="docs/synthesis.md: 12.5 MHz where the vendor's tool gave 40",
    ),
    Reason(
        "never placed/ice40",
        "The circuits with two write ports a memory have no iCE40 form, so none was placed.",
        "A memory of one write port for the iCE40, and nextpnr-ice40.",
        shown="hwsw synth --family ice40, which refuses them",
    ),
    Reason(
        "never placed/*",
        "No open tool routes these families.",
        REPORT,
        shown="the parts that nextpnr builds of the registry place",
    ),
    Reason(
        "never synthesised/*/ice40",
        "No block RAM of the iCE40 has two ports that write.",
        "A memory of one write port for the iCE40.",
        shown="hwsw synth --family ice40, which refuses them",
    ),
    Reason(
        "never synthesised/*",
        "These families were not measured yet. The law takes the rows of another family, and says so.",
        "python -m benchmarks.measure resources ROOM FAMILY",
        shown="codesign/planners/ROOM/measured/resources.json",
    ),
    Reason(
        "never measured/power",
        "There is no board here: static power is that of data sheets and reports, and dynamic power is"
        " a rate a slice times the toggles that were counted.",
        "A board with a current probe in its core supply, a design of hwsw rtl, and the toggles that hwsw verify"
        " --waves records of the same run. A logic analyser on phase and done shows the cycles at that clock too.",
        shown="docs/synthesis.md",
    ),
)


def reason_of(mismatch: Mismatch) -> Reason | None:
    """The first reason that explains a mismatch."""
    return next((reason for reason in REASONS if fnmatchcase(mismatch.key, reason.what)), None)


def idle(mismatches: Sequence[Mismatch]) -> tuple[Reason, ...]:
    """The reasons that explain no mismatch any more."""
    used = {reason_of(mismatch) for mismatch in mismatches}
    return tuple(reason for reason in REASONS if reason not in used)


__all__ = ["Claim", "Fidelity", "Mismatch", "Point", "Reason", "Spread", "asked", "measure", "reason_of"]

SAMPLES, QUICK_SAMPLES = 10, 2
"""Random design points of each circuit that are simulated."""


@dataclass(frozen=True, eq=False, repr=False)
class Fidelity:
    """All that was compared: ``cycles`` by simulation, ``points`` of the rows, ``claims`` of the papers."""

    cycles: tuple[StyleChecked, ...]
    points: tuple[Point, ...]
    claims: tuple[Claim, ...]

    def __repr__(self) -> str:
        points, claims = counted(len(self.points), "point"), counted(len(self.claims), "claim")
        return f"Fidelity({counted(len(self.cycles), 'style')}, {points}, {claims})"

    @cached_property
    def mismatches(self) -> tuple[Mismatch, ...]:
        """Whatever does not match."""
        return mismatches(self.points, self.claims, self.cycles)

    @cached_property
    def by_family(self) -> tuple[Spread, ...]:
        """The errors of resources by family and line."""
        return spreads(self.points, by_family=True)

    @cached_property
    def by_line(self) -> tuple[Spread, ...]:
        """The errors of resources by line, over all families."""
        return spreads(self.points, by_family=False)


def asked(seeds: Sequence[int]) -> list[Asked]:
    """The design points that are simulated."""
    return samples(catalog.circuits().values(), seeds)


def measure(
    seeds: Sequence[int], backend: str = "cxxrtl", jobs: int = 1, progress: Callable[[Checked], None] = lambda _: None
) -> Fidelity:
    """Simulate the samples of these seeds, and compare all rows with the laws.

    ``progress`` is called after each sample.

    Raises:
        MissingToolError: a tool is not installed.
    """
    return compared(verify_all(asked(seeds), backend, jobs, progress))


def compared(cycles: tuple[StyleChecked, ...]) -> Fidelity:
    """The comparison with these simulations."""
    rows = points()
    return Fidelity(cycles, rows, claims(rows))
