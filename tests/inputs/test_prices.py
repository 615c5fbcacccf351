"""Files of prices, and the age of a price."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from codesign.ground.errors import SpecError
from codesign.ground.figures import Status, age_text, last_day
from codesign.inputs import json_schema, list_platforms
from codesign.inputs.platform import load_prices

LIST = """kind: prices
date: 2026-11
prices:
  kv260: 279 USD
  raspberry-pi-4: {value: 60 USD, low: 55 USD, high: 66 USD, date: 2026-11-20, source: a shop}
"""
DAYS = st.dates(datetime.date(1990, 1, 1), datetime.date(2090, 12, 31))


def test_a_list_of_prices_is_read(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(LIST)
    prices = load_prices(tmp_path / "mine.yaml").dated
    kv260, pi = prices["kv260"], prices["raspberry-pi-4"]
    assert (kv260.value, kv260.interval, kv260.date) == (279, (279, 279), "2026-11")
    assert (kv260.status, kv260.source) == (Status.ASSUMED, "declared in mine.yaml:4")
    assert (pi.value, pi.interval, pi.date, pi.source) == (60, (55, 66), "2026-11-20", "a shop")
    Draft202012Validator(json_schema("prices")).validate(load_prices(LIST).document.tree)
    assert load_prices({"kind": "prices", "date": 2026, "prices": {"kv260": "1 USD"}}).dated["kv260"].date == "2026"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("kv260", "kv261", "4:3: prices.kv261: there is no platform 'kv261'\n  hint: did you mean kv260?"),
        ("279 USD", "279 EUR", "4:10: prices.kv260: '279 EUR' has no unit of price\n  hint: accepted units: USD"),
        ("279 USD", "279", "4:10: prices.kv260: 279 has no unit"),
        ("279 USD", "-1 USD", "4:10: prices.kv260: '-1 USD' is negative"),
        ("low: 55", "low: 65", "raspberry-pi-4.low: 65 USD is above the value 60 USD"),
        ("2026-11-20", "2026-02-30", "raspberry-pi-4.date: '2026-02-30' is no date\n  hint: write a day, a month or"),
        ("2026-11\n", "last week\n", "2:7: date: 'last week' is no date"),
        ("date: 2026-11\n", "", "date: missing"),
        ("source: a shop", "shop: x", "prices.raspberry-pi-4.shop: unknown key\n  hint: accepted: date, high"),
        ("kind: prices", "kind: platform", "1:7: kind: this is a platform, and prices are asked for"),
        (LIST, "kind: prices\ndate: 2026\nprices: {}\n", "prices: a mapping of 0 entries is too short"),
    ],
)
def test_a_faulty_list_is_refused_at_its_place(tmp_path: Path, old: str, new: str, expected: str) -> None:
    (tmp_path / "mine.yaml").write_text(LIST.replace(old, new, 1))
    with pytest.raises(SpecError) as caught:
        load_prices(tmp_path / "mine.yaml")
    assert expected in str(caught.value)


def test_all_faults_come_at_once() -> None:
    with pytest.raises(SpecError) as caught:
        load_prices(LIST.replace("kv260", "kv261").replace("279 USD", "-1 EUR").replace("2026-11\n", "x\n"))
    assert {fault.key for fault in caught.value.faults} == {"date", "prices.kv261"}
    assert len(caught.value.faults) == 3


def test_check_and_schema_know_lists_of_prices(
    hwsw: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A platform of the user's own that is checked beside the list may have a price."""
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(
        "kind: platform\nname: my-board\ncomponents: {cpu: {type: processor, host: cortex-a72}}\n"
    )
    Path("prices.yaml").write_text(LIST.replace("kv260", "my-board"))
    assert hwsw("check", "prices.yaml").exit_code == 2
    for order in (("mine.yaml", "prices.yaml"), ("prices.yaml", "mine.yaml")):
        result = hwsw("check", *order)
        assert result.exit_code == 0, result.output
    schema: Any = json.loads(hwsw("schema", "prices").stdout)
    assert schema == json_schema("prices")


@given(DAYS, DAYS)
def test_a_price_is_called_old_only_where_it_surely_is(seen: datetime.date, today: datetime.date) -> None:
    """Of a month or a year, its last day counts: it may have been seen then."""
    day = seen.isoformat()
    for date in (day, day[:7], day[:4]):
        assert seen <= last_day(date)
        assert last_day(date).isoformat().startswith(date)
        assert not (last_day(date) + datetime.timedelta(days=1)).isoformat().startswith(date)
        years = (today - last_day(date)).days // 365
        text = age_text(date, today.isoformat())
        assert text.startswith(f"of {date}")
        assert (" old" in text) == (years >= 1)
        assert years < 1 or f"over {years} year" in text


def test_every_platform_may_have_a_price() -> None:
    tree = {"kind": "prices", "date": "2026", "prices": dict.fromkeys(list_platforms(), "10 USD")}
    assert set(load_prices(tree).dated) == set(list_platforms())
