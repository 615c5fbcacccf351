"""The tables of ``docs/boards.md``: every shipped board with its part, and every host."""

from __future__ import annotations

from pathlib import Path

from codesign.ground.figures import Figure, Status
from codesign.ground.units import format_count, format_frequency, format_power
from codesign.inputs import list_platforms, load_platform
from codesign.inputs.components import FpgaComponent, ProcessorComponent
from codesign.inputs.library import HOSTS, PARTS, HostFile, name_and_grade
from codesign.inputs.platform import Platform
from docs.make_reference.model_tables import table

PAGE = Path(__file__).parent.parent / "boards.md"
MARK = "<!-- The tables below are made by `make docs`. -->"

ASSUMED = " (a)"


def boards_page() -> str:
    """The page as it is, with its tables made again."""
    before, mark, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
    return "\n".join([f"{before}{mark or MARK}", "", *_tables()]).strip() + "\n"


def _tables() -> list[str]:
    platforms = [load_platform(name) for name in list_platforms()]
    boards = [platform for platform in platforms if platform.board is not None and _fabric(platform)]
    header = (
        "platform",
        "part",
        "LUT",
        "flip-flops",
        "block RAMs",
        "multipliers",
        "clock",
        "host",
        "link",
        "price",
        "idle at the plug",
    )
    hosts = (
        "host",
        "clock",
        "a unit takes, against epyc-9004",
        "power of the processor, busy / idle",
        "by itself, as platform",
        "price",
        "idle at the plug",
    )
    return [
        "## Boards with an FPGA",
        "",
        *table(header, [_board_row(platform) for platform in boards]),
        "",
        "## Hosts",
        "",
        *table(hosts, [_host_row(HOSTS.find(name), platforms) for name in sorted(HOSTS.names())]),
    ]


def _fabric(platform: Platform) -> FpgaComponent | None:
    component = platform.components.get(platform.filled.get("fabric", ""))
    return component if isinstance(component, FpgaComponent) else None


def _board_row(platform: Platform) -> tuple[str, ...]:
    fpga = _fabric(platform)
    assert fpga is not None, "boards have one"
    host = platform.components[platform.filled["host"]]
    assert isinstance(host, ProcessorComponent), "so says the role"
    file = PARTS.find(name_and_grade(fpga.part)[0])
    resources = file.resources
    luts = resources.lut4 if resources.lut6 is None else resources.lut6
    assert luts is not None, "a part has either"
    kind = "LUT4" if resources.lut6 is None else "LUT6"
    return (
        f"`{platform.name}`",
        fpga.part,
        f"{_count(luts, f' {kind}')}",
        _count(resources.flip_flops),
        " + ".join(
            [_count(resources.block_rams), *(_count(ram.count, f" {kind}") for kind, ram in file.other_rams.items())]
        ),
        _count(resources.multipliers),
        _marked(format_frequency(fpga.clock.value), fpga.clock),
        host.host or "",
        platform.links[platform.filled["link"]].type,
        _price(platform),
        _plug(platform),
    )


def _host_row(host: HostFile, platforms: list[Platform]) -> tuple[str, ...]:
    alone = [
        platform
        for platform in platforms
        if not _fabric(platform)
        and any(
            isinstance(component, ProcessorComponent) and component.host == host.name
            for component in platform.components.values()
        )
    ]
    measured = any(cost.status is Status.MEASURED for cost in host.costs.values())
    factor = "measured: 1" if measured else "its own, as of its paper"
    if host.costs_of is not None:
        low, high = host.costs_of.factor.interval
        factor = _marked(f"{host.costs_of.factor.value:g} times, {low:g} to {high:g}", host.costs_of.factor)
    watts = (_marked(format_power(figure.value), figure) for figure in (host.power.busy, host.power.idle))
    return (
        host.name,
        _marked(format_frequency(host.clock.value), host.clock),
        factor,
        " / ".join(watts),
        ", ".join(f"`{platform.name}`" for platform in alone) or "",
        ", ".join(_price(platform) for platform in alone),
        ", ".join(filter(None, map(_plug, alone))),
    )


def _price(platform: Platform) -> str:
    price = platform.board.price if platform.board is not None else None
    return "unknown" if price is None else _marked(f"{price.value:,g} USD", price) + f", {price.date}"


def _plug(platform: Platform) -> str:
    power = platform.board.power if platform.board is not None else None
    return "" if power is None else _marked(format_power(power.idle.value), power.idle)


def _count(figure: Figure, kind: str = "") -> str:
    return _marked(f"{format_count(int(figure.value))}{kind}", figure)


def _marked(text: str, figure: Figure) -> str:
    return text + ASSUMED * (figure.status is Status.ASSUMED)
