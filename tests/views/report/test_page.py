from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from html import escape
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from page_data import Page, column, data_of
from report_samples import a_hopeless_study, a_reproduction, a_result, a_study

from codesign.ground.errors import RunError
from codesign.ground.figures import FIGURES, ResultFigure, Status
from codesign.planners.reproduction import Finding, Row, Use
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.views.report import Picture, study_page
from codesign.views.report.page import Columns, template_text
from codesign.views.report.reproduction_page import reproduction_html
from codesign.views.report.result_page import result_html
from codesign.views.report.study_page import chart_data, study_html
from codesign.views.report.study_tables import study_sentence

EVIL = "<script>alert(1)</script>\"'&</style>]]><!--"
PICTURE = Picture(EVIL, EVIL, "png", b"\x89PNG", EVIL)


def evil_study() -> Study:
    study = a_study()
    outcomes = [
        point.result and point.result.model_copy(update={"platform": EVIL, "workload": EVIL})
        for point in study.points
        for _ in range(2)
    ]
    return replace(
        study,
        platform=EVIL,
        workload=EVIL,
        axes={**study.axes, "x.evil": ("mild", EVIL), f"x.{EVIL}": (EVIL,)},
        outcomes=Outcomes.of([*outcomes[:3], EVIL, *outcomes[4:]]),
    )


@cache
def evil_pages() -> dict[str, str]:
    rows = (Row(EVIL, EVIL, EVIL, EVIL, None, EVIL, Status.ASSUMED, EVIL, Use.FITTED, EVIL),)
    result = a_result(platform=EVIL, workload=EVIL, part=EVIL, parameters={EVIL: {EVIL: EVIL}})
    return {
        "study": study_html(evil_study(), pictures=[PICTURE], command=EVIL),
        "result": result_html(result, pictures=[PICTURE], command=EVIL),
        "reproduction": reproduction_html(
            [a_reproduction(paper=EVIL, rows=rows, findings=(Finding(EVIL, {EVIL: EVIL}),), note=EVIL)],
            pictures={EVIL: [PICTURE]},
            command=EVIL,
        ),
    }


@pytest.mark.parametrize("kind", ["study", "result", "reproduction"])
def test_what_users_wrote_is_shown_not_obeyed(kind: str) -> None:
    html = evil_pages()[kind]
    page = Page(html)
    expected_scripts = 3 if kind == "study" else 1
    assert len(page.scripts) == expected_scripts
    assert "alert(1)" not in "".join(script for script in page.scripts if not script.startswith("{"))
    assert page.text.count(EVIL) >= 3
    # In a script it would hide the end of the script from a browser.
    assert "<!--" not in html


def test_data_with_markup_in_it_is_read_back_as_it_was() -> None:
    data = data_of(evil_pages()["study"])
    assert EVIL in data["axes"][-1]["levels"]
    assert f"failed: {EVIL}" in column(data, data["whys"])
    assert EVIL not in "".join(Page(evil_pages()["study"]).scripts)


@pytest.mark.parametrize("kind", ["study", "result", "reproduction"])
def test_a_page_asks_for_nothing_from_outside(kind: str) -> None:
    page = Page(evil_pages()[kind])
    asking = {"src", "href", "srcset", "data", "action", "poster", "background", "formaction"}
    for tag, attributes in page.elements:
        assert tag not in {"link", "iframe", "object", "embed", "base"}
        for name in asking & set(attributes):
            assert (attributes[name] or "").startswith("data:image/")
        assert not any(name.startswith("on") for name in attributes)
    policy = next(
        a["content"] for tag, a in page.elements if tag == "meta" and "Content-Security" in (a.get("http-equiv") or "")
    )
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    assert "http" not in policy
    assert "unsafe-eval" not in policy


def test_the_style_of_a_page_loads_nothing() -> None:
    html = result_html(a_result())
    assert "@import" not in html
    assert "url(" not in html


@pytest.mark.parametrize("kind", ["study", "result", "reproduction"])
def test_a_page_can_be_read_by_all(kind: str) -> None:
    page = Page(evil_pages()[kind])
    assert ("html", {"lang": "en"}) in page.elements
    assert [tag for tag, _ in page.elements].count("h1") == 1
    for tag, attributes in page.elements:
        if tag == "img":
            assert attributes["alt"]
        if tag == "th":
            assert attributes["scope"] in {"col", "row"}


