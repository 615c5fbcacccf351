"""From what pydantic finds wrong to faults with file, line, column, key, value and remedy."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from operator import itemgetter
from typing import Any, Protocol, TypeVar

from more_itertools import map_reduce
from pydantic import BaseModel, ValidationError

from codesign.ground.errors import Fault, SpecError, choose_hint, clip, show
from codesign.ground.models import NAME_PATTERN, SPEED_GRADE_PATTERN, RefusalError
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.yaml_tree import MAX_FAULTS

M = TypeVar("M", bound=BaseModel)


def validate(model: type[M], document: Document, also: Callable[[Document], list[Fault]] | None = None) -> M:
    """The document as a model.

    Args:
        model: what the document should be.
        document: the file.
        also: finds faults that need the raw document, whatever the model thinks of it.

    Raises:
        SpecError: all faults of the document, also the faults of reading it, in file order.
    """
    spec: M | None = None
    refused: list[Fault] = []
    try:
        spec = model.model_validate(document.tree, context=context_of(document))
    except ValidationError as error:
        refused = translate(error, document)
    faults = merge(document, [*refused, *(also(document) if also else ())])
    if faults or spec is None:
        raise SpecError(faults)
    return spec


def context_of(document: Document) -> dict[str, Any]:
    """The context that the validators of a document's models are given."""
    return {"document": document, **document.context}


def merge(document: Document, validated: Iterable[Fault]) -> list[Fault]:
    """Faults of reading and of validating; what validating says of places that reading spoilt is noise."""
    # What stands in no file has no place: there the key tells.
    unplaced = {(fault.file, fault.key) for fault in document.faults if fault.key and not fault.line}
    faults = [
        *document.faults,
        *(
            fault
            for fault in validated
            if (fault.line, fault.column) not in document.spoilt and (fault.file, fault.key) not in unplaced
        ),
    ]
    faults.sort(key=lambda fault: (fault.line, fault.column))
    if len(faults) > MAX_FAULTS:
        more = f"and at least {len(faults) - MAX_FAULTS} more faults"
        last = faults[MAX_FAULTS - 1]
        faults = [*faults[:MAX_FAULTS], Fault(last.file, last.line, last.column, "", more)]
    return faults


class Teller(Protocol):
    """Makes the fault at a path of a document (``Document.fault``); None where there is none to report."""

    def __call__(  # noqa: D102 - above
        self, path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False
    ) -> Fault | None: ...


Keep = Callable[[KeyPath, bool], bool]
"""True if a fault is reported: by the path of what was refused, and by True for an unknown key."""


def translate(
    error: ValidationError, document: Document, tell: Teller | None = None, keep: Keep | None = None
) -> list[Fault]:
    """The faults that a validation error stands for.

    Args:
        error: of validating the tree of ``document``.
        document: where the places are looked up.
        tell: makes the faults; by default the document does.
        keep: says which are made; by default all are.
    """
    tell = tell or document.fault
    lines = [_Line(line, *_locate(document.tree, line)) for line in error.errors(include_url=False)]
    lines = sorted(_without_noise(lines), key=lambda line: document.value_mark(line.path))
    lines = [line for line in lines if keep is None or keep(line.path, line.type in _UNKNOWN)]
    # A hint takes a search for the nearest word: what nobody will read gets none made.
    faults = [_fault(line, tell) for line in lines[: MAX_FAULTS + 1]]
    faults += [tell(line.path, line.message) for line in lines[MAX_FAULTS + 1 :]]
    # Two branches of a union, or a model and its parent, may say the same thing of the same place.
    return list(dict.fromkeys(fault for fault in faults if fault is not None))


class _Line:
    """One line of a validation error, with the path it means and the branches of unions it went through."""

    def __init__(self, line: Any, path: KeyPath, branch: tuple[KeyPath, str] | None) -> None:
        self.type: str = line["type"]
        self.value: Any = line["input"]
        self.context: dict[str, Any] = line.get("ctx", {})
        self.message: str = line["msg"]
        self.last_step: str | int | None = line["loc"][-1] if line["loc"] else None
        self.path = path
        self.branch = branch


def _locate(tree: Any, line: Any) -> tuple[KeyPath, tuple[KeyPath, str] | None]:
    """The path that the location of an error means, and its first union branch: (path of the union, branch).

    Pydantic puts the names of union branches and ``[key]`` between the steps; neither stands in the tree. Of what
    is missing, a key belongs to the path; an entry of a list that is too short does not.
    """
    path: list[str | int] = []
    branch = None
    missing = line["type"] == "missing"
    for position, step in enumerate(line["loc"]):
        last = position == len(line["loc"]) - 1
        inside = isinstance(tree, list) and isinstance(step, int) and step < len(tree)
        if inside or (isinstance(tree, dict) and step in tree):
            tree = tree[step]
            path.append(step)
        elif missing and last:
            path += [step] if isinstance(step, str) else []
        elif step != "[key]" and branch is None:
            branch = tuple(path), str(step)
    return tuple(path), branch


def _without_noise(lines: list[_Line]) -> list[_Line]:
    """Keep of each union the branch that was meant: of the right kind, with the fewest complaints."""
    kept = [line for line in lines if not line.branch and not _miscounted(line)]
    branched = ((*line.branch, line) for line in lines if line.branch)
    for union, inside in map_reduce(branched, itemgetter(0)).items():
        branches = map_reduce(inside, itemgetter(1), itemgetter(2)).values()
        begun = [branch for branch in branches if not any(_wrong_kind(line, union) for line in branch)]
        if begun:
            kept += sorted(begun, key=len)[0]
        else:
            first = next(iter(branches))[0]
            kinds = dict.fromkeys(_kind(line) for branch in branches for line in branch)
            first.type, first.context = "union", {"expected": " or ".join(filter(None, kinds))}
            kept.append(first)
    return kept


