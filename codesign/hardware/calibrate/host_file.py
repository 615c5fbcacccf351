"""A measured host as keys of a processor, as a host file, and as JSON."""

from __future__ import annotations

import json
from dataclasses import asdict
from statistics import median
from typing import Any

from codesign.ground.figures import Figure, Status
from codesign.ground.units import format_frequency
from codesign.hardware.calibrate.host_costs import MeasuredHost
from codesign.inputs.library import HOSTS, HostFile
from codesign.system import catalog

REFERENCE = "epyc-9004"
"""The host whose costs, times a factor, stand for the kernels that were not measured."""

UNKNOWN_POWER = {key: Figure(value, "W", Status.ASSUMED, "not measured; any computer", *ends) for key, value, ends in (
    ("busy", 5.0, (0.05, 300.0)),
    ("idle", 2.0, (0.0, 200.0)),
)}  # fmt: skip
"""Of a host that is like none with a file."""

HEAD = "# Written by hwsw calibrate host. Name it in a platform: the key host of a processor.\n"


def processor_text(host: MeasuredHost) -> str:
    """The keys of a processor: cores, load, jitter and costs, as YAML."""
    disturbed = host.disturbance
    lines = [
        f"cores: {host.cores}",
        f"load: {_flow(disturbed.load)}",
        "jitter:",
        *(f"  {name}: {_flow(figure)}" for name, figure in (("median", disturbed.median), ("p99", disturbed.p99))),
        "costs:",
        *(f"  {name}: {_flow(cost)}" for name, cost in sorted(host.costs.items())),
    ]
    return "\n".join(lines) + "\n"


def host_text(host: MeasuredHost, name: str, like: str | None) -> str:
    """A host file.

    ``like``: the host that stands for what was not measured: power, clock, and kernels times a factor. None: kernels
    are of ``REFERENCE``, and the power may be any computer's.

    Raises:
        InputError: there is no such host.
    """
    other = HOSTS.find(like or REFERENCE)
    clock, power = other.clock, UNKNOWN_POWER if like is None else dict(other.power)
    if host.clock_hz is not None:
        clock = Figure(host.clock_hz, "Hz", Status.MEASURED, "as the system of the board says")
    lines = [
        "kind: host",
        f"name: {name}",
        f"description: {json.dumps(f'{host.machine}, as hwsw calibrate host measured it')}",
        f"clock: {_flow(clock, '' if host.clock_hz else f'of host {other.name}; ')}",
        processor_text(host) + _costs_of(host, other) + "power:",
        *(f"  {key}: {_flow(figure, f'of host {like}; ' if like else '')}" for key, figure in power.items()),
    ]
    return HEAD + "\n".join(lines) + "\n"


def _costs_of(host: MeasuredHost, other: HostFile) -> str:
    """The kernels that were not measured: those of another host, by the ratios of the kernels that were."""
    base = HOSTS.find(other.costs_of.host) if other.costs_of else other
    # The kernel of a style has most of its time; of others, such as a diagonal, a program on a board may have nothing.
    kernels = {style.kernel for style in catalog.architectures().values()} & host.costs.keys() & base.costs.keys()
    ratios = [1e12 * host.costs[name].value / base.costs[name].value for name in kernels]
    if not ratios or base.costs.keys() <= host.costs.keys():
        return ""
    source = f"{', '.join(sorted(kernels))} over those of {base.name}: the median; half the least, twice the most"
    factor = Figure(median(ratios), "1", Status.ASSUMED, source, min(ratios) / 2, 2 * max(ratios))
    return f"costs_of:\n  host: {base.name}\n  factor: {_flow(factor)}\n"


def host_document(host: MeasuredHost) -> dict[str, Any]:
    """A measured host for programs, with the fits and what each left on every map."""
    return {
        "machine": host.machine,
        "cores": host.cores,
        "clock_hz": host.clock_hz,
        **asdict(host.disturbance),
        "costs": {name: asdict(figure) for name, figure in host.costs.items()},
        "fits": [
            {
                "program": fit.program,
                "kernels": [*fit.costs],
                "maps": [
                    {"map": each.map, "measured_s": each.measured, "predicted_s": each.predicted}
                    | {"held_out_s": each.held_out}
                    for each in fit.residuals
                ],
            }
            for fit in host.fits
        ],
        "not_timed": dict(host.not_timed),
    }


def _flow(figure: Figure, before: str = "") -> str:
    """A figure as a line of YAML. ``before``: put before its source."""
    value, (low, high) = figure.value, figure.interval
    numbers = {"value": value} | ({} if low == high else {"low": low, "high": high})
    text = ", ".join(f"{key}: {_quantity(number, figure.unit)}" for key, number in numbers.items())
    return f"{{{text}, status: {figure.status}, source: {json.dumps(before + figure.source, ensure_ascii=False)}}}"


def _quantity(number: float, unit: str) -> str:
    """A number as platform files write it: of a cost, whole picoseconds."""
    if unit == "s":
        return f"{max(1, round(number * 1e12))} ps"
    return format_frequency(int(number)) if unit == "Hz" else f"{number:.6g}{'' if unit == '1' else f' {unit}'}"
