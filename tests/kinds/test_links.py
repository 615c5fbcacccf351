"""Every registered kind of link: one law is simulated, priced, bounded, told in terms, and seen by every view.

A kind is drawn from the fields of its model, so one that is added is held to all of this without a word here.
"""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path
from typing import Any

import kinds
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from search_boxes import check_boxes

import codesign
from codesign.ground.errors import SpecError
from codesign.inputs import exploration
from codesign.inputs.links import LINKS, AnyLink
from codesign.laws import as_sum, symbol
from codesign.study import explore
from codesign.study.check import check_points

FREE = {"type", "between", "errors", "outages"}
"""Keys that every link has: tests of links hold what they do."""

CONTENDED = {"arbitration", "fifo_depth"}
"""Keys that move a message where another one, or the sender's next, waits: tests of bus and serial line hold what."""

OTHERS: list[Any] = [1, 1.5, 2, 5, 7, "none", "even", "odd"]
"""Other values of keys that are no figures; a key takes some of them."""

pytestmark = pytest.mark.parametrize("name", LINKS)


def prices(name: str) -> list[str]:
    """The keys of the law of a kind that are prices."""
    model = kinds.platform(kinds.link(name)).links["line"]
    return list(model.law.prices(model))


def seconds(declared: dict[str, Any]) -> float:
    return simulated(declared).task.plan_time_mean_s


def simulated(declared: dict[str, Any], **more: Any) -> Any:
    return codesign.simulate(kinds.platform(declared), kinds.workload(), **more)


def test_what_is_simulated_is_what_is_priced(name: str) -> None:
    declared = kinds.link(name)
    axes: dict[str, Any] = {"fpga.clock": ["10 MHz", "45 MHz"]}
    axes |= {f"line.{key}": [declared[key][end] for end in ("value", "low", "high")] for key in prices(name)}
    study = explore(kinds.platform(declared), kinds.workload(axes), workers=1)
    assert study.simulations == 1, "all points but one are priced"
    checked = check_points(study, 20)
    assert checked.points > 1
    assert checked.differences == ()


@settings(max_examples=10)
@given(data=st.data())
def test_the_interval_of_the_terms_holds_every_value(name: str, data: st.DataObject) -> None:
    declared = kinds.link(name)
    low, high = simulated(declared).terms.interval("plan_time_mean_s")
    ends = {key: data.draw(st.sampled_from(["low", "value", "high"]), label=key) for key in prices(name)}
    for key, end in ends.items():
        declared = kinds.with_value(declared, key, declared[key][end])
    assert low <= seconds(declared) * (1 + 1e-9)
    assert seconds(declared) * (1 - 1e-9) <= high


def test_the_interval_moves_with_every_price(name: str) -> None:
    whole = simulated(kinds.link(name)).terms
    assert not whole.open
    for key in prices(name):
        declared = kinds.link(name)
        pinned = declared | {key: declared[key]["value"]}
        assert simulated(pinned).terms.interval("plan_time_mean_s") != whole.interval("plan_time_mean_s"), key


