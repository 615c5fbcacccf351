from __future__ import annotations

import itertools
import json
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from report_samples import SampleReproduction, SampleRow, a_hopeless_study, a_result, a_study

from codesign.exploration.outcomes import Outcomes
from codesign.exploration.study import Study
from codesign.figures import FIGURES, ResultFigure
from codesign.planners.reproduction import Finding
from codesign.report import Picture, study_page
from codesign.report import chart as chart_module
from codesign.report.chart import chart_data
from codesign.report.page import reproduction_html, result_html, study_html

EVIL = "<script>alert(1)</script>\"'&</style>]]><!--"
PICTURE = Picture(EVIL, EVIL, "png", b"\x89PNG", EVIL)


class Page(HTMLParser):
    """What a browser would make of a page: elements, attributes, and the text outside of scripts."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.scripts: list[str] = []
        self._in: str | None = None
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self._in = tag if tag in {"script", "style"} else None
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._in = None

    def handle_data(self, data: str) -> None:
        if self._in == "script":
            self.scripts[-1] += data
        elif self._in is None:
            self.text += data


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
    rows = (SampleRow(EVIL, EVIL, EVIL, EVIL, None, EVIL, EVIL, EVIL, EVIL, EVIL),)
    result = a_result(platform=EVIL, workload=EVIL, part=EVIL, parameters={EVIL: {EVIL: EVIL}})
    return {
        "study": study_html(evil_study(), pictures=[PICTURE], command=EVIL),
        "result": result_html(result, pictures=[PICTURE], command=EVIL),
        "reproduction": reproduction_html(
            SampleReproduction(rows, (Finding(EVIL, {EVIL: EVIL}),), EVIL), pictures=[PICTURE], command=EVIL
        ),
    }


def data_of(html: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="study-data">(.*?)</script>', html, re.S)
    assert found
    data: dict[str, Any] = json.loads(found[1])["views"][0]
    return data


@pytest.mark.parametrize("kind", ["study", "result", "reproduction"])
def test_what_users_wrote_is_shown_not_obeyed(kind: str) -> None:
    html = evil_pages()[kind]
    page = Page(html)
    expected_scripts = 4 if kind == "study" else 0
    assert len(page.scripts) == expected_scripts
    assert "alert(1)" not in "".join(script for script in page.scripts if not script.startswith("{"))
    assert page.text.count(EVIL) >= 3
    # In a script it would hide the end of the script from a browser.
    assert "<!--" not in html


def test_data_with_markup_in_it_is_read_back_as_it_was() -> None:
    data = data_of(evil_pages()["study"])
    assert EVIL in data["axes"][-1]["levels"]
    assert f"failed: {EVIL}" in data["whys"]


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
        a["content"]
        for tag, a in page.elements
        if tag == "meta" and "Content-Security" in (a.get("http-equiv") or "")
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
            assert attributes["scope"] == "col"


def test_the_script_finds_every_element_it_looks_for() -> None:
    html = study_html(a_study())
    ids = {attributes.get("id") for _, attributes in Page(html).elements}
    script = Page(html).scripts[-1]
    wanted = set(re.findall(r'byId\("([a-z-]+)"\)', script)) | set(re.findall(r'read\("([a-z-]+)"\)', script))
    assert len(wanted) > 10
    assert wanted <= ids


def test_a_thousand_points_stay_below_two_and_a_half_megabytes(tmp_path: Path) -> None:
    study_page(a_study(1000), tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size < 2_500_000


def test_the_same_study_gives_the_same_page_but_for_the_names_inside_bokeh() -> None:
    assert chart_data(a_study()) == chart_data(a_study())
    without_plots = [re.sub(r'id="study-plots">.*?</script>', "", study_html(a_study())) for _ in range(2)]
    assert without_plots[0] == without_plots[1]


def test_the_data_of_the_page_are_the_figures_of_the_study() -> None:
    study = a_study()
    data = data_of(study_html(study))
    time = data["figures"][0]
    assert time["label"] == "first plan time (ms)"
    for value, point in zip(time["values"], study.points, strict=True):
        figure = point.figure(FIGURES["first_plan_s"])
        assert value == (None if figure is None else pytest.approx(1000 * figure, rel=1e-5))
    assert [i for i, on_front in enumerate(data["front"]) if on_front] == list(study.front)
    assert [bool(flag) for flag in data["feasible"]] == [point.feasible for point in study.points]
    block = data["axes"][0]
    assert [block["levels"][level] for level in block["level"]][:7] == ["12×22"] * 6 + ["24×44"]


def test_the_bound_of_every_pair_of_figures_is_its_front() -> None:
    study = a_study()
    data = chart_data(study)
    assert len(data["fronts"]) == 5 * 4
    for (x, first), (y, second) in itertools.permutations(enumerate(study.objectives), 2):
        points = {
            i: tuple(
                (-1 if figure.maximise else 1) * (study.points[i].figure(figure) or 0)
                for figure in (first, second)
            )
            for i in study.feasible
        }
        expected = {
            i
            for i, own in points.items()
            if not any(o != own and o[0] <= own[0] and o[1] <= own[1] for o in points.values())
        }
        places = data["fronts"][f"{x},{y}"]
        assert set(places) == expected
        along = [study.points[i].figure(first) or 0 for i in places]
        assert along == sorted(along)


def test_a_large_study_is_thinned_and_keeps_its_front(monkeypatch: pytest.MonkeyPatch) -> None:
    study = a_study(200)
    monkeypatch.setattr(chart_module, "MOST_POINTS", 120)
    data = chart_data(study)
    assert len(data["points"]) <= 120
    assert data["left_out"] == 200 - len(data["points"]) >= 80
    assert set(study.front) <= set(data["points"])
    assert data["points"] == sorted(data["points"])


def test_a_study_with_nothing_feasible_says_so_and_needs_no_plot() -> None:
    html = study_html(a_hopeless_study())
    page = Page(html)
    assert "Nothing is feasible" in page.text
    assert "block: at most 36×66 fits" in page.text
    assert "Bokeh" not in page.scripts[0]
    assert len(html) < 100_000


@pytest.mark.parametrize("objectives", [(), (FIGURES["energy_j"],), (FIGURES["first_plan_s"],)])
def test_a_plot_has_two_axes_whatever_the_objectives(objectives: tuple[ResultFigure, ...]) -> None:
    study = replace(a_study(), objectives=objectives, constraints=())
    data = data_of(study_html(study))
    assert len(data["figures"]) >= 2


def test_an_infeasible_result_says_why_before_all_else() -> None:
    text = Page(result_html(a_result(slices=40_000))).text
    assert "not feasible" in text
    assert text.index("what would close the gap") < text.index("platform")


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="no chromium to look with")
def test_a_browser_draws_the_plot_and_the_table(tmp_path: Path) -> None:
    html = study_html(a_study())
    # What the browser refuses or cannot do is written into the page, to be read below.
    probe = (
        "<script>window.faults=[];addEventListener('error',e=>faults.push(e.message));"
        "addEventListener('securitypolicyviolation',e=>faults.push(e.blockedURI));"
        "setTimeout(()=>{const c=document.getElementById('choose-colour');c.selectedIndex=5;"
        "c.dispatchEvent(new Event('change'));document.querySelector('#points tbody button').click();},1500);"
        "setTimeout(()=>{document.title='faults:'+faults.length+faults.join();},4000);</script></head>"
    )
    page = tmp_path / "page.html"
    page.write_text(html.replace("</head>", probe), encoding="utf-8")
    done = subprocess.run(
        [
            "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
            "--disable-background-networking", f"--user-data-dir={tmp_path / 'profile'}",
            "--virtual-time-budget=8000", "--dump-dom", page.as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert "<title>faults:0</title>" in done.stdout
    assert '<div id="plot"' in done.stdout
    assert 'class="bk-Figure' in done.stdout
    assert len(re.findall(r'data-place="\d+"', done.stdout)) == 18
    assert 'aria-pressed="true"' in done.stdout
