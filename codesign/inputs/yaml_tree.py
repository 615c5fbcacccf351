"""YAML text to a plain tree, with the line and column of every key and value.

Own, strict reading of PyYAML's event stream; nothing is ever constructed. What a plain scalar means stands
in ``resolve``: ``on``, ``12:30:00`` and ``2001-01-01`` are text, ``1e6`` is a number, ``010`` is refused.
Refused too, because each is more often a slip or an attack than meant: duplicate keys, keys that are no text,
anchors, aliases, merge keys, tags, directives, a second document, control characters.

What is refused does not stop the reading, so that all faults of a file come at once: only broken syntax does, and
what is out of bounds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from codesign.ground.errors import Fault, SpecError, WrittenFloat, clip, reason_of
from codesign.inputs.document import Document, KeyPath, Mark, dotted

MAX_BYTES = 2**20
MAX_DEPTH = 32
MAX_NODES = 100_000
MAX_FAULTS = 100
"""Faults reported of one file; the rest is counted."""

_FAST: Any = getattr(yaml, "CSafeLoader", None)
"""The parser of libyaml, where PyYAML was built with it. The shipped files are read 4.5 times as fast."""

_OTHERWISE = re.compile(r"[\t?]|:\s*[,}\]]|[>|][-+0-9]*#")
"""The texts that libyaml reads otherwise than PyYAML: tabs and question marks in plain text, the place of a value left
out, and a comment at the head of a block text."""

_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff\ud800-\udfff]")
_TAB_INDENT = re.compile(r"^ *\t", re.M)


def read_document(path: Path, shown: str | None = None) -> Document:
    """Read a YAML file.

    Args:
        path: the file.
        shown: what faults call it; ``path`` by default.

    Raises:
        SpecError: not a readable file, too large, not UTF-8, or no YAML. Faults in single values are kept in
            ``faults`` instead.
    """
    name = shown or str(path)
    try:
        if not path.is_file():
            kind = "is a folder" if path.is_dir() else "is not a file" if path.exists() else "does not exist"
            raise SpecError([Fault(name, 0, 0, "", kind, "name a YAML file")])
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise SpecError([Fault(name, 0, 0, "", f"cannot be read: {reason_of(error)}")]) from None
    return parse_document(content, name, path.parent)


def parse_document(content: bytes, file: str, folder: Path) -> Document:
    """Read YAML from bytes; ``read_document`` tells the rest."""
    text = _decode(content, file)
    reader, tree = _read_fast(text, file) or _read_slowly(text, file)
    return Document(file, folder, tree, reader.keys, reader.values, tuple(reader.faults), frozenset(reader.spoilt))


def _read_fast(text: str, file: str) -> tuple[_Reader, Any] | None:
    """The tree that libyaml's parser reads; None if anything is wrong with the text.

    Anything else is read by the parser in Python, which has the last word and says more of what is wrong.
    """
    reader = _Reader(file)
    if _FAST is None or _OTHERWISE.search(text):
        return None
    try:
        tree = reader.read(yaml.parse(text, Loader=_FAST))
    except (yaml.YAMLError, SpecError, ValueError, OverflowError):
        return None
    return None if reader.faults else (reader, tree)


def _read_slowly(text: str, file: str) -> tuple[_Reader, Any]:
    """The tree that the parser in Python reads; its errors have the cause and the place."""
    reader = _Reader(file)
    try:
        return reader, reader.read(yaml.parse(text, Loader=yaml.SafeLoader))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = (mark.line + 1, mark.column + 1) if mark else (0, 0)
        problem = clip(", ".join(part for part in (error.context, error.problem) if part), 160)
        fault = Fault(file, *place, "", f"not YAML: {problem}", _syntax_hint(problem))
        raise SpecError([*reader.faults, fault]) from None
    except (yaml.YAMLError, ValueError, OverflowError):
        # PyYAML lets the error of chr() out for an escape past the last character of Unicode.
        fault = Fault(file, reader.last_line, 1, "", "not YAML: an escape of no character")
        raise SpecError([*reader.faults, fault]) from None


def _decode(content: bytes, file: str) -> str:
    if len(content) > MAX_BYTES:
        what = f"is larger than {MAX_BYTES // 2**20} MiB"
        raise SpecError([Fault(file, 0, 0, "", what, "a spec is a few kB; is it the right file?")])
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        hint = "save the file as UTF-8 text"
        raise SpecError([Fault(file, line, column, "", "not UTF-8 text", hint)]) from None
    control = _CONTROL.search(text)
    if control:
        what = f"control character U+{ord(control.group()):04X}"
        raise SpecError([Fault(file, *_place(text, control.start()), "", what, "remove it")])
    tab = _TAB_INDENT.search(text)
    if tab:
        place = _place(text, tab.end() - 1)
        raise SpecError([Fault(file, *place, "", "a tab in the indentation", "indent with spaces")])
    return text


def _place(text: str, index: int) -> Mark:
    before = text[:index].replace("\r\n", "\n").replace("\r", "\n")
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def _syntax_hint(problem: str) -> str | None:
    if "'\\t'" in problem:
        return "use spaces instead of the tab"
    if "mapping values are not allowed here" in problem:
        return "indent the key under its parent, or quote a text that holds a colon"
    if "could not find expected ':'" in problem:
        return "a key is followed by a colon and a space"
    if "block end" in problem:
        return "keys of one mapping start in the same column"
    return None


class _Reader:
    """Builds tree and marks from events, without recursion."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.keys: dict[KeyPath, Mark] = {}
        self.values: dict[KeyPath, Mark] = {}
        self.faults: list[Fault] = []
        self.spoilt: set[Mark] = set()
        self.last_line = 1
        self._nodes = 0
        self._root: Any = None
        # Open containers: (path, container), and of a mapping the key that waits for its value.
        self._open: list[tuple[KeyPath, dict[str, Any] | list[Any]]] = []
        self._key: list[str | None] = []

    def read(self, events: Iterator[Any]) -> Any:
        documents = 0
        for event in events:
            self.last_line = event.start_mark.line + 1
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self._fault(event, (), "a second document", "one file holds one document")
                    break
                if event.version or event.tags:
                    self._fault(event, (), "a YAML directive", "remove the line that starts with %")
            elif isinstance(event, yaml.NodeEvent):
                self._node(event)
            elif isinstance(event, yaml.CollectionEndEvent):
                self._open.pop()
                self._key.pop()
        if not documents:
            raise SpecError([Fault(self.file, 0, 0, "", "the file is empty")])
        return self._root

    def _node(self, event: Any) -> None:
        self._nodes += 1
        if self._nodes > MAX_NODES:
            self._stop(event, f"more than {MAX_NODES:,} values", "a spec holds a few hundred")
        if self._open and isinstance(self._open[-1][1], dict) and self._key[-1] is None:
            self._refuse_references(event, self._open[-1][0])
            self._take_key(event)
            return
        path = self._next_path()
        self._refuse_references(event, path)
        self.values[path] = _mark(event)
        if isinstance(event, yaml.ScalarEvent | yaml.AliasEvent):
            self._place_value(path, self._scalar(event, path))
            return
        container: dict[str, Any] | list[Any] = {} if isinstance(event, yaml.MappingStartEvent) else []
        self._place_value(path, container)
        self._open.append((path, container))
        self._key.append(None)
        if len(self._open) > MAX_DEPTH:
            self._stop(event, f"nested more than {MAX_DEPTH} deep")

    def _refuse_references(self, event: Any, path: KeyPath) -> None:
        if isinstance(event, yaml.AliasEvent):
            self._fault(event, path, f"alias *{clip(str(event.anchor))}", "write the value out: aliases are not read")
            return
        if event.anchor is not None:
            what, hint = f"anchor &{clip(str(event.anchor))}", "remove it: anchors are not read"
            self._fault(event, path, what, hint, spoils=False)
        if event.tag is not None:
            what, hint = f"tag {clip(str(event.tag))}", "remove it; quote what is meant as text"
            self._fault(event, path, what, hint)

    def _take_key(self, event: Any) -> None:
        path, mapping = self._open[-1]
        if isinstance(event, yaml.CollectionStartEvent):
            self._stop(event, "a key that is a list or a mapping", "a key is text")
        is_alias = isinstance(event, yaml.AliasEvent)
        key: str = f"*{event.anchor}" if is_alias else event.value
        plain = not is_alias and not event.style
        if plain and key == "<<":
            self._fault(event, path, "merge key <<", "write the keys out: merge keys are not read")
        elif plain and (refusal(key) or not isinstance(resolve(key), str)):
            shown = clip(key)
            self._fault(event, path, f"key {shown!r} is not text", f'quote it: "{shown}"')
        if _CONTROL.search(key):
            self._stop(event, "a key with a control character", "remove it")
        inner = (*path, key)
        if key in mapping:
            line, column = self.keys[inner]
            what = f"key given twice, first at {line}:{column}"
            self._fault(event, inner, what, "remove one of them", spoils=False)
        self.keys[inner] = _mark(event)
        self._key[-1] = key

    def _next_path(self) -> KeyPath:
        if not self._open:
            return ()
        path, container = self._open[-1]
        step = self._key[-1] if isinstance(container, dict) else len(container)
        assert step is not None
        return (*path, step)

    def _place_value(self, path: KeyPath, value: Any) -> None:
        if not self._open:
            self._root = value
            return
        container = self._open[-1][1]
        if isinstance(container, list):
            container.append(value)
        else:
            container[str(path[-1])] = value
            self._key[-1] = None

    def _scalar(self, event: Any, path: KeyPath) -> Any:
        if isinstance(event, yaml.AliasEvent):
            return None
        text, plain = event.value, not event.style
        wrong = refusal(text) if plain else None
        if _CONTROL.search(text):
            wrong = "text with a control character", "remove the escape"
        if wrong:
            self._fault(event, path, *wrong)
            return text
        return resolve(text) if plain else text

    def _fault(self, event: Any, path: KeyPath, what: str, hint: str | None, *, spoils: bool = True) -> None:
        self.faults.append(Fault(self.file, *_mark(event), dotted(path), what, hint))
        if spoils:
            self.spoilt.add(_mark(event))
        if len(self.faults) >= MAX_FAULTS:
            raise SpecError(self.faults)

    def _stop(self, event: Any, what: str, hint: str | None = None) -> None:
        path = self._open[-1][0] if self._open else ()
        raise SpecError([*self.faults, Fault(self.file, *_mark(event), dotted(path), what, hint)])


