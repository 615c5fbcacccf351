"""YAML text to tree and places: the YAML 1.1 traps, the places, and what is refused and where."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.errors import SpecError, show
from codesign.inputs import yaml_tree
from codesign.inputs.yaml_tree import (
    MAX_BYTES,
    MAX_DEPTH,
    MAX_FAULTS,
    MAX_NODES,
    Document,
    parse_document,
    read_document,
)


def parse(text: str | bytes) -> Document:
    content = text if isinstance(text, bytes) else text.encode("utf-8")
    return parse_document(content, "f.yaml", Path())


def fault_text(text: str | bytes) -> str:
    """The faults, whether the reading went on after them or not."""
    try:
        return str(SpecError(parse(text).faults))
    except SpecError as stopped:
        return str(stopped)


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("true", True),
        ("false", False),
        ("True", "True"),
        ("yes", "yes"),
        ("on", "on"),
        ("Off", "Off"),
        ("n", "n"),
        ("null", None),
        ("~", None),
        ("", None),
        ("0", 0),
        ("-7", -7),
        ("+7", 7),
        ("1_000", "1_000"),
        ("1e6", 1e6),
        ("1.5e3", 1500.0),
        ("1E-2", 0.01),
        (".5", 0.5),
        ("2.", 2.0),
        ("12:30:00", "12:30:00"),
        ("2001-01-01", "2001-01-01"),
        ("0.5", 0.5),
        ("150 MHz", "150 MHz"),
        ("-12", -12),
        ("'010'", "010"),
        ('"1e6"', "1e6"),
        ('"true"', "true"),
        ("'.inf'", ".inf"),
        ("=", "="),
        ("<<", "<<"),
        ("1.2.3", "1.2.3"),
        ("0x", "0x"),
        ("|\n  two\n  lines", "two\nlines\n"),
    ],
)
def test_scalars(written: str, value: Any) -> None:
    document = parse(f"a: {written}\n")
    assert document.faults == ()
    found = document.tree["a"]
    assert found == value
    assert isinstance(found, type(value))
    assert not isinstance(found, bool) or isinstance(value, bool)
    if isinstance(found, float):
        # Shown as it was written, wherever the value went.
        assert show(found) == show(pickle.loads(pickle.dumps(found))) == written


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("010", "f.yaml:1:4: a: 010 has a leading zero\n  hint: write 10, or '010' if text is meant"),
        ("-007", "f.yaml:1:4: a: -007 has a leading zero\n  hint: write -7, or '-007' if text is meant"),
        ("00", "f.yaml:1:4: a: 00 has a leading zero\n  hint: write 0, or '00' if text is meant"),
        ("01.5", "f.yaml:1:4: a: 01.5 has a leading zero\n  hint: write 1.5, or '01.5' if text is meant"),
        ("0x1F", "f.yaml:1:4: a: 0x1F is not a decimal number\n  hint: write it in decimal, or quote it as text"),
        ("0o17", "f.yaml:1:4: a: 0o17 is not a decimal number\n  hint: write it in decimal, or quote it as text"),
        (".inf", "f.yaml:1:4: a: .inf is not a finite number\n  hint: write a finite number"),
        ("-.INF", "f.yaml:1:4: a: -.INF is not a finite number\n  hint: write a finite number"),
        (".NaN", "f.yaml:1:4: a: .NaN is not a finite number\n  hint: write a finite number"),
        ('"\\x01"', "f.yaml:1:4: a: text with a control character\n  hint: remove the escape"),
        ('"\\ud800"', "f.yaml:1:4: a: text with a control character\n  hint: remove the escape"),
    ],
)
def test_faulty_values_are_kept_as_faults(written: str, message: str) -> None:
    document = parse(f"a: {written}\nb: 1\n")
    assert [str(fault) for fault in document.faults] == [message]
    assert document.tree["b"] == 1


@pytest.mark.parametrize("written", ["1e400", "9" * 41, "0." + "1" * 100_000, "-1e999"])
def test_numbers_past_all_sense(written: str) -> None:
    (fault,) = parse(f"a: {written}\n").faults
    assert "too long or too large" in fault.what
    assert len(fault.what) < 120


def test_places() -> None:
    document = parse("# first\na: 1\nb:\n  - x\n  - {c: 2,\n     d: [3]}\n")
    assert document.tree == {"a": 1, "b": ["x", {"c": 2, "d": [3]}]}
    assert document.keys == {("a",): (2, 1), ("b",): (3, 1), ("b", 1, "c"): (5, 6), ("b", 1, "d"): (6, 6)}
    assert document.values[("a",)] == (2, 4)
    assert document.values[("b", 0)] == (4, 5)
    assert document.values[("b", 1, "d", 0)] == (6, 10)
    assert document.value_mark(("b", 1, "absent", "more")) == document.values[("b", 1)] == (5, 5)
    assert str(document.fault(("b", 1, "c"), "is wrong")) == "f.yaml:5:9: b[1].c: is wrong"


def test_columns_count_characters_not_bytes() -> None:
    assert parse("é: {ü: 1}\n").values[("é", "ü")] == (1, 8)


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_lines_end_as_they_may(ending: str) -> None:
    document = parse(ending.join(["a: 1", "b: 010", ""]))
    assert [(fault.line, fault.column) for fault in document.faults] == [(2, 4)]


def test_a_byte_order_mark_is_skipped() -> None:
    assert parse(b"\xef\xbb\xbfa: 1\n").tree == {"a": 1}


def test_duplicate_keys_name_both_places_and_do_not_stop_the_reading() -> None:
    document = parse("a: 1\nb: {c: 1, c: 2}\na: 3\nd: 010\n")
    assert [str(fault) for fault in document.faults] == [
        "f.yaml:2:11: b.c: key given twice, first at 2:5\n  hint: remove one of them",
        "f.yaml:3:1: a: key given twice, first at 1:1\n  hint: remove one of them",
        "f.yaml:4:4: d: 010 has a leading zero\n  hint: write 10, or '010' if text is meant",
    ]


@pytest.mark.parametrize("key", ["1", "-12", "1.5", "true", "null", "010", "~"])
def test_keys_are_text(key: str) -> None:
    (fault,) = parse(f"{key}: x\n").faults
    assert fault.what == f"key '{key}' is not text"
    assert fault.hint == f'quote it: "{key}"'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "f.yaml: the file is empty"),
        ("# nothing\n", "f.yaml: the file is empty"),
        ("a: &x 1", "f.yaml:1:4: a: anchor &x\n  hint: remove it: anchors are not read"),
        ("b: 1\na: *x", "f.yaml:2:4: a: alias *x\n  hint: write the value out: aliases are not read"),
        ("a: !!python/name:os.system", "a: tag tag:yaml.org,2002:python/name:os.system"),
        ("a: !x {b: 1}", "f.yaml:1:4: a: tag !x"),
        ("<<: {a: 1}", "f.yaml:1:1: merge key <<"),
        ("a: 1\n---\nb: 2", "f.yaml:2:1: a second document\n  hint: one file holds one document"),
        ("%YAML 1.1\n---\na: 1", "f.yaml:1:1: a YAML directive"),
        ("%TAG ! !x\n---\na: 1", "f.yaml:1:1: a YAML directive"),
        ("*x : 1", "f.yaml:1:1: alias *x"),
        ("? [a]\n: 1", "a key that is a list or a mapping"),
        ("a:\n\tb: 1", "f.yaml:2:1: a tab in the indentation\n  hint: indent with spaces"),
        ("a:\n  \tb: 1", "f.yaml:2:3: a tab in the indentation"),
        ("a:\t1", "hint: use spaces instead of the tab"),
        ("a: x\x00y", "f.yaml:1:5: control character U+0000"),
        ("a: 1\nb: \x1b[31m", "f.yaml:2:4: control character U+001B"),
        ("a: \u2028", "f.yaml:1:4: control character U+2028"),
        ("a: b: c", "f.yaml:1:5: not YAML: mapping values are not allowed here"),
        ("a:\n  b: 1\n c: 2", "f.yaml:3:2: not YAML"),
        ("a: [1, 2", "f.yaml:1:9: not YAML"),
        ("a: 'x", "f.yaml:1:6: not YAML"),
        ("a: `x`", "f.yaml:1:4: not YAML"),
        ('a: "\\U00110000"', "not YAML: an escape of no character"),
        (b"a: 1\nb: \xff\xfe", "f.yaml:2:4: not UTF-8 text\n  hint: save the file as UTF-8 text"),
        ("a: 1".encode("utf-16"), "f.yaml:1:1: not UTF-8 text"),
        (b"a: \xed\xa0\x80", "f.yaml:1:4: not UTF-8 text"),
    ],
)
def test_refusals(text: str | bytes, message: str) -> None:
    assert message in fault_text(text)


def test_what_is_refused_does_not_stop_the_reading() -> None:
    document = parse("a: &x {b: 010}\nc: *x\n<<: {d: 1}\ne: !!str 1\n*x : 2\na: [3]\n")
    assert [(fault.line, fault.key) for fault in document.faults] == [
        (1, "a"),
        (1, "a.b"),
        (2, "c"),
        (3, ""),
        (4, "e"),
        (5, ""),
        (6, "a"),
    ]
    assert document.tree == {"a": [3], "c": None, "<<": {"d": 1}, "e": 1, "*x": 2}
    # What was only decorated or doubled still means something; of the rest nothing more is to be said.
    assert document.spoilt == {(1, 11), (2, 4), (3, 1), (4, 4), (5, 1)}
    assert [fault.what for fault in parse("a: &x 1\n---\nb: 2\n--- \nc: 3").faults] == [
        "anchor &x",
        "a second document",
    ]


def test_faults_before_broken_syntax_are_told_with_it() -> None:
    assert [line.split(": ")[0] for line in fault_text("a: 010\na: 1\nb: [1\n").splitlines()[::2]] == [
        "f.yaml:1:4",
        "f.yaml:2:1",
        "f.yaml:4:1",
    ]


def test_size_depth_and_number_of_values_are_bounded() -> None:
    assert "is larger than 1 MiB" in fault_text(b"a" * (MAX_BYTES + 1))
    assert parse("[" * MAX_DEPTH + "]" * MAX_DEPTH).faults == ()
    assert "nested more than 32 deep" in fault_text("[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1))
    assert "nested more than 32 deep" in fault_text("[" * 500_000)
    assert "more than 100,000 values" in fault_text("[" + "1," * MAX_NODES + "1]")


def test_a_yaml_bomb_does_not_go_off() -> None:
    bomb = "a: &a [x, x]\n" + "".join(
        f"{chr(98 + i)}: &{chr(98 + i)} [*{chr(97 + i)}, *{chr(97 + i)}]\n" for i in range(20)
    )
    assert "anchor &a" in fault_text(bomb)


def test_a_file_full_of_faults_is_given_up() -> None:
    with pytest.raises(SpecError) as caught:
        parse("".join(f"k{index}: 010\n" for index in range(10_000)))
    assert len(caught.value.faults) == MAX_FAULTS


def test_what_is_no_file(tmp_path: Path) -> None:
    for path, message in [
        (tmp_path / "absent.yaml", "does not exist"),
        (tmp_path, "is a folder"),
        (tmp_path / ("x" * 5000), ""),
        (Path("/dev/zero"), "is not a file"),
        (Path("a\0b"), ""),
    ]:
        with pytest.raises(SpecError) as caught:
            read_document(path, "shown.yaml")
        assert str(caught.value).startswith("shown.yaml: ")
        assert message in str(caught.value)


FRAGMENTS = [*":-[]{},#&*!|>'\"%@`\\ \n\t?~", "\n  ", ": ", "- ", "a", "b1", "0.5", "é", "{c: d}", "[1, 2]", ">-\n  t"]


@given(texts=st.lists(st.sampled_from(FRAGMENTS), max_size=25).map("".join))
@settings(max_examples=400)
def test_the_fast_parser_reads_as_the_one_that_has_the_last_word(texts: str) -> None:
    for text in (texts, f"kind: platform\nkey: {texts}"):
        fast = outcome(text)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(yaml_tree, "_FAST", None)
            assert outcome(text) == fast


def outcome(text: str) -> object:
    try:
        return parse(text).__dict__
    except SpecError as stopped:
        return str(stopped)
