"""The page about fidelity: Markdown, the same text for the same rows."""

from __future__ import annotations

from codesign.hardware.fidelity import Fidelity
from codesign.views.report.fidelity_tables import fidelity_tables
from codesign.views.report.render import render_markdown

HEAD = """# How far the model carries

    {command}

writes this page and its picture: what the laws predict, against circuits of the Verilog of this package that were
simulated, synthesised and placed, and against what papers published. Every number is read from the rows in
`codesign/planners/ROOM/measured/` or counted in a run. Nothing is left out because it does not fit.
[laws.md](laws.md) has the laws, and [reproduction.md](reproduction.md) holds the model against every row of the papers.
"""

PICTURE = """
![law over measured, by style, resource and family of parts]({picture})

A ratio beyond the ends of the axis stands at its end.
"""

SECTIONS = (
    (
        "Cycles",
        "Random design points on random maps, sample {first} to {last} of each circuit. Every event of the circuit is"
        " compared with the model in its kind, its value and its cycle, and every phase in its cycles (`hwsw verify`).",
    ),
    (
        "Resources",
        "Yosys counts the LUT, flip-flops, block RAMs and multipliers (`hwsw synth`). A row that is held out was not in"
        " the fit of the law. Slices are a matter of packing and are not compared.",
    ),
    ("Resources by line", "The same rows, line by line of the demand."),
    (
        "Clocks",
        "nextpnr places and routes each design once for each seed (`hwsw synth --place`). The law is asked about the"
        " same design on the same part.",
    ),
    ("Critical paths", "The path that decides, in words, from the clock edge to the clock edge."),
    ("Power", "No circuit was measured. The laws are held against what was published."),
    (
        "Papers",
        "Figures of the papers that the Verilog has too. A clock stands beside the fastest placement of the same style"
        " on another part: open tools do not route the papers' parts.",
    ),
    (
        "What does not match",
        "Beyond 5 % mean or 10 % worst of LUT and flip-flops, any difference of block RAMs, multipliers and cycles, any"
        " clock outside its interval or with one of more than ±15 %, any figure of a paper that is more than 5 % off.",
    ),
)
"""Heading and text of each table, in the order of ``fidelity_tables``."""


def fidelity_page(result: Fidelity, seeds: range, command: str, picture: str | None = None) -> str:
    """The page. ``picture``: the path of the picture, relative to the page."""
    parts = [HEAD.format(command=command)]
    if picture is not None:
        parts.append(PICTURE.format(picture=picture))
    for (heading, text), table in zip(SECTIONS, fidelity_tables(result), strict=True):
        about = text.format(first=seeds[0], last=seeds[-1])
        parts.append(f"\n## {heading}\n\n{about}\n\n{render_markdown(table)}")
    return "".join(parts)