MAX_NUMBER = 40
"""Characters of a number: enough for any exact quantity, too few to choke on."""

Scalar = str | int | float | bool | None

_BEGINS_NUMBER = "-+.0123456789"
"""Most scalars begin otherwise, and need no search."""

_INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|(?:0|[1-9][0-9]*)(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_LEADING_ZERO = re.compile(r"[-+]?0[0-9]+(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?")
_OTHER_BASE = re.compile(r"[-+]?0(?:x[0-9a-fA-F]+|o[0-7]+|b[01]+)")
_NON_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_CONSTANTS: dict[str, bool | None] = {
    "": None,
    "~": None,
    "null": None,
    "Null": None,
    "NULL": None,
    "true": True,
    "false": False,
}


def refusal(text: str) -> tuple[str, str] | None:
    """The fault of a plain scalar, and the remedy; None if it has none.

    >>> refusal("010")
    ('010 has a leading zero', "write 10, or '010' if text is meant")
    """
    if text[:1] not in _BEGINS_NUMBER:
        return None
    shown = clip(text, MAX_NUMBER)
    if _LEADING_ZERO.fullmatch(text):
        plain = re.sub(r"^([-+]?)0+(?=[0-9])", r"\1", shown)
        return f"{shown} has a leading zero", f"write {plain}, or '{shown}' if text is meant"
    if _OTHER_BASE.fullmatch(text):
        return f"{shown} is not a decimal number", "write it in decimal, or quote it as text"
    if _NON_FINITE.fullmatch(text):
        return f"{shown} is not a finite number", "write a finite number"
    if _is_number(text) and (len(text) > MAX_NUMBER or math.isinf(float(text))):
        return f"{shown} is too long or too large for a number", "write a smaller one, or quote it as text"
    return None


def resolve(text: str) -> Scalar:
    """The value of a plain scalar that has no refusal: text, int, float, bool or None.

    >>> [resolve(text) for text in ("on", "12:30:00", "1e6", "true", "True", "-3", "~")]
    ['on', '12:30:00', 1000000.0, True, 'True', -3, None]
    """
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if not _is_number(text):
        return text
    return int(text) if _INTEGER.fullmatch(text) else WrittenFloat(float(text), text)


def _is_number(text: str) -> bool:
    return text[:1] in _BEGINS_NUMBER and _FLOAT.fullmatch(text) is not None


def _mark(event: Any) -> Mark:
    return event.start_mark.line + 1, event.start_mark.column + 1