def test_no_bound_exceeds_a_value(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Branch and bound proves the front of the enumeration, and every box that it leaves out keeps its bound."""
    monkeypatch.setattr(exploration, "ENUMERATED", 0)
    declared = kinds.link(name)
    axes: dict[str, Any] = {"fpga.clock": ["10 MHz", "25 MHz", "50 MHz"]}
    axes |= {f"line.{key}": [declared[key][end] for end in ("low", "value", "high")] for key in prices(name)}
    board, work = kinds.platform(declared), kinds.workload(axes)
    whole = explore(board, work, workers=1)
    bound = explore(board, work, workers=1, search="bound")
    assert bound.search is not None
    assert bound.search.proved
    assert bound.front == whole.front
    trace = bound.search.traces[0]
    check_boxes(whole, trace)
    assert trace.excluded or not prices(name)


@given(bits=st.integers(1, 10**6), data=st.data())
def test_symbols_numbers_and_directions_are_of_one_law(name: str, bits: int, data: st.DataObject) -> None:
    model: AnyLink = kinds.platform(kinds.link(name)).links["line"]
    keys = model.law.prices(model)
    values = {key: data.draw(st.integers(1, 10**4), label=key) for key in keys}
    time = as_sum(model.law.of(model, symbol).ticks(bits) / model.law.of(model, symbol).rate())

    def at(values: dict[str, int]) -> float:
        law = model.law.of(model, values.__getitem__)
        return float(law.ticks(bits) / law.rate())

    assert math.isclose(time.at(values), at(values), rel_tol=1e-12)
    for key, sign in model.directions().items():
        more = values | {key: values[key] + data.draw(st.integers(1, 100))}
        assert sign * (at(values) - at(more)) >= -1e-12 * at(values)


def test_twice_its_lever_halves_the_time_of_every_message(name: str) -> None:
    model: AnyLink = kinds.platform(kinds.link(name)).links["line"]
    key, whole = model.law.lever(model), model.law.whole(model)
    assert bool(key) == (whole.ticks(100) > 0)
    if key:
        twice = model.law.of(model, lambda own: getattr(whole, own) * (1 + (own == key)))
        assert twice.ticks(100) / twice.rate() == whole.ticks(100) / whole.rate() / 2


def others_of(name: str, key: str) -> list[Any]:
    """Other values of a key that its kind takes."""
    declared, kind = kinds.link(name), LINKS[name]
    if key == "power":
        return [{"busy": "3 W", "idle": "1 W"}]
    if kinds.is_figure(kind, key):
        return [declared[key]["low"], declared[key]["high"]]
    return [value for value in OTHERS if kinds.taken(kind, key, value)]


def test_every_key_is_a_price_or_moves_what_is_computed(name: str) -> None:
    before = simulated(kinds.link(name))
    for key in LINKS[name].model_fields.keys() - FREE - CONTENDED:
        moved = []
        for value in others_of(name, key):
            try:
                after = simulated(kinds.link(name) | {key: value})
            except SpecError:
                continue
            moved.append((after.task, after.energy) != (before.task, before.energy))
        # A key with one accepted value, such as the start bits of a frame, has nothing to move.
        assert any(moved) or len(moved) == 1, f"{key} moves neither time nor energy"


def test_every_key_reads_as_it_is_written(name: str) -> None:
    for key in LINKS[name].model_fields.keys() - FREE - {"power"}:
        read = []
        for value in [] if kinds.is_figure(LINKS[name], key) else others_of(name, key):
            with suppress(SpecError):
                read.append(getattr(kinds.platform(kinds.link(name) | {key: value}).links["line"], key) == value)
        assert all(read), key


def test_links_with_and_without_power_are_not_priced_together(name: str) -> None:
    declared = kinds.link(name)
    quiet = {key: value for key, value in declared.items() if key != "power"}
    with_power, without = (kinds.platform(each).links["line"].shape() for each in (declared, quiet))
    assert with_power != without
    louder = declared | {"power": {"busy": "3 W", "idle": "1 W"}}
    assert kinds.platform(louder).links["line"].shape() == with_power


def test_every_view_shows_it(name: str, tmp_path: Path, hwsw: Any) -> None:
    trace = tmp_path / "run.mcap"
    result = simulated(kinds.link(name), trace=trace)
    assert result.links["line"].sent > 0
    for arguments in (("trace", "show", trace), ("trace", "stats", trace)):
        assert "line" in hwsw(*arguments).stdout
    export = {option: tmp_path / f"run{option}" for option in ("--perfetto", "--vcd", "--html")}
    done = hwsw("trace", "export", trace, *(part for pair in export.items() for part in pair))
    assert done.exit_code == 0, done.output
    for path in export.values():
        assert b"line" in path.read_bytes()
