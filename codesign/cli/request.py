"""A request: the question that a command asks, as one object. Options, help and reference follow from its fields.

>>> class Greet(Request):
...     "Say hello to NAME."
...
...     name: str = argument()
...     loud: bool = option("Say it loudly.")
...     times: int = option("Say it so often.", "--times N", default=1)
>>> GREET = Command(Greet, "greetings:greet", "Say hello.")

is the command ``hwsw greet NAME [--loud] [--times N]``. ``greet`` of the module ``greetings`` gets a ``Greet``. That
module is imported when the command runs: it imports at its top what it needs, and no help loads it.

The type of a field says what its option accepts (``bool``: a flag, ``Literal``: a choice, ``tuple``: repeated,
``Path``: a file to write). Without a default the value is None or False if the type has it, and else it is required.
Options of several commands are a base class of their requests, or a constant.
"""

from __future__ import annotations

from collections.abc import Mapping
from inspect import cleandoc
from pathlib import Path
from typing import Any, Literal, NamedTuple, dataclass_transform, get_args, get_origin, get_type_hints

import click

from codesign.ground.late import load

SENTENCE, ANSWER, TABLES = "sentence", "answer", "tables"
"""The amount that a command prints: one sentence (``-q``), the answer, or the answer and all tables (``-v``)."""

OUTPUT = click.Path(dir_okay=False, path_type=Path)


class Option:
    """The option of a field; see ``option``."""

    def __init__(self, text: str, *flags: str, default: Any = None, parse: str = "", **more: Any) -> None:
        *others, last = flags or ("",)
        last, _, metavar = last.partition(" ")
        self.text, self.default, self.parse = text, default, parse
        self.flags, self.more = (*others, last), {"metavar": metavar or None} | more

    def default_of(self, kind: Any) -> Any:
        """The default of a field of this type; ``...`` if it is required."""
        if self.default is not None or type(None) in get_args(kind):
            return self.default
        return False if kind is bool else ...

    def parameters(self, name: str, kind: Any) -> list[click.Parameter]:
        """The parameters of click for a field of this type."""
        words = _words(str if self.parse else kind, self.default_of(kind))
        # Nothing, none and zero go without saying; other defaults that are hard to read stand in the text.
        shown = bool(words.get("default")) and "[default: " not in self.text
        words |= ({"show_default": True} if shown else {}) | self.more
        return [click.Option([name, *self._flags(name)], help=self.text, **words)]

    def read(self, name: str, written: Any) -> Any:
        """The value that the request has of what was written."""
        return load(self.parse)(written, self._flags(name)[0]) if self.parse else written

    def _flags(self, name: str) -> tuple[str, ...]:
        return self.flags if self.flags[0] else (f"--{name.replace('_', '-')}",)


class Argument(Option):
    """The argument of a field; a tuple takes any number."""

    def parameters(self, name: str, kind: Any) -> list[click.Parameter]:
        """The parameters of click."""
        default = self.default_of(kind)
        words = _words(kind, default)
        if words.pop("multiple", False):
            words["nargs"] = -1
        return [click.Argument([name], **({"required": default is ...} | words | self.more))]


def option(text: str, *flags: str, default: Any = None, parse: str = "", **more: Any) -> Any:
    """A field that is an option.

    Args:
        text: its help.
        flags: by default ``--`` and the name of the field; the last one may have a metavar: ``--points N``.
        default: None: None or False if the type of the field has it, and else it is required.
        parse: ``module:function`` of what was written and the option; the request has what it returns.
        more: arguments of ``click.Option``.
    """
    return Option(text, *flags, default=default, parse=parse, **more)


def argument(metavar: str | None = None, *, default: Any = None, **more: Any) -> Any:
    """A field that is an argument. ``more``: arguments of ``click.Argument``."""
    return Argument("", default=default, metavar=metavar, **more)


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


@dataclass_transform(kw_only_default=True, field_specifiers=(option, argument))
class Request:
    """The base of all requests: a field for each option and argument, in the order of the help, the own ones first.

    The docstring of a request is the help of its command.
    """

    as_json = False
    detail = ANSWER

    def __init__(self, **given: Any) -> None:
        vars(self).update({name: field.default_of(kind) for name, (kind, field) in fields_of(type(self)).items()})
        vars(self).update(given)

    @property
    def quiet(self) -> bool:
        """True if nothing but the answer is printed: JSON, or one sentence."""
        return self.as_json or self.detail == SENTENCE


def fields_of(request: type[Request]) -> dict[str, tuple[Any, Option]]:
    """The type and the option of each field."""
    kinds = get_type_hints(request)
    names = [name for each in request.__mro__ for name in vars(each).get("__annotations__", ())]
    return {name: (kinds[name], getattr(request, name)) for name in names}


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

    parameters = [parameter for each, (kind, field) in fields.items() for parameter in field.parameters(each, kind)]
    return click.Command(last, callback=ask, params=parameters, **words)