def test_the_script_finds_every_element_it_looks_for() -> None:
    html = study_html(a_study())
    ids = {attributes.get("id") for _, attributes in Page(html).elements}
    script = Page(html).scripts[-1]
    wanted = set(re.findall(r'byId\("([a-z-]+)"\)', script))
    assert len(wanted) > 10
    assert wanted <= ids


def test_a_thousand_points_stay_below_half_a_megabyte(tmp_path: Path) -> None:
    study_page(a_study(1000), tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size < 500_000


def test_the_same_study_gives_the_same_page() -> None:
    assert study_html(a_study()) == study_html(a_study())


@pytest.mark.parametrize("kind", ["float", "few", "whole", "large"])
def test_a_column_is_read_back_to_its_last_bit(kind: str) -> None:
    drawn = np.random.default_rng(1)
    odd = np.array([0.0, -0.0, math.inf, -math.inf, math.nan, 5e-324, 0.1, 1 / 3])
    numbers = {
        "float": np.concatenate([drawn.standard_normal(500), odd]),
        "few": np.repeat(odd[1:], 40),
        "whole": np.arange(300),
        "large": np.arange(70_000) * 50_000,
    }[kind]
    columns = Columns()
    columns.add(np.arange(3))
    entry = columns.add(numbers)
    again = column({"columns": columns.packed}, entry)
    assert np.array_equal(again, numbers, equal_nan=numbers.dtype.kind == "f")


def test_the_data_of_the_page_are_the_figures_of_the_study() -> None:
    study = a_study()
    data = data_of(study_html(study))
    frame = data["frames"][0]
    assert [each["key"] for each in frame["figures"][: data["main"]]] == [str(each) for each in study.objectives]
    for shown in frame["figures"][: data["main"]]:
        figure = FIGURES[shown["key"]]
        assert (shown["name"], shown["unit"], shown["maximise"]) == (figure.label, figure.unit, figure.maximise)
        values = column(data, shown["column"])
        for value, point in zip(values, study.points, strict=True):
            own = point.figure(figure)
            assert math.isnan(value) if own is None else value == own
    assert np.flatnonzero(column(data, frame["front"])).tolist() == list(study.front)
    assert column(data, frame["feasible"]).astype(bool).tolist() == [point.feasible for point in study.points]
    block = data["axes"][0]
    levels = column(data, block["level"])
    assert [block["levels"][level] for level in levels][:7] == ["12×22"] * 6 + ["24×44"]


def test_a_point_says_what_it_lacks_and_by_how_much() -> None:
    study = a_study()
    data = data_of(study_html(study))
    frame = data["frames"][0]
    whys = column(data, data["whys"])
    out = next(i for i in study.distinct if i not in study.feasible)
    reason = study.points[out].reasons[0]
    assert whys[column(data, frame["why"])[out]] == (
        f"slices {reason.demand:,} against {reason.limit:,} (gap {reason.gap:,})"
    )
    (misses,) = (each for each in frame["figures"] if each["key"] == "misses")
    gaps = column(data, misses["column"])
    assert gaps[out] == reason.gap / reason.limit
    assert np.isnan(gaps[list(study.feasible)]).all()
    # Each text stands once.
    assert len(whys) == len(set(whys))


def test_a_large_study_is_thinned_and_keeps_its_front(monkeypatch: pytest.MonkeyPatch) -> None:
    study = a_study(200)
    monkeypatch.setattr(import_module("codesign.views.report.study_page"), "MOST_POINTS", 120)
    data = chart_data(study)
    points = column(data, data["points"]).tolist()
    assert len(points) <= 120
    assert data["left_out"] == 200 - len(points) >= 80
    assert set(study.front) <= set(points)
    assert points == sorted(points)


def test_a_study_with_nothing_feasible_says_so_and_shows_what_was_tried() -> None:
    html = study_html(a_hopeless_study())
    page = Page(html)
    assert "Nothing is feasible" in page.text
    assert "block: at most 36×66 fits" in page.text
    assert "What was tried" in page.text
    data = data_of(html)
    assert not column(data, data["frames"][0]["feasible"]).any()
    assert len(html) < 200_000


@pytest.mark.parametrize("objectives", [(), (FIGURES["energy_j"],), (FIGURES["first_plan_s"],)])
def test_a_plot_has_two_axes_whatever_the_objectives(objectives: tuple[ResultFigure, ...]) -> None:
    study = replace(a_study(), objectives=objectives, constraints=())
    data = data_of(study_html(study))
    assert len(data["frames"][0]["figures"]) >= data["main"] >= 2


def test_an_infeasible_result_says_why_before_all_else() -> None:
    text = Page(result_html(a_result(slices=40_000))).text
    assert "not feasible" in text
    assert text.index("what would close the gap") < text.index("platform")


def test_a_page_that_cannot_be_written_says_so_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises(RunError, match=r"page\.html"):
        study_page(a_study(), tmp_path / "file" / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_what_is_kept_of_others_stands_with_its_version_and_licence() -> None:
    plotter, licence = (template_text(f"vendor/uPlot.{end}") for end in ("iife.min.js", "LICENSE"))
    assert plotter.startswith("/*! https://github.com/leeoniya/uPlot (v1.6.32) */")
    assert "MIT License" in licence
    for text in (plotter, template_text("vendor/uPlot.min.css")):
        assert "</" not in text.replace("</g", "")
        assert not re.search(r"\beval\(|new Function|https?://(?!github)", text)


@cache
def _pages() -> dict[str, str]:
    return {
        "study": study_html(a_study()),
        "result": result_html(a_result()),
        "reproduction": reproduction_html([a_reproduction()]),
    }


@pytest.mark.parametrize("kind", ["study", "result", "reproduction"])
def test_landmarks_have_names_of_their_own_and_what_scrolls_has_focus(kind: str) -> None:
    """A section and the region in it are two landmarks: with one name a reader cannot tell them apart."""
    page = Page(_pages()[kind])
    texts = dict(re.findall(r'<h2 id="([^"]+)">([^<]+)</h2>', _pages()[kind]))
    names = [
        attributes.get("aria-label") or texts[attributes["aria-labelledby"] or ""]
        for tag, attributes in page.elements
        if attributes.get("role") == "region" or (tag == "section" and "aria-labelledby" in attributes)
    ]
    assert len(names) == len(set(names)) > 1
    for tag, attributes in page.elements:
        if tag == "pre" or attributes.get("role") == "region":
            assert attributes["tabindex"] == "0"
            assert attributes["aria-label"]


@pytest.mark.parametrize("kind", ["study", "result", "reproduction"])
def test_narrow_tables_are_no_cards(kind: str) -> None:
    tables = re.findall(r'<table class="(cards|slim)[^"]*">\s*<thead><tr>(.*?)</tr>', _pages()[kind], re.DOTALL)
    assert {name for name, _ in tables} == {"cards", "slim"}
    for name, head in tables:
        assert (name == "slim") == (head.count("<th") <= 3)


def test_the_sentence_that_answers_comes_first() -> None:
    study = a_study()
    html = study_html(study)
    sentence = f'<p class="answer">{escape(study_sentence(study))}</p>'
    assert sentence in html
    assert html.index("</h1>") < html.index(sentence) < html.index('<ul class="counts">') < html.index("<table")


def test_a_button_is_named_by_what_stands_on_it() -> None:
    """Who speaks to a page says what is seen."""
    script = template_text("study/filters.js")
    buttons = re.findall(r'button\("([^"]+)",.*?\{ "aria-label": `([^`]+)` \}\)', script, re.DOTALL)
    assert len(buttons) >= 2
    for text, name in buttons:
        assert name.startswith(text)


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_text_on_every_shade_of_the_matrix_can_be_read(scheme: int) -> None:
    """At least 4.5 to 1 (WCAG 2.1, 1.4.3), the accent mixed over the card as the style does it."""
    colours = re.findall(r"--(card|ink|accent): #([0-9a-f]{6})", template_text("style.css"))
    of = dict(colours[3 * scheme : 3 * scheme + 3])

    def channels(name: str) -> list[float]:
        return [int(of[name][place : place + 2], 16) / 255 for place in (0, 2, 4)]

    def luminance(each: list[float]) -> float:
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in each]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    shares = re.findall(
        r"\.shade-\d+ \{ background: color-mix\(in srgb, var\(--accent\) (\d+)%", template_text("study/study.css")
    )
    assert len(shares) == 10
    for share in (int(each) / 100 for each in shares):
        mixed = [
            share * accent + (1 - share) * card
            for accent, card in zip(channels("accent"), channels("card"), strict=True)
        ]
        low, high = sorted((luminance(mixed), luminance(channels("ink"))))
        assert (high + 0.05) / (low + 0.05) >= 4.5
