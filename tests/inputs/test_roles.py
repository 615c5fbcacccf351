"""Roles of a platform: what fills them, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from codesign.ground.errors import SpecError
from codesign.inputs import list_platforms, load_platform

TEXT = """kind: platform
name: own
components:
  chip: {type: fpga, part: XC7A35T-1, clock: 100 MHz}
  cpu: {type: processor, clock: 1 GHz, power: {busy: 2 W, idle: 1 W}}
  bridge: {type: processor, clock: 1 GHz, power: {busy: 2 W, idle: 1 W}}
links:
  usb: {type: ideal, between: [cpu, bridge]}
  spi: {type: ideal, between: [bridge, chip]}
  spare: {type: ideal, between: [cpu, bridge]}
"""

ASIDE = TEXT.replace("  spare: {type: ideal, between: [cpu", "  spare: {type: ideal, between: [aside").replace(
    "links:", "  aside: {type: processor, clock: 1 GHz, power: {busy: 2 W, idle: 1 W}}\nlinks:"
)


def _loaded(tmp_path: Path, text: str) -> dict[str, str]:
    file = tmp_path / "own.yaml"
    file.write_text(text, encoding="utf-8")
    return load_platform(file).filled


@pytest.mark.parametrize("name", list_platforms())
def test_every_shipped_platform_fills_its_roles(name: str) -> None:
    """A platform with an FPGA fills all three roles, in its file; another is a host alone."""
    platform = load_platform(name)
    chips = [each for each, spec in platform.components.items() if spec.type == "fpga"]
    assert set(platform.filled) == ({"fabric", "host", "link"} if chips else {"host"})
    assert {role for role, filler in platform.roles if filler is not None} == set(platform.filled)


def test_a_component_fills_the_role_of_its_name(tmp_path: Path) -> None:
    assert _loaded(tmp_path, TEXT.replace("cpu", "host")) == {"host": "host"}
    assert _loaded(tmp_path, TEXT.replace("spi", "link")) == {"link": "link"}


def test_a_link_may_lie_on_the_route(tmp_path: Path) -> None:
    text = f"{TEXT}roles: {{fabric: chip, host: cpu, link: spi}}\n"
    assert _loaded(tmp_path, text) == {"fabric": "chip", "host": "cpu", "link": "spi"}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            TEXT + "roles: {fabric: chop}\n",
            "own.yaml:11:17: roles.fabric: there is no component 'chop'\n  hint: did you mean chip",
        ),
        (
            TEXT + "roles: {fabric: cpu}\n",
            "own.yaml:11:17: roles.fabric: the fabric is a component of type fpga, and cpu is of type processor",
        ),
        (
            TEXT + "roles: {fabric: chip, host: cpu, link: spj}\n",
            "own.yaml:11:40: roles.link: there is no link 'spj'\n  hint: did you mean spi",
        ),
        (
            TEXT + "roles: {fabric: chip, host: cpu, link: chip}\n",
            "own.yaml:11:40: roles.link: chip is a component, and no link",
        ),
        (
            ASIDE + "roles: {fabric: chip, host: cpu, link: spare}\n",
            "own.yaml:12:40: roles.link: no route between cpu and chip takes link spare",
        ),
        (
            TEXT + "roles: {host: cpu, link: usb}\n",
            "own.yaml:11:26: roles.link: the platform has no fabric, so that nothing is linked",
        ),
        (
            TEXT.replace("chip", "host"),
            "own.yaml:4:3: components.host: host is the name of a role, which a component of type processor fills\n"
            "  hint: give it another name",
        ),
        (
            TEXT.replace("bridge", "host") + "roles: {host: cpu}\n",
            "own.yaml:6:3: components.host: host is the name of a role, which cpu fills",
        ),
        (TEXT.replace("spi", "fabric"), "own.yaml:9:3: links.fabric: fabric is the name of a role"),
        (TEXT + "roles: {cpu: cpu}\n", "own.yaml:11:9: roles.cpu: unknown key\n  hint: accepted: fabric, host, link"),
        (TEXT + "roles: [chip]\n", "own.yaml:11:8: roles"),
    ],
)  # fmt: skip
def test_faults_of_roles(tmp_path: Path, text: str, fault: str) -> None:
    with pytest.raises(SpecError) as error:
        _loaded(tmp_path, text)
    assert fault in str(error.value)


def test_all_faults_at_once(tmp_path: Path) -> None:
    with pytest.raises(SpecError) as error:
        _loaded(tmp_path, TEXT + "roles: {fabric: a, host: b, link: c}\n")
    assert [fault.key for fault in error.value.faults] == ["roles.fabric", "roles.host", "roles.link"]
