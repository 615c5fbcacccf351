"""A request: the question that a command asks, as one object. Options, help and reference follow from its fields.

>>> from typing import Annotated
>>> class Greet(Request):
...     "Say hello to NAME."
...
...     name: Annotated[str, Argument()]
...     loud: Annotated[bool, Option("Say it loudly.")] = False
>>> GREET = Command(Greet, "greetings:greet", "Say hello.")

is the command ``hwsw greet NAME [--loud]``, and ``greet`` of the module ``greetings`` gets a ``Greet``, ``name`` and
``loud``. That module is imported when the command runs: it imports at its top what it needs, and no help loads it.

The type of a field says what its option accepts (``bool``: a flag, ``Literal``: a choice, ``tuple``: repeated,
``Path``: a file to write), and its value is the default. An option of several commands is an alias of ``Annotated``.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from inspect import cleandoc
from pathlib import Path
from typing import Any, Literal, NamedTuple, dataclass_transform, get_args, get_origin, get_type_hints

import click

SENTENCE, ANSWER, TABLES = "sentence", "answer", "tables"
"""How much a command prints: one sentence (``-q``), the answer, or the answer and all tables (``-v``)."""

OUTPUT = click.Path(dir_okay=False, path_type=Path)


def load(name: str) -> Any:
    """The object ``module:name``; its module is imported now."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)


class Option:
    """The option of a field.

    Args:
        text: its help.
        flags: by default ``--`` and the name of the field.
        parse: ``module:function`` of what was written and the option; the request has what it returns.
        more: arguments of ``click.Option``.
    """

    def __init__(self, text: str, *flags: str, parse: str = "", **more: Any) -> None:
        self.text, self.flags, self.parse, self.more = text, flags, parse, more

    def parameters(self, name: str, kind: Any, default: Any) -> list[click.Parameter]:
        """The parameters of click for a field of this type and default (``...``: required)."""
        words = _words(str if self.parse else kind, default)
        # Nothing, none and zero go without saying; other defaults that are hard to read stand in the text.
        shown = bool(words.get("default")) and "[default: " not in self.text
        words |= ({"show_default": True} if shown else {}) | self.more
        return [click.Option([name, *self._flags(name)], help=self.text, **words)]

    def read(self, name: str, written: Any) -> Any:
        """What the request has of what was written."""
        return load(self.parse)(written, self._flags(name)[0]) if self.parse else written

    def _flags(self, name: str) -> tuple[str, ...]:
        return self.flags or (f"--{name.replace('_', '-')}",)


class Argument(Option):
    """The argument of a field; a tuple takes any number."""

    def __init__(self, metavar: str | None = None, *, parse: str = "", **more: Any) -> None:
        super().__init__("", parse=parse, metavar=metavar, **more)

    def parameters(self, name: str, kind: Any, default: Any) -> list[click.Parameter]:
        """The parameters of click."""
        words = _words(kind, default)
        if words.pop("multiple", False):
            words["nargs"] = -1
        return [click.Argument([name], **({"required": default is ...} | words | self.more))]


def _words(kind: Any, default: Any) -> dict[str, Any]:
    """The arguments of a parameter that follow from the type and the default of a field."""
    kind = next((each for each in get_args(kind) if type(None) in get_args(kind)), kind)
    words: dict[str, Any] = {"required": True} if default is ... else {}
    if default not in (..., None, (), {}):
        words["default"] = default
    if get_origin(kind) is Literal:
        return words | {"type": click.Choice(get_args(kind))}
    if get_origin(kind) is tuple:
        each, *rest = get_args(kind)
        return words | _words(each, None) | ({"multiple": True} if rest == [...] else {"nargs": 1 + len(rest)})
    return words | ({"is_flag": True} if kind is bool else {"type": OUTPUT if kind is Path else kind})


class Command(NamedTuple):
    """A request, ``module:function`` of what answers it (a group has none), and its line in the list of commands."""

    request: type[Request]
    does: str
    text: str


@dataclass_transform(kw_only_default=True)
class Request:
    """The base of all requests: a field for each option and argument, in the order of the help.

    The docstring of a request is the help of its command.
    """

    def __init__(self, **given: Any) -> None:
        vars(self).update(given)

    @property
    def quiet(self) -> bool:
        """True if nothing but the answer is printed: JSON, or one sentence."""
        return bool(getattr(self, "as_json", False)) or getattr(self, "detail", "") == SENTENCE


def fields_of(request: type[Request]) -> dict[str, tuple[Any, Option]]:
    """The type and the option of each field."""
    hints = get_type_hints(request, include_extras=True)
    return {name: get_args(hints[name])[:2] for name in request.__annotations__}


def command_of(name: str, commands: Mapping[str, Command]) -> click.Command:
    """The command of that name, such as ``run``, as click runs it; ``trace show`` belongs to the group ``trace``."""
    request, does, text = commands[name]
    last = name.rpartition(" ")[2]
    words: dict[str, Any] = {"help": cleandoc(request.__doc__ or ""), "short_help": text}
    if not does:
        inner = [command_of(each, commands) for each in commands if each.startswith(f"{name} ")]
        return click.Group(last, inner, **words)
    fields = fields_of(request)

    def ask(**written: Any) -> Any:
        given = {each: value for each, value in written.items() if value not in (None, ())}
        asked = {each: fields[each][1].read(each, value) for each, value in given.items()}
        return load(f"codesign.cli.{does}")(request(**asked))

    parameters = [
        parameter
        for each, (kind, option) in fields.items()
        for parameter in option.parameters(each, kind, getattr(request, each, ...))
    ]
    return click.Command(last, callback=ask, params=parameters, **words)
