"""``hwsw calibrate host``."""

from __future__ import annotations

import json
from dataclasses import asdict

import click


@click.group(short_help="Measure this machine.")
def calibrate() -> None:
    """Measure what a platform file needs to know of this machine."""


@calibrate.command(short_help="What one unit of each kernel costs here.")
@click.option(
    "--seconds", type=float, default=2.0, show_default=True, help="About how long to measure in all."
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def host(seconds: float, as_json: bool) -> None:
    """Time the planners' kernels on this machine, and print them as ``costs:`` of a processor in a platform file."""
    from codesign.calibrate.host_costs import measure_host

    measured = measure_host(seconds)
    if as_json:
        click.echo(json.dumps({name: asdict(figure) for name, figure in measured.items()}, indent=2))
        return
    click.echo("costs:")
    for name, figure in measured.items():
        low, high = figure.interval
        value = {"value": f"{_ps(figure.value)} ps", "low": f"{_ps(low)} ps", "high": f"{_ps(high)} ps"}
        text = ", ".join(f"{key}: {quantity}" for key, quantity in value.items())
        click.echo(f"  {name}: {{{text}, status: measured, source: {json.dumps(figure.source)}}}")


def _ps(seconds: float) -> int:
    return max(1, round(seconds * 1e12))
