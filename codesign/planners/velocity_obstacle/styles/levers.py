"""The levers that make a circuit fit: other units, other styles, other parts, each tried by the laws."""

from __future__ import annotations

from codesign.ground.figures import Status
from codesign.ground.models import Part
from codesign.planners.job import Lever, Line, part_lever, short_resources, sum_by_resource
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.published import PAPER, Style
from codesign.planners.velocity_obstacle.styles import resources
from codesign.planners.velocity_obstacle.styles.resources import items
from codesign.planners.velocity_obstacle.styles.timing import cycles_of_trial


def totals(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> dict[str, int]:
    """Demand by resource."""
    return sum_by_resource(items(style, robots, parameters, part))


def shortages(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> dict[str, int]:
    """The demand for each resource that the part lacks."""
    return short_resources(items(style, robots, parameters, part), part)


def widest_lanes(robots: int, parameters: AvoidParameters, part: Part) -> AvoidParameters | None:
    """The numbers of units that fit the part and take the fewest cycles; None: not even one of each kind fits."""
    best: tuple[int, int, AvoidParameters] | None = None
    for update in range(1, robots + 1):
        for detect in range(1, robots):
            tried = parameters.model_copy(update={"update_units": update, "detect_units": detect})
            if shortages(Style.HYBRID, robots, tried, part):
                break
            cycles = cycles_of_trial(Style.HYBRID, robots, tried)
            if best is None or (cycles, update + detect) < best[:2]:
                best = cycles, update + detect, tried
    return None if best is None else best[2]


def resource_levers(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> dict[str, tuple[Lever, ...]]:
    """For each resource that the part lacks: the units, style, robots and part that remedy it."""
    missing = shortages(style, robots, parameters, part)
    if not missing:
        return {}
    shared = [*_unit_levers(style, robots, parameters, part), *_style_levers(style, robots, parameters, part)]
    most = _most_robots(style, robots, parameters, part)
    if most is not None:
        shared.append(Lever("problem.robots", f"at most {most} fit {part.name} in style {style}"))
    return {kind: (*shared, part_lever(kind, need)) for kind, need in missing.items()}


def array_bound(parameters: AvoidParameters, part: Part) -> Line:
    """Speeds × directions ≤ words of a block RAM, one array for each component."""
    words = parameters.speeds * parameters.directions
    _, depth = resources.array_rams(parameters, part)
    most = depth // parameters.directions
    narrower = Lever("avoid.speeds", f"at most {most} with these directions", axes={"avoid.speeds": most})
    return Line.bound(
        name="velocities of the array",
        demand=words,
        limit=depth,
        unit="words",
        status=Status.ASSUMED,
        source=f"block RAM of {part.name}, the shape that is deep enough",
        levers=() if words <= depth else (narrower,),
    )


def unit_bounds(style: Style, parameters: AvoidParameters) -> tuple[Line, ...]:
    """One unit of each kind where one datapath does all: a larger given number would change nothing."""
    if style is not Style.SEQUENTIAL:
        return ()
    counts = {"update_units": parameters.update_units, "detect_units": parameters.detect_units}
    return tuple(
        Line.bound(
            name=f"{name} of the sequential style",
            demand=count,
            limit=1,
            unit="units",
            status=Status.PUBLISHED,
            source=f"{PAPER}, section III: one datapath does the work of either unit in turn",
            levers=(
                Lever(f"avoid.{name}", "1, or left out", axes={f"avoid.{name}": 1}),
                Lever(
                    "avoid.style",
                    f"{Style.PIPELINED} or {Style.HYBRID} can have more",
                    axes={"avoid.style": str(Style.PIPELINED)},
                ),
            ),
        )
        for name, count in counts.items()
        if count is not None and count > 1
    )


def _unit_levers(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> list[Lever]:
    """Fewer units of the same style."""
    if style is not Style.HYBRID:
        return []
    lanes = widest_lanes(robots, parameters, part)
    if lanes is None:
        return []
    cycles = cycles_of_trial(style, robots, lanes)
    fits = f"fit {part.name}, {cycles} cycles a trial in place of {cycles_of_trial(style, robots, parameters)}"
    text = f"{lanes.update_units}, with {lanes.detect_units} detect_units, {fits}"
    axes = {"avoid.update_units": lanes.update_units, "avoid.detect_units": lanes.detect_units}
    return [Lever("avoid.update_units", text, axes=axes)]


def _style_levers(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> list[Lever]:
    """Another style, with its published units."""
    plain = parameters.model_copy(update={"update_units": None, "detect_units": None})
    style_levers = []
    for other in (Style.PIPELINED, Style.SEQUENTIAL):
        if other is not style and not shortages(other, robots, plain, part):
            cycles = cycles_of_trial(other, robots, plain)
            text = f"{other} fits {part.name}, {cycles} cycles a trial"
            style_levers.append(Lever("avoid.style", text, axes={"avoid.style": str(other)}))
    return style_levers


def _most_robots(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> int | None:
    fitting = [n for n in range(2, robots) if not shortages(style, n, parameters, part)]
    return max(fitting, default=None)
