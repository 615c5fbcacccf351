"""Tables I to III of Dubey et al. (2013), and the text on cycles and parts: rows without simulation."""

from __future__ import annotations

from codesign.figures import Status
from codesign.inputs import load_part
from codesign.part import Part
from codesign.planners.reproduction import Finding, Plot, Row, Series, Use, row
from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, Detector, Unit
from codesign.planners.velocity_obstacle.published import CLOCK, Style
from codesign.planners.velocity_obstacle.styles import levers, power, resources, timing
from codesign.planners.velocity_obstacle.styles.schedule import DETECT, UPDATE, module_cycles

PARAMETERS = AvoidParameters()
HYBRID_USES = {2: Use.FITTED, 4: Use.KNOWN, 8: Use.HELD_OUT}
"""By the number of robots. The rule that the mapper packs from 97 % on was chosen knowing that 4 robots ran."""
LABELS = {
    Style.SEQUENTIAL: "sequential, 17n - 10",
    Style.PIPELINED: "RC pipelined, 10n + 4",
    Style.HYBRID: "hybrid, 17",
}


def part() -> Part:
    """The part of the paper; its speed grade is not given, and enters no figure here."""
    return load_part(f"{published.PART}-4")


def table_rows() -> tuple[Row, ...]:
    """Every row of Tables I to III and the counts of the text, in the order of the paper."""
    return (*_module_rows(), *_table_i(), *_feasibility_rows(), *_table_ii(), *_table_iii())


def _module_rows() -> list[Row]:
    text = "products on one multiplier, one cycle each, and one to sum up or compare"
    return [
        row(
            "Section III",
            f"cycles of {name}",
            cycles,
            module_cycles(name, Unit.SERIAL),
            unit="cycles",
            status=Status.MEASURED,
            source=f"{count} {text}; the same in the RTL of this package",
            use=Use.HELD_OUT,
        )
        for name, cycles, count in (
            (UPDATE, published.UPDATE_CYCLES, 6),
            (DETECT, published.DETECT_CYCLES, 9),
        )
    ]


def _table_i() -> list[Row]:
    rows = []
    chip = part()
    for style, (slices, luts, milliwatts) in published.TABLE_I.items():
        need = levers.totals(style, 2, PARAMETERS, chip)
        note = "a line beside the RTL of this package is fitted to this row"
        for name, kind, listed in (("CLBs", "slices", slices), ("LUTs", "lut4", luts)):
            rows.append(
                row(
                    "Table I",
                    f"{name}, 2 robots, {style}",
                    listed,
                    100.0 * need[kind] / chip.resources[kind].value,
                    unit="%",
                    status=Status.CALIBRATED,
                    source="units and rest by synthesis of the RTL of this package, what it does not take by this row",
                    use=Use.FITTED,
                    note=note
                    if kind == "lut4"
                    else "the packing ratio is fitted to this row; CLBs taken as slices",
                )
            )
        rows.append(_power_row("Table I", style, 2, milliwatts))
    return rows


def _feasibility_rows() -> list[Row]:
    """Which hybrid designs fit."""
    chip = part()
    rows = []
    for robots, printed in ((2, "fits"), (4, "fits"), (8, "does not fit")):
        short = levers.shortages(Style.HYBRID, robots, PARAMETERS, chip)
        need = levers.totals(Style.HYBRID, robots, PARAMETERS, chip)
        listed = ", ".join(
            f"{need[kind]:,} of {int(chip.resources[kind].value):,} {kind}" for kind in sorted(need)
        )
        rows.append(
            row(
                "Section VI",
                f"hybrid, {robots} robots, on {published.PART}",
                printed,
                "does not fit" if short else "fits",
                status=Status.CALIBRATED,
                source="resources by unit, slices by the mapper's packing",
                use=HYBRID_USES[robots],
                note=f"{listed.replace('_', ' ')}"
                + (f"; short of {', '.join(sorted(short))}" if short else ""),
            )
        )
    return rows


def _table_ii() -> list[Row]:
    return [
        row(
            "Table II",
            f"{LABELS[style]}: {robots} robots",
            cycles,
            timing.cycles_of_trial(style, robots, PARAMETERS),
            unit="cycles",
            status=Status.MEASURED,
            source="list schedule of n updates and n - 1 detections over the style's units; the same in RTL",
            use=Use.HELD_OUT,
        )
        for style, listed in published.TABLE_II.items()
        for robots, cycles in listed.items()
    ]


def _table_iii() -> list[Row]:
    rows = [
        _power_row("Table III", style, robots, milliwatts)
        for style, listed in published.TABLE_III.items()
        for robots, milliwatts in listed.items()
    ]
    fit = power.power_fit()
    return [
        *rows,
        row(
            "Table III",
            "power, 8 robots, hybrid",
            "-",
            fit.power(Style.HYBRID, 8),
            unit="mW",
            status=Status.CALIBRATED,
            source="the same law",
            use=Use.NOTHING,
            note="what it would take on a part that holds it; extrapolated, and unknown in the paper",
        ),
    ]


