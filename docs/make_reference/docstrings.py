"""Docstrings and signatures as Markdown."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any

WIDTH = 100
FENCE = "```"
SECTIONS = {"Args": "Arguments", "Raises": "Raises", "Returns": "Returns", "Attributes": "Attributes"}


def markdown(docstring: str) -> str:
    """A docstring with its code, its lists of arguments and errors, and its examples as Markdown has them."""
    blocks = re.split(r"\n\s*\n", inspect.cleandoc(docstring).strip())
    return "\n\n".join(_block(block) for block in blocks)


def _block(block: str) -> str:
    lines = block.splitlines()
    if lines and lines[0].startswith(">>>"):
        return "\n".join([FENCE + "python", *lines, FENCE])
    lines = [line.replace("``", "`") for line in lines]
    title, _, rest = lines[0].partition(":") if lines else ("", "", "")
    if title in SECTIONS:
        entries = [rest.strip(), *lines[1:]] if rest.strip() else lines[1:]
        return f"{SECTIONS[title]}:\n\n" + "\n".join(_entries(entries))
    return "\n".join(lines)


def _entries(lines: list[str]) -> Iterator[str]:
    """A bullet for each entry of a section, with its continuation lines joined."""
    indent = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    entries: list[str] = []
    for line in lines:
        deeper = len(line) - len(line.lstrip()) > indent
        is_new = re.match(r"\s*\*{0,2}\w+Error:", line) or (not deeper and re.match(r"\s*\*{0,2}\w+:", line))
        if is_new or not entries:
            entries.append(line.strip())
        else:
            entries[-1] += f" {line.strip()}"
    for entry in entries:
        yield from (f"- {each}" for each in re.split(r"(?<=\.) (?=[A-Z]\w+Error: )", entry))


def signature_text(name: str, function: Callable[..., Any], *, method: bool = False) -> str:
    """``name(argument: type = default, ...) -> type``, on several lines where it is long."""
    signature = inspect.signature(function)
    parameters = list(signature.parameters.values())
    parts: list[str] = []
    for index, parameter in enumerate(parameters[1:] if method else parameters):
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in parts and not _starred(parts):
            parts.append("*")
        parts.append(_parameter(parameter))
        following = parameters[index + (2 if method else 1) :]
        if parameter.kind is parameter.POSITIONAL_ONLY and not any(
            each.kind is each.POSITIONAL_ONLY for each in following
        ):
            parts.append("/")
    returned = _annotation(signature.return_annotation)
    tail = f" -> {returned}" if returned else ""
    line = f"{name}({', '.join(parts)}){tail}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"{name}(", *(f"    {part}," for part in parts), f"){tail}"])


def _starred(parts: list[str]) -> bool:
    return any(part.startswith("*") for part in parts)


def _parameter(parameter: inspect.Parameter) -> str:
    stars = {"VAR_POSITIONAL": "*", "VAR_KEYWORD": "**"}.get(parameter.kind.name, "")
    annotation = _annotation(parameter.annotation)
    text = f"{stars}{parameter.name}" + (f": {annotation}" if annotation else "")
    if parameter.default is parameter.empty:
        return text
    function = inspect.isfunction(parameter.default)
    default = parameter.default.__name__ if function else re.sub(r"<factory>", "...", repr(parameter.default))
    return f"{text} = {default}" if annotation else f"{text}={default}"


def _annotation(annotation: Any) -> str:
    if annotation is inspect.Parameter.empty:
        return ""
    return annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
