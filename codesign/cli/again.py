"""The command line that is being run, to be printed where a page says how to make it again."""

from __future__ import annotations

import shlex

import click
from click.core import ParameterSource


def command_line() -> str:
    """What was typed, quoted for a shell; options in the order of the help, those that were left out left out.

    Without ``--json``, which changes what is printed and not what is written.
    """
    context = click.get_current_context()
    options, arguments = [], []
    for parameter in context.command.params:
        name = parameter.name or ""
        if context.get_parameter_source(name) is not ParameterSource.COMMANDLINE or name == "as_json":
            continue
        value = context.params[name]
        values = [str(each) for each in (value if isinstance(value, tuple) else (value,))]
        if isinstance(parameter, click.Argument):
            arguments += values
        elif isinstance(parameter, click.Option) and parameter.is_flag:
            options.append(parameter.opts[0])
        else:
            options += [word for each in values for word in (parameter.opts[0], each)]
    dashed = any(word.startswith("-") for word in arguments)
    words = [*options, "--", *arguments] if dashed else [*arguments, *options]
    return shlex.join(["hwsw", context.info_name or "", *words])
