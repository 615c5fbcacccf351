"""The cheapest board that suffices, and prices that are not sure."""

from __future__ import annotations

from pathlib import Path

import pytest
from advice_boards import Run, asked, board, by_name, priced

from codesign.ground.errors import SpecError
from codesign.study import advice


def test_the_cheapest_board_is_named_and_why_not_the_next_cheaper_one(
    hwsw: Run, corridor: Path, tmp_path: Path
) -> None:
    dear = priced(board(tmp_path, "dear", 1), 90)
    fair = priced(board(tmp_path, "fair", 10, busy=20, idle=10), 40)
    poor = priced(board(tmp_path, "poor", 1000), 20)
    free = board(tmp_path, "free", 1, busy=0.5, idle=0.1)
    _, answer = asked(hwsw, corridor, [dear, fair, poor, free], "100 Hz")
    # A board without a price comes after those with one.
    assert [each["board"] for each in answer["boards"]] == ["fair", "dear", "free", "poor"]
    assert "; the nearest is poor (20 USD): a plan takes 100 ms" in answer["verdict"]
    code, answer = asked(hwsw, corridor, [dear, poor, free], "100 Hz", "--price", "50 USD")
    assert code == 3
    assert "it costs 90 USD, 40 USD more than 50 USD" in answer["verdict"]
    (short,) = by_name(answer)["free"]["shortfalls"]
    assert (short["need"], short["demand"], short["limit"]) == ("price", None, 50)


def test_a_price_that_may_be_above_the_limit_is_not_proved(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    path = board(tmp_path, "fair", 10)
    price = "{value: 40 USD, low: 30 USD, high: 55 USD, status: assumed, source: a test}"
    text = path.read_text(encoding="utf-8")
    path.write_text(f"{text}board: {{product: a product, price: {price}}}\n", encoding="utf-8")
    _, answer = asked(hwsw, corridor, [path], "100 Hz", "--price", "50 USD")
    assert "its price may be 30 USD to 55 USD" in answer["verdict"]
    assert "holds" not in answer["verdict"]
    _, answer = asked(hwsw, corridor, [path], "100 Hz", "--price", "55 USD")
    assert "holds at every value" in answer["verdict"]


def test_a_dearer_board_that_may_cost_less_is_named_with_the_price(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """Not the board that the recommended one is the computer of, and not one whose interval lies above."""
    boards = {"fair": (40, 30, 55), "near": (50, 45, 60), "far": (70, 56, 90)}
    paths = []
    for name, (value, low, high) in boards.items():
        path = board(tmp_path, name, 1)
        price = f"{{value: {value} USD, low: {low} USD, high: {high} USD, status: assumed, source: a test}}"
        text = path.read_text(encoding="utf-8")
        path.write_text(f"{text}board: {{product: a product, price: {price}}}\n", encoding="utf-8")
        paths.append(path)
    _, answer = asked(hwsw, corridor, paths, "100 Hz")
    text = "whether it is the cheapest depends on its price (30 to 55 USD), and changes at 50 USD: near suffices too"
    assert answer["recommended"] == "fair"
    assert f"; {text} (45 to 60 USD)" in answer["verdict"]
    assert "more may cost less" not in answer["verdict"]
    assert (answer["cheapest"]["state"], answer["cheapest"]["changes_at"]) == ("depends", 50)
    _, answer = asked(hwsw, corridor, [paths[0], paths[2]], "100 Hz")
    assert answer["cheapest"]["state"] == "holds"
    assert "cheapest depends" not in answer["verdict"]
    beside = priced(board(tmp_path, "pair", 1), 1, beside="raspberry-pi-4")
    _, answer = asked(hwsw, corridor, [Path("raspberry-pi-4"), beside], "1 Hz")
    assert (answer["recommended"], answer["cheapest"]["state"]) == ("raspberry-pi-4", "holds")


def test_the_price_of_the_computer_beside_a_board_is_added(tmp_path: Path) -> None:
    alone = priced(board(tmp_path, "alone", 1), 20)
    beside = priced(board(tmp_path, "pair", 1), 20, beside="raspberry-pi-4")
    prices = [each.price_usd for each in advice.boards_of([str(alone), str(beside), "raspberry-pi-4"])]
    assert prices[2] is not None
    assert prices == [20, 20 + prices[2], prices[2]]
    on_sale = advice.boards_of()
    assert len(on_sale) >= 15
    assert {each.name for each in on_sale} >= {"raspberry-pi-4", "pynq-z2", "kv260", "icebreaker"}
    assert not {each.name for each in on_sale} & {"virtex4-pci", "wavefront-array"}


PRICES = {"kind": "prices", "date": "2026-11", "prices": {"raspberry-pi-4": "70 USD", "mine": "5 USD"}}


def test_own_prices_go_before_the_declared_ones_and_bring_their_interval(tmp_path: Path) -> None:
    """Also before the price of the computer beside a board, and of a platform that is no board on sale."""
    mine = board(tmp_path, "mine", 1)
    pair = priced(board(tmp_path, "pair", 1), 20, beside="raspberry-pi-4")
    sources = [str(mine), str(pair), "raspberry-pi-4", "pynq-z2"]
    before = {each.name: each.price_usd for each in advice.boards_of(sources)}
    boards = advice.boards_of(sources, PRICES)
    assert {each.name: each.price_usd for each in boards} == before | {"mine": 5, "pair": 90, "raspberry-pi-4": 70}
    assert boards[2].price_interval_usd == (70, 70)
    with pytest.raises(SpecError, match="there is no platform 'mine'"):
        advice.boards_of(["raspberry-pi-4"], PRICES)


def test_an_answer_says_whose_the_prices_are_and_how_old(
    hwsw: Run, corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1795478400")  # 24 November 2026
    prices = tmp_path / "prices.yaml"
    prices.write_text("kind: prices\ndate: 2026-11-20\nprices: {pynq-z2: 1 USD}\n")
    boards = [Path("raspberry-pi-4"), Path("pynq-z2")]

    def remark(*more: object) -> str:
        _, answer = asked(hwsw, corridor, boards, "100 Hz", *more)
        (text,) = (text for text in answer["remarks"] if text.startswith("Prices: "))
        return str(text)

    assert remark() == "Prices: declared, of 2023, over 2 years old (2 boards); --prices FILE takes yours."
    ours = remark("--prices", prices)
    assert ours.startswith("Prices: declared, of 2023, over 2 years old (1 board); yours, of 2026-11-20 (1 board)")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")  # November 2023
    assert remark() == "Prices: declared, of 2023 (2 boards)."


def test_a_list_of_own_prices_decides_which_board_is_recommended(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    dear, fair = priced(board(tmp_path, "dear", 1), 90), priced(board(tmp_path, "fair", 10), 40)
    prices = tmp_path / "prices.yaml"
    prices.write_text("kind: prices\ndate: 2026\nprices: {dear: 30 USD}\n")
    assert asked(hwsw, corridor, [dear, fair], "100 Hz")[1]["recommended"] == "fair"
    assert asked(hwsw, corridor, [dear, fair], "100 Hz", "--prices", prices)[1]["recommended"] == "dear"
    for name, content in (("missing.yaml", None), ("empty.yaml", "")):
        if content is not None:
            (tmp_path / name).write_text(content)
        result = hwsw("advise", corridor, "--goal", "0,0", "--rate", "1Hz", "--prices", tmp_path / name)
        assert (result.exit_code, "Traceback" in result.output) == (2, False)