def _wrong_kind(line: _Line, union: KeyPath) -> bool:
    return line.path == union and line.type.endswith("_type")


def _miscounted(line: _Line) -> bool:
    """True if a list is called too short only because entries of it were refused."""
    return line.type == "too_short" and len(line.value) >= line.context["min_length"]


def _fault(line: _Line, tell: Teller) -> Fault | None:
    refusal, path = line.context.get("error"), line.path
    if isinstance(refusal, RefusalError):
        return tell((*path, *refusal.at), refusal.what, refusal.hint, at_key=refusal.of_key)
    if line.type in _UNKNOWN:
        word = clip(str(path[-1]), 60) if path else ""
        accepted = line.context.get("accepted")
        hint = choose_hint(word, accepted) if accepted is not None else None
        return tell(path, "unknown key", hint, at_key=True)
    if line.type == "missing" and isinstance(line.last_step, int):
        what = f"{show(line.value)} of {line.last_step} entries is too short"
        return tell(path, what, f"{line.last_step + 1} needed")
    if line.type == "missing":
        return tell(path, "missing", "add this key")
    what, hint = _explain(line)
    is_key = line.type == "string_pattern_mismatch" and bool(path) and line.value == path[-1]
    return tell(path, what, hint, at_key=is_key)


_UNKNOWN = {"unknown_key", "extra_forbidden"}

_KINDS = {
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "string": "text",
    "list": "a list",
    "tuple": "a list",
    "set": "a list",
    "dict": "a mapping",
    "model": "a mapping",
    "finite": "a finite number",
}


def _kind(line: _Line) -> str:
    return _KINDS.get(line.type.split("_")[0], "")


_BOUNDS: dict[str, tuple[str, str]] = {
    "greater_than": ("gt", "above"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "below"),
    "less_than_equal": ("le", "at most"),
}


def _explain(line: _Line) -> tuple[str, str | None]:
    shown, context = show(line.value), line.context
    if line.type in _BOUNDS:
        key, words = _BOUNDS[line.type]
        return f"{shown} is out of bounds", f"it must be {words} {context[key]}"
    for prefix, explain in _EXPLAINED.items():
        if line.type.startswith(prefix):
            return explain(line, shown)
    expected = context.get("expected") if line.type == "union" else _kind(line)
    if expected:
        return f"{shown} is not {expected}", _type_hint(line) or f"write {expected}"
    message = line.message.removeprefix("Value error, ")
    # The parser's place and key say which list or mapping; a validator's own words say the rest.
    return message if isinstance(line.value, list | dict) else f"{shown}: {message}", None


def _too_short(line: _Line, shown: str) -> tuple[str, str | None]:
    count, least = line.context.get("actual_length"), line.context.get("min_length")
    return f"{shown} of {count} entries is too short", f"at least {least} needed"


def _too_long(line: _Line, shown: str) -> tuple[str, str | None]:
    count, most = line.context.get("actual_length"), line.context.get("max_length")
    return f"{shown} of {count} entries is too long", f"at most {most} accepted"


def _choose(line: _Line, shown: str) -> tuple[str, str | None]:
    words = [word.strip(" '") for word in str(line.context["expected"]).replace(" or ", ",").split(",")]
    return f"{shown} is not accepted", choose_hint(clip(str(line.value), 60), words)


_PATTERNS = {
    NAME_PATTERN: "letters, digits, _ and -, a letter first",
    SPEED_GRADE_PATTERN: 'a dash and letters or digits, such as "-12"',
}
_EXPLAINED: dict[str, Callable[[_Line, str], tuple[str, str | None]]] = {
    "too_short": _too_short,
    "too_long": _too_long,
    "string_too_short": lambda _line, _shown: ("is empty", "write some text"),
    "string_too_long": lambda line, shown: (f"{shown} is too long", f"at most {line.context['max_length']} characters"),
    "string_pattern": lambda line, shown: (f"{shown} is not a name", _PATTERNS.get(line.context["pattern"])),
    "enum": _choose,
    "literal": _choose,
}


def _type_hint(line: _Line) -> str | None:
    value = line.value
    if line.type.startswith("bool") and isinstance(value, str):
        return "write true or false, in lower case, without quotes"
    if line.type.startswith(("int", "float")) and isinstance(value, str):
        plain = value.replace("_", "").replace(",", "").strip()
        return f"write {plain}" if plain != "" and plain.lstrip("+-").isdecimal() else None
    if line.type.startswith("int") and isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return f"write {int(value)}"
    if line.type.startswith("string") and isinstance(value, int | float):
        return "quote it"
    if line.type.startswith(("list", "tuple")) and not isinstance(value, dict):
        return _list_hint(value)
    return None


def _list_hint(value: Any) -> str:
    """A sentence that says how to write a list; with the entries, if they can be told from ``72x66`` or ``72, 66``."""
    entries = re.split(r"\s*[x×X,;*]\s*|\s+", clip(str(value), 60).strip(" ()"))
    if isinstance(value, str) and all(entry.isdecimal() for entry in entries):
        return f"write [{', '.join(entries)}]"
    return "write the entries in brackets: [first, second]"
