"""The cheapest board that suffices, and prices that are not sure."""

from __future__ import annotations

from pathlib import Path

from advice_boards import Run, asked, board, by_name, priced

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
    assert "nothing cheaper does: the next, poor (20 USD), fails: a plan takes 100 ms" in answer["verdict"]
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
    assert "proved" not in answer["verdict"]
    _, answer = asked(hwsw, corridor, [path], "100 Hz", "--price", "55 USD")
    assert "proved at every value" in answer["verdict"]


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