def _power_row(table: str, style: Style, robots: int, milliwatts: int) -> Row:
    fit = power.power_fit()
    fitted = robots in power.FITTED_ROBOTS
    return row(
        table,
        f"power, {robots} robots, {style}",
        milliwatts,
        fit.power(style, robots),
        unit="mW",
        status=Status.CALIBRATED,
        source=f"{fit.base:.1f} + {fit.slopes[style]:.1f} {fit.form}, 50 MHz, fitted with 2 and 4 robots",
        use=Use.FITTED if fitted else Use.HELD_OUT,
        note="one of six rows that fix four numbers" if fitted else "",
    )


def cycles_plot() -> Plot:
    """Cycles of a trial over the number of robots, with circuits that the paper did not build."""
    robots = tuple(range(2, 17))
    series = [
        Series(
            LABELS[style],
            tuple(map(float, robots)),
            tuple(float(timing.cycles_of_trial(style, n, PARAMETERS)) for n in robots),
        )
        for style in Style
    ]
    for lanes in (2, 4):
        given = PARAMETERS.model_copy(update={"update_units": lanes, "detect_units": lanes})
        cycles = tuple(float(timing.cycles_of_trial(Style.HYBRID, n, given)) for n in robots)
        series.append(Series(f"{lanes} lanes", tuple(map(float, robots)), cycles))
    return Plot(
        "dubey2013-cycles",
        "Cycles to hold one velocity against all other robots",
        "Table II: the first three, at 2, 4 and 8 robots",
        "robots",
        "cycles",
        tuple(series),
    )


def power_plot() -> Plot:
    """Power over the number of robots: the table and the law."""
    fit = power.power_fit()
    robots = (2, 3, 4, 6, 8)
    series = []
    for style, listed in published.TABLE_III.items():
        measured = tuple(map(float, listed)), tuple(map(float, listed.values()))
        series.append(Series(f"{style}, Table III", *measured))
        law = tuple(fit.power(style, n) for n in robots)
        series.append(Series(f"{style}, law", tuple(map(float, robots)), law))
    return Plot(
        "dubey2013-power",
        "Power at 50 MHz; the law is fitted to 2 and 4 robots",
        "Table III",
        "robots",
        "mW",
        tuple(series),
    )


def table_findings() -> tuple[Finding, ...]:
    """The conclusions from the tables."""
    fit, chip = power.power_fit(), part()
    energy = {
        style: published.TABLE_III[style][4] * 1e-3 * published.TABLE_II[style][4] / CLOCK * 1e9
        for style in Style
    }
    lanes = levers.widest_lanes(8, PARAMETERS, chip)
    assert lanes is not None
    extra = (
        (published.TABLE_I[Style.HYBRID][1] - published.TABLE_I[Style.PIPELINED][1])
        / 100
        * published.LUT4_OF_PART
    )
    one, two = (
        resources.LAWS.lines(
            resources.structure(Style.HYBRID, 2, PARAMETERS.model_copy(update={"update_units": count})),
            resources.LAWS.family(chip.family),
        )[resources.UPDATES][0].amount
        for count in (1, 2)
    )
    crossed = module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT)
    return (
        Finding(
            f"A power law of {fit.form} meets the rows with 8 robots, which it has not seen.",
            {"base": f"{fit.base:.1f} mW", "worst miss": f"{power.power_miss():.1%}"},
            power.power_miss() < 0.05,
        ),
        Finding(
            "The sequential circuit draws the least power and spends the most energy.",
            {f"4 robots, {style}": f"{energy[style]:.0f} nJ" for style in Style},
            max(energy, key=energy.__getitem__) is Style.SEQUENTIAL,
        ),
        Finding(
            'The pipelined circuit is not "always better".',
            {"cycles of 2 robots, both": str(published.TABLE_II[Style.PIPELINED][2])},
            published.TABLE_II[Style.PIPELINED][2] == published.TABLE_II[Style.SEQUENTIAL][2],
        ),
        Finding(
            "The LUTs that Table I charges for the hybrid circuit belong to the style, once.",
            {"Table I": f"{extra:,.0f} LUTs", "synthesis of a unit more": f"{two - one}"},
            extra > 10 * (two - one),
        ),
        Finding(
            "The hybrid circuit for 8 robots fits the part with fewer units.",
            {
                "update units": str(lanes.update_units),
                "detect units": str(lanes.detect_units),
                "cycles": str(timing.cycles_of_trial(Style.HYBRID, 8, lanes)),
                "cycles of the pipelined circuit": str(published.TABLE_II[Style.PIPELINED][8]),
            },
            timing.cycles_of_trial(Style.HYBRID, 8, lanes) < published.TABLE_II[Style.PIPELINED][8],
        ),
        Finding(
            "Six products give the same bit as the nine of Figure 6.",
            {"cycles with six": str(crossed), "cycles with nine": str(published.DETECT_CYCLES)},
            crossed < published.DETECT_CYCLES,
        ),
    )
