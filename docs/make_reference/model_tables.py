"""Headings and tables of keys from pydantic models: files, results, studies."""

from __future__ import annotations

import types
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import is_dataclass
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from codesign.ground.figures import Figure, Price, ResultFigure
from codesign.inputs.value_types import default_text, type_text
from codesign.maps import Radius
from docs.make_reference.docstrings import markdown

CHOOSERS = ("type", "generate")
"""Keys that choose one of several models."""


def cell(text: str) -> str:
    """A text as a cell of a table has it."""
    return " ".join(text.split()).replace("|", "\\|")


def sentence(text: str, kind: str = "") -> str:
    """A description with a capital letter at its beginning and a full stop at its end.

    A value that ``kind`` lists stays as it is written.
    """
    text = cell(text)
    if not text:
        return ""
    if f"`{text.split()[0].rstrip(':,')}`" not in kind:
        text = text[0].upper() + text[1:]
    return text if text.endswith(".") else f"{text}."


def table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[str]:
    """A Markdown table."""
    lines = [f"| {' | '.join(header)} |", f"|{'---|' * len(header)}"]
    return [*lines, *(f"| {' | '.join(row)} |" for row in rows)]


def fields_of(model: type) -> Mapping[str, FieldInfo]:
    """The fields of a model, or of a dataclass with annotated fields."""
    if issubclass(model, BaseModel):
        return model.model_fields
    return {name: FieldInfo.from_annotation(hint) for name, hint in get_type_hints(model, None, None, True).items()}


def models_in(annotation: Any) -> list[type]:
    """The models that a value may be made of: itself, one of several, the entries of a list or mapping."""
    is_class = isinstance(annotation, type) and annotation not in {Figure, Price, Radius}
    if annotation is ResultFigure:
        return []  # a name in files and in JSON
    if is_class and (issubclass(annotation, BaseModel) or is_dataclass(annotation)):
        return [annotation]
    return list(dict.fromkeys(model for part in get_args(annotation) for model in models_in(part)))


def _holder(annotation: Any) -> str:
    """How the models of a value are written behind its key: ``[]`` in a list, ``.NAME`` in a mapping."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _holder(arguments[0])
    if origin in {Union, types.UnionType}:
        return next((_holder(each) for each in arguments if models_in(each)), "")
    if origin is dict:
        return ".NAME"
    return "[]" if origin in {tuple, list} else ""


class Keys:
    """The tables of one page.

    Args:
        documented: models with a heading of their own on the page or on another, and the text that refers to it.
        with_defaults: whether there is a column of defaults; results have none.
    """

    def __init__(self, documented: dict[type, str], *, with_defaults: bool = True) -> None:
        self.documented = documented
        self.with_defaults = with_defaults

    def section(self, level: int, heading: str, model: type, without: Collection[str] = ()) -> list[str]:
        """Heading, docstring and keys of a model, then those of the forms that its keys choose from.

        ``without``: keys that the page has elsewhere.
        """
        forms: list[tuple[str, type]] = []
        rows = list(self._rows(model, "", forms, without))
        lines = [f"{'#' * level} {heading}", "", markdown(model.__doc__ or ""), ""]
        if rows:
            header = ("key", "type", "default", "meaning") if self.with_defaults else ("key", "type", "meaning")
            lines += [*table(header, rows), ""]
        else:
            lines += ["It has no keys.", ""]
        for key, form in forms:
            lines += self.section(min(level + 1, 6), self._form_heading(key, form), form)
        return lines

    def _form_heading(self, key: str, form: type) -> str:
        for chooser in CHOOSERS:
            if chooser in fields_of(form):
                (name,) = get_args(fields_of(form)[chooser].annotation)
                return f"`{key}` with `{chooser}: {name}`"
        return f"`{key}` with `{', '.join(fields_of(form))}`"

    def _rows(
        self, model: type, prefix: str, forms: list[tuple[str, type]], without: Collection[str] = ()
    ) -> Iterator[tuple[str, ...]]:
        for name, info in fields_of(model).items():
            if name in without or (name in CHOOSERS and not prefix and info.is_required()):
                continue
            key = f"{prefix}{name}"
            inner = models_in(info.annotation)
            known = [self.documented[each] for each in inner if each in self.documented]
            yield self._row(key, info, known)
            if known or not inner:
                continue
            inside = f"{key}{_holder(info.annotation)}"
            if len(inner) > 1:
                forms += [(inside, each) for each in inner]
            else:
                yield from self._rows(inner[0], f"{inside}.", forms)

    def _row(self, key: str, info: FieldInfo, known: list[str]) -> tuple[str, ...]:
        kind = type_text(info.annotation, tuple(info.metadata))
        meaning = sentence(info.description or "", kind)
        if known:
            meaning = f"{meaning} {known[0]}".strip()
        default = (default_text(info),) if self.with_defaults else ()
        return (f"`{key}`", cell(kind), *default, meaning)
