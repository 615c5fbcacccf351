"""docs/ros2.md: its commands print what it shows, its tables name every topic, its Python runs."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'hwsw-codesign[ros2]'")

from recorded_bags import Hall, record

from codesign.views.bags import Rule
from codesign.views.bags.reading import ROLES, option_of

PAGE = (ROOT / "docs" / "ros2.md").read_text(encoding="utf-8")


def test_the_bag_of_the_page_gives_what_it_shows(
    hwsw: Callable[..., Result], capsys: pytest.CaptureFixture[str]
) -> None:
    (shown,) = re.findall(r"^```console\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    script, command, output = shown.split("\n", 2)
    assert script == "$ python tests/support/recorded_bags.py hall"
    record(Path("hall"), Hall())
    done = hwsw(*command.removeprefix("$ hwsw ").split())
    assert done.exit_code == 0, done.output
    assert [line.rstrip() for line in done.stdout.splitlines()] == output.splitlines()
    (yaml,) = re.findall(r"^```yaml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert yaml in Path("mine/hall.yaml").read_text()
    (python,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    exec(compile(python, "docs/ros2.md", "exec"), {})
    assert len(capsys.readouterr().out.splitlines()) == 9


def test_the_tables_name_every_topic() -> None:
    for role in ROLES.values():
        assert f"`/{role.usual}`" in PAGE
    for option in ("--base-frame", "--namespace", option_of("scan")):
        assert f"`{option}" in PAGE
    rule = Rule()
    assert f"`--slot` {rule.slot:g} s" in PAGE
    assert f"`--margin` {rule.margin:g} m" in PAGE
    assert f"`--radius` {rule.radius:g} m" in PAGE
    assert f"`--least` {rule.least} hits" in PAGE


def test_the_topics_of_a_run_are_those_of_the_page(hwsw: Callable[..., Result]) -> None:
    from rosbags.rosbag2 import Reader

    table = PAGE.split("| topic | type | what |")[1].split("\n\n")[0]
    listed = {
        (topic, kind.replace("/", "/msg/"))
        for topics, kind in re.findall(r"^\| (`.*?`) \| `(.*?)` \|", table, re.MULTILINE)
        for topic in re.findall(r"`(.*?)`", topics)
    }
    assert hwsw("run", "zynq", "warehouse", "--no-levers", "--ros2", "tour", "-q").exit_code == 0
    with Reader("tour") as reader:
        assert {(each.topic, each.msgtype) for each in reader.connections} == listed
