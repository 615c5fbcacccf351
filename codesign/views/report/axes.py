"""The axes of a study in a reader's words: which vary, what they are called, and their values as texts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from codesign.inputs.edit import PLATFORM_AXIS
from codesign.study.groups import Groups
from codesign.views.report.wording import axis_text

if TYPE_CHECKING:
    from codesign.study import Study


def varying_axes(study: Study) -> tuple[str, ...]:
    """The decisions with more than one value, in the order of the workload."""
    return tuple(name for name in study.axes if len(axis_levels(study, name)) > 1)


def short_names(axes: Sequence[str]) -> tuple[str, ...]:
    """The axes as headings: without the task or component where no other axis has the same last word.

    >>> short_names(["relax.block", "fpga.clock", "host.clock"])
    ('block', 'fpga.clock', 'host.clock')
    """
    last = Counter(name.rpartition(".")[2] for name in axes)
    return tuple(word if last[word := name.rpartition(".")[2]] == 1 else name for name in axes)


def fixed_axes(study: Study) -> tuple[tuple[str, str], ...]:
    """The axes and conditions with a single value, and that value."""
    return tuple((name, levels[0]) for name in study.every_axis if len(levels := axis_levels(study, name)) == 1)


def axis_levels(study: Study, name: str) -> list[str]:
    """The values of an axis as texts, in the order of the workload."""
    return list(dict.fromkeys(map(level_texts(study, name), study.every_axis[name])))


def level_texts(study: Study, name: str) -> Callable[[Any], str]:
    """The function that gives the text of a value of an axis.

    Of mappings, such as whole problems and whole scenarios, the text has only what differs among them. A platform is
    shown with its part, unless an axis moves parts.
    """
    values = study.every_axis.get(name, ())
    if name == PLATFORM_AXIS:
        platforms = _platform_texts(study)
        return lambda value: platforms.get(value, axis_text(name, value))
    mappings = [value for value in values if isinstance(value, Mapping)]
    ranges = all(set(value) == {"first", "step", "last"} for value in mappings)
    if len(mappings) < len(values) or len(values) < 2 or ranges:
        return lambda value: axis_text(name, value)
    leaves_of = [_leaves(value) for value in mappings]
    paths = list(dict.fromkeys(path for leaves in leaves_of for path in leaves))
    differing = [path for path in paths if len({repr(leaves.get(path)) for leaves in leaves_of}) > 1]

    def text(value: Any) -> str:
        leaves = _leaves(value) if isinstance(value, Mapping) else {}
        parts = (f"{path[-1]} {axis_text(path[-1], leaves[path])}" for path in differing if path in leaves)
        return ", ".join(parts) or axis_text(name, value)

    return text


def _platform_texts(study: Study) -> dict[str, str]:
    """The name and part of the platform that each value of the axis stands for; of values with a result."""
    moved = any(name.endswith(".part") for name in study.axes)
    templates, which = study.outcomes.templates, study.outcomes.which
    done = np.flatnonzero(which >= 0)[::-1]
    levels = study.space.levels(done)[PLATFORM_AXIS]
    pairs = (levels.astype(np.int64) * len(templates) + which[done])[levels >= 0]
    texts: dict[str, str] = {}
    # Of several parts the last one is shown.
    for number in pairs[Groups.of(pairs).in_turn.firsts[::-1]].tolist():
        place, template = divmod(number, len(templates))
        value, result = study.every_axis[PLATFORM_AXIS][place], templates[template]
        part = None if moved else result.part
        texts[value] = f"{result.platform} ({part})" if part else texts.get(value, result.platform)
    return texts


def _leaves(value: Mapping[str, Any], path: tuple[str, ...] = ()) -> dict[tuple[str, ...], Any]:
    """The values inside nested mappings, by their paths."""
    leaves: dict[tuple[str, ...], Any] = {}
    for key, inner in value.items():
        inner_path = (*path, str(key))
        leaves |= _leaves(inner, inner_path) if isinstance(inner, Mapping) else {inner_path: inner}
    return leaves
