from __future__ import annotations

import csv
import io
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_samples import a_study

from codesign.ground.errors import RunError
from codesign.ground.figures import FIGURES
from codesign.views.report import render_csv, render_markdown, render_text, study_table, write_csv, write_study_csv
from codesign.views.report.render import printable
from codesign.views.report.wording import Cell, Column, Table, left, words


def of_words(*texts: str) -> Table:
    return Table(texts[0], left("text"), tuple(words(text) for text in texts), notes=texts)


def parsed(table: Table) -> list[list[str]]:
    return list(csv.reader(io.StringIO(render_csv(table))))


def test_markup_is_shown_not_obeyed() -> None:
    text = render_text(of_words("[bold red]x[/bold red]", "[/]", ":smile:", "[link=http://x]y[/link]"))
    for shown in ("[bold red]x[/bold red]", "[/]", ":smile:", "[link=http://x]y[/link]"):
        assert text.count(shown) >= 2


@pytest.mark.parametrize("evil", ["\x1b[31mred", "\x1b]0;title\x07", "a\rb", "a\nb", "\u202eabc", "\x9b31m"])
def test_no_control_character_reaches_a_terminal(evil: str) -> None:
    for text in (render_text(of_words(evil), styled=False), render_markdown(of_words(evil))):
        assert not set(text.replace("\n", "")) & {"\x1b", "\x07", "\r", "\u202e", "\x9b"}
    assert "a\\nb" in render_text(of_words("a\nb"))


def test_styles_only_where_asked_for_or_on_a_terminal() -> None:
    assert "\x1b[1m" in render_text(of_words("x"), styled=True)
    assert "\x1b" not in render_text(of_words("x"))


@pytest.mark.parametrize("width", [60, 80, 120])
def test_lines_keep_to_the_width(width: int) -> None:
    table = of_words("a long sentence with many words " * 8, "x")
    lines = render_text(table, width).splitlines()
    assert max(map(len, lines)) <= width
    assert render_text(table, width).count("sentence") == 8 * 3


def test_no_number_and_no_word_is_cut_where_there_is_too_little_room() -> None:
    numbers = tuple(Cell(f"{10**12 + number:,}", number) for number in range(6))
    long = "an-identifier-of-forty-two-characters-in-all"
    columns = (*(Column(f"figure {n}", align="right") for n in range(6)), Column("name"))
    text = render_text(Table("T", columns, ((*numbers, Cell(long)),)), 40)
    for cell in (*numbers, Cell(long)):
        assert cell.text in text


def test_lines_of_a_file_are_bounded() -> None:
    assert max(map(len, render_text(of_words("word " * 100)).splitlines())) <= 160


def test_a_bar_does_not_break_a_markdown_table() -> None:
    rendered = render_markdown(of_words("a|b", "`c`", "<script>", "[x](y)", "*e*"))
    rows = rendered.splitlines()[4:9]
    assert rows == ["| a\\|b |", "| \\`c\\` |", "| &lt;script&gt; |", "| \\[x\\](y) |", "| \\*e\\* |"]


@pytest.mark.parametrize("evil", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1"])
def test_a_spreadsheet_takes_no_text_for_a_formula(evil: str) -> None:
    table = Table("T", left(evil), (words(evil),))
    for row in parsed(table):
        assert row[0].startswith("'")


@given(st.lists(st.text(max_size=12), min_size=1, max_size=5))
def test_csv_gives_back_every_text_and_no_formula(texts: list[str]) -> None:
    rows = parsed(Table("T", left("text"), tuple(words(text) for text in texts)))[1:]
    assert len(rows) == len(texts)
    for text, row in zip(texts, rows, strict=True):
        [field] = row or [""]
        assert field.removeprefix("'") == printable(text).removeprefix("'")
        assert not field.startswith(("=", "+", "-", "@"))


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=5))
def test_csv_gives_back_every_number_exactly(numbers: list[float]) -> None:
    rows = tuple((Cell("rounded", number),) for number in numbers)
    read = parsed(Table("T", (Column("n", "s"),), rows))
    assert read[0] == ["n [s]"]
    assert [float(row[0]) for row in read[1:]] == numbers


def test_absent_values_are_empty_and_truths_are_words() -> None:
    table = Table("T", left("a", "b", "c"), ((Cell("–"), Cell("x", True), Cell("y", False)),))
    assert parsed(table)[1] == ["", "yes", "no"]


def test_the_csv_of_a_study_has_every_point_and_axis(tmp_path: Path) -> None:
    study = a_study()
    write_study_csv(study, tmp_path / "study.csv")
    with (tmp_path / "study.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(study.points)
    for row, point in zip(rows, study.points, strict=True):
        time = point.figure(FIGURES["first_plan_s"])
        assert row["first_plan_s"] == ("" if time is None else repr(time))
        assert row["fpga.part"] == "XC2V6000-4"
        assert (row["why_not"] == "") == point.feasible


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "points.csv"
    path.write_text("before")

    def full(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(RunError, match="No space left"):
        write_csv(study_table(a_study()), path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["points.csv"]
    assert path.read_text() == "before"


def test_a_missing_folder_is_told(tmp_path: Path) -> None:
    with pytest.raises(RunError) as caught:
        write_csv(study_table(a_study()), tmp_path / "none" / "points.csv")
    assert caught.value.where is not None
    assert caught.value.where.endswith("points.csv")
    assert caught.value.hint


WORDS = st.text("abciterations0123456789", min_size=1, max_size=14)


@given(
    st.lists(st.tuples(st.lists(WORDS, min_size=1, max_size=3), st.booleans()), min_size=1, max_size=14),
    st.lists(st.lists(WORDS, min_size=1, max_size=6), min_size=1, max_size=14),
    st.sampled_from([40, 100, 160]),
)
def test_no_word_of_a_table_is_cut_at_any_width(
    columns: list[tuple[list[str], bool]], cells: list[list[str]], width: int
) -> None:
    table = Table(
        "T",
        tuple(Column(" ".join(name), align="right" if number else "left") for name, number in columns),
        (tuple(Cell(" ".join(cells[place % len(cells)])) for place in range(len(columns))),),
    )
    lines = render_text(table, width, styled=False).splitlines()[1:]
    shown = Counter(word for line in lines for word in line.split())
    asked = Counter(word for column in table.columns for word in column.name.split())
    asked += Counter(word for cell in table.rows[0] for word in cell.text.split())
    assert asked <= shown
    for cell, (_, number) in zip(table.rows[0], columns, strict=True):
        assert not number or any(cell.text in line for line in lines)
    # A line is as long as the longest words ask for, or fits.
    least = [
        max(map(len, (*name, *([cell.text] if number else cell.text.split()))))
        for cell, (name, number) in zip(table.rows[0], columns, strict=True)
    ]
    assert max(map(len, lines)) <= max(width, sum(least) + 3 * len(least))
