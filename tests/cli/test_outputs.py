"""Outputs that would destroy an input or one another, or that cannot be written, are refused before any work."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign.cli.outputs import check_folder, check_outputs
from codesign.ground.errors import InputError

Run = Callable[..., Result]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--html", "rooms.yaml"], "which is read"),
        (["--html", "linked.yaml"], "which is read"),
        (["--html", "new", "--trace", "new"], "is the file of --"),
        (["--html", "new", "--trace", "./sub/../new"], "is the file of --"),
        (["--html", "missing/page.html"], "does not exist"),
        (["--html", "n" * 300], "--html nnn"),
        (["--html", ""], "--html"),
        (["--trace", "pipe"], "is no regular file"),
    ],
)
def test_outputs_that_would_destroy_or_fail_are_refused_before_the_run(
    hwsw: Run, specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, words: list[str], told: str
) -> None:
    folder = specs[0].parent
    (folder / "linked.yaml").symlink_to("rooms.yaml")
    (folder / "sub").mkdir()
    os.mkfifo(folder / "pipe")
    before = specs[1].read_bytes()
    monkeypatch.setattr("codesign.simulate", lambda *_, **__: pytest.fail("the run was begun"))
    result = hwsw("run", *specs, *words)
    assert result.exit_code == 2
    assert told in result.stderr
    assert specs[1].read_bytes() == before


@pytest.mark.parametrize("words", [["--csv", "s"], ["--html", "s"], ["--csv", "s-wal"], ["--html", "board.yaml"]])
def test_an_exploration_never_overwrites_its_store_or_inputs(
    hwsw: Run, specs: tuple[Path, Path], words: list[str]
) -> None:
    result = hwsw("explore", *specs, "--store", "s", *words)
    assert result.exit_code == 2
    assert "give every output a file of its own" in result.stderr
    assert not (specs[0].parent / "s").exists()


def test_a_plot_overwrites_no_page(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="may overwrite"):
        check_folder("--plots", tmp_path, {"--html": tmp_path / "page.svg"})
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be made"):
        check_folder("--plots", tmp_path / "file" / "plots", {})
    check_folder("--plots", tmp_path / "new" / "plots", {"--html": tmp_path / "page.html"})


def test_what_is_at_hand_is_let_through(tmp_path: Path) -> None:
    check_outputs({"--csv": tmp_path / "a", "--html": tmp_path / "b"}, ["virtex4-pci"], store=("", tmp_path / "s"))
    check_outputs({"--csv": Path("/dev/null"), "--html": Path("/dev/null")})
    with pytest.raises(InputError):
        check_outputs({"--csv": tmp_path / "a", "--html": tmp_path / "a"})
