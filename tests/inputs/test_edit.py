"""Edits of a tree: what is put where, what stays shared, and where faults are reported afterwards."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.inputs.document import REMOVED, Document, KeyPath, Origin, put
from codesign.inputs.edit import with_variant
from codesign.inputs.yaml_tree import parse_document

TEXT = b"""\
a: {b: 1, c: {d: 2}}
e: [1, 2]
f: {g: 3}
"""


def document() -> Document:
    return parse_document(TEXT, "f.yaml", Path())


def by(path: KeyPath) -> Origin:
    return Origin((f"--set {'.'.join(map(str, path))}",))


def at(made: Document, *path: str | int) -> str:
    return str(made.fault(path, "is wrong"))


def test_what_no_edit_touches_is_shared_and_the_document_stays() -> None:
    before = document()
    made = put(before, {("a", "c", "d"): 5, ("h", "i"): 6}, by)
    assert made.tree == {"a": {"b": 1, "c": {"d": 5}}, "e": [1, 2], "f": {"g": 3}, "h": {"i": 6}}
    assert made.tree["f"] is before.tree["f"]
    assert before.tree == document().tree


def test_a_fault_finds_who_put_the_value() -> None:
    made = put(document(), {("a", "c"): {"d": [7]}}, by)
    assert at(made, "a", "c", "d", 0) == "--set a.c.d[0]: is wrong"
    assert at(made, "a", "b") == "f.yaml:1:8: a.b: is wrong"
    assert at(put(made, {("a", "b"): REMOVED}, by), "a", "b") == "--set a.b: is wrong"


def test_the_last_edit_around_a_value_is_where_it_comes_from() -> None:
    inner = put(document(), {("a", "c", "d"): 5}, lambda _: Origin(("inner",)))
    outer = put(inner, {("a",): {"c": {"d": 6}}}, lambda _: Origin(("outer",)))
    assert at(outer, "a", "c", "d") == "outer.c.d: is wrong"
    again = put(outer, {("a", "c", "d"): 7}, lambda _: Origin(("again",)))
    assert (at(again, "a", "c", "d"), at(again, "a", "c")) == ("again: is wrong", "outer.c: is wrong")


def test_a_value_from_another_document_is_reported_there() -> None:
    other = parse_document(b"x:\n  y: 1\n", "other.yaml", Path())
    made = put(document(), {("f", "g"): 1}, lambda _: Origin(("x", "y"), other))
    assert at(made, "f", "g") == "other.yaml:2:6: x.y: is wrong"


@pytest.mark.parametrize("path", [("e", "x"), ("a", "b", "x"), ("e", "x", "y")])
def test_a_path_through_what_is_no_mapping_is_a_fault(path: KeyPath) -> None:
    made = put(document(), {path: 1, ("f", "g"): 4}, by)
    assert made.tree["f"] == {"g": 4}
    assert [fault.hint for fault in made.faults] == ["set the whole of it"]


@given(st.lists(st.tuples(st.lists(st.sampled_from("abc"), min_size=1, max_size=3), st.integers()), max_size=6))
def test_many_edits_are_one_after_another(edits: list[tuple[list[str], int]]) -> None:
    listed: dict[KeyPath, Any] = {}
    one_by_one = Document("f", Path(), {})
    for keys, value in edits:
        listed.pop(tuple(keys), None)
        listed[tuple(keys)] = value
    for path, value in listed.items():
        one_by_one = put(one_by_one, {path: value}, by)
    at_once = put(Document("f", Path(), {}), listed, by)
    assert (at_once.tree, at_once.faults) == (one_by_one.tree, one_by_one.faults)
    assert all(at_once.origin(path) == one_by_one.origin(path) for path in listed)


def test_a_variant_is_a_merge_of_its_section() -> None:
    text = b"""\
planner: p
mapping: {t: {k: 1, l: 2}}
scenario: {type: s, in: {x: 1, y: 2}, empty: {z: 1}}
variants: {v: {mapping: {t: {k: 9}}, scenario: {in: {y: 8}, empty: {}}}}
"""
    made = with_variant(parse_document(text, "w", Path()), "v")
    assert made.tree["mapping"] == {"t": {"k": 9}}
    assert made.tree["scenario"] == {"type": "s", "in": {"x": 1, "y": 8}, "empty": {"z": 1}}
    assert at(made, "scenario", "in", "y") == "w:4:57: variants.v.scenario.in.y: is wrong"
    assert at(made, "scenario", "in", "x").endswith(" scenario.in.x: is wrong")
