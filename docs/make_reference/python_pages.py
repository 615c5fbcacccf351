"""The pages of Python names, of commands and of records."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from enum import Enum
from types import ModuleType
from typing import Any

import click
from pydantic import BaseModel

import codesign
from codesign import plugin
from codesign.cli import main as cli
from codesign.cli.requests import COMMANDS
from codesign.ground.records import RECORD_TYPES, ArrayOf, Record
from codesign.views.trace.messages import plan_of, schema_name, topic_of
from docs.make_reference.docstrings import markdown, signature_text
from docs.make_reference.model_tables import cell, sentence, table


def python_page() -> list[str]:
    """Every public name of ``codesign`` and of ``codesign.plugin``."""
    return [
        "# Python",
        "",
        "MADE",
        "",
        "## `codesign`",
        "",
        markdown(codesign.__doc__ or ""),
        "",
        *_names(codesign),
        "## `codesign.plugin`",
        "",
        markdown(plugin.__doc__ or ""),
        "",
        *_names(plugin),
    ]


def _names(module: ModuleType) -> Iterator[str]:
    for name in module.__all__:
        yield from _name(name, getattr(module, name))


def _name(name: str, value: Any) -> list[str]:
    if not inspect.isclass(value) and not inspect.isfunction(value):
        return [f"### `{name}`", "", f"`{value!r}`", ""]
    lines = [f"### `{name}`", ""]
    if inspect.isfunction(value):
        return [*lines, "```python", signature_text(name, value), "```", "", markdown(value.__doc__ or ""), ""]
    if dataclasses.is_dataclass(value):
        lines += ["```python", signature_text(name, value.__init__, method=True).removesuffix(" -> None")]
        lines += ["```", ""]
    lines += [markdown(inspect.cleandoc(value.__doc__ or "")), ""]
    if issubclass(value, Enum):
        return [*lines, ", ".join(f"`{member.value}`" for member in value), ""]
    for member, function in _methods(value):
        lines += [f"- `{member}`: {_first_paragraph(function)}"]
    return [*lines, ""] if lines[-1] else lines


def _methods(value: type) -> Iterator[tuple[str, Any]]:
    """The public methods and properties that a class has itself or from a base of this package."""
    seen: set[str] = set()
    for base in value.__mro__:
        if not base.__module__.startswith("codesign") or base in {BaseModel, object}:
            continue
        for name, member in list(vars(base).items()):
            plain = getattr(member, "__func__", member)
            target = member.fget if isinstance(member, property) else plain
            if name.startswith("_") or name in seen or not inspect.isfunction(target) or not target.__doc__:
                continue
            if not target.__module__.startswith("codesign"):
                continue
            seen.add(name)
            shown = name if isinstance(member, property) else _call(name, target, bound=plain is member)
            yield shown, target


def _call(name: str, function: Any, *, bound: bool) -> str:
    arguments = list(inspect.signature(function).parameters)
    return f"{name}({', '.join(arguments[1:] if bound else arguments)})"


def _first_paragraph(function: Any) -> str:
    return cell(markdown(inspect.cleandoc(function.__doc__ or "").split("\n\n")[0])).replace("\\|", "|")


def commands_page() -> list[str]:
    """Every command with its arguments and options."""
    known = {name: each.text for name, each in COMMANDS.items() if " " not in name}
    lines = ["# Commands", "", "MADE", "", "| command | what it does |", "|---|---|"]
    lines += [f"| [`hwsw {name}`](#hwsw-{name}) | {sentence(text)} |" for name, text in known.items()]
    lines += ["", *_exit_codes()]
    context = click.Context(cli, info_name="hwsw")
    for name in known:
        command = cli.get_command(context, name)
        assert command is not None
        lines += _command(f"hwsw {name}", command, 2)
    return lines


def _exit_codes() -> list[str]:
    return [
        "Exit codes: 0 done, 1 failed, 2 a fault of a file or of the command line, 3 nothing feasible,",
        "130 interrupted, 143 terminated. [spec.md](../spec.md#faults) says more.",
        "",
    ]


def _command(name: str, command: click.Command, level: int) -> list[str]:
    lines = [f"{'#' * level} `{name}`", "", markdown(command.help or ""), ""]
    context = click.Context(command, info_name=name)
    if isinstance(command, click.Group):
        for each in command.list_commands(context):
            inner = command.get_command(context, each)
            assert inner is not None
            lines += _command(f"{name} {each}", inner, level + 1)
        return lines
    pieces = command.collect_usage_pieces(context)
    lines += ["```text", f"{name} {' '.join(pieces)}".rstrip(), "```", ""]
    options = [_option(each, context) for each in command.params if isinstance(each, click.Option)]
    return [*lines, *table(("option", "default", "meaning"), options), ""] if options else lines


def _option(option: click.Option, context: click.Context) -> tuple[str, str, str]:
    names = " ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    value = "" if option.is_flag or option.count else f" `{option.make_metavar(context)}`"
    meaning, _, said = (option.help or "").replace("``", "`").removesuffix("]").partition("  [default: ")
    return cell(f"{names}{value}"), said or _default(option), sentence(meaning)


def _default(option: click.Option) -> str:
    if isinstance(option.show_default, str):
        return option.show_default
    if option.is_flag or option.multiple or not isinstance(option.default, str | int | float):
        return ""
    return f"`{option.default}`"


def trace_page() -> list[str]:
    """Every record of a trace, its topic and its fields."""
    lines = ["# Records of a trace", "", "MADE", ""]
    lines += [
        "`SOURCE` is the name of the component or link that writes the record. Every record also has `time` (ps) and",
        "`source`. [traces.md](../traces.md) says how records are encoded and how to read them.",
        "",
    ]
    rows = []
    for name, record in RECORD_TYPES.items():
        rows.append((f"[`{name}`](#{name.lower()})", f"`{_topic(record)}`", f"`{schema_name(record)}`"))
    lines += [*table(("record", "topic", "schema"), rows), ""]
    shared = {field.name for field in dataclasses.fields(Record)}
    for name, record in RECORD_TYPES.items():
        lines += [f"## `{name}`", "", markdown(record.__doc__ or ""), ""]
        arrays = {plan.name: plan.array for plan in plan_of(record)}
        fields = [each for each in dataclasses.fields(record) if each.name not in shared]
        shown = [(f"`{each.name}`", _field_type(each.type, arrays[each.name]), _field_default(each)) for each in fields]
        lines += [*table(("field", "type", "default"), shown), ""]
    return lines


def _topic(record: type[Record]) -> str:
    return topic_of(record, "SOURCE")


def _field_type(annotation: Any, array: ArrayOf | None) -> str:
    if array is None:
        return f"`{annotation}`".replace("|", "\\|")
    return f"{array}{', or None' if str(annotation).endswith('None') else ''}"


def _field_default(field: dataclasses.Field[Any]) -> str:
    return "" if field.default is dataclasses.MISSING else f"`{field.default}`"
