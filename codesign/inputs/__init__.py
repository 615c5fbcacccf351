"""Platform, part and workload files: the only package that reads YAML.

A file becomes a plain tree with the place of every key (``yaml_tree``, ``document``), pydantic models check it
(``platform``, ``components``, ``links``, ``workload``, ``problem``, ``scenario``, ``exploration``, ``part_file``), and
what is wrong comes out as faults with file, line, column, key, value and remedy, all at once (``faults``).

A design point is an edited tree (``edit``): values are put into the trees, with where they come from, and the same
models validate. A variant is a merge of its section. ``checks`` makes each point of a study with one axis moved, and
finds what is wrong with the axes before any point is computed.

PyYAML reads events only, never objects. Its own schema was rejected: it takes ``010`` for 8, ``on`` for true,
``12:30:00`` for 45000, ``1e6`` for text, and the last of two equal keys without a word.
"""

from __future__ import annotations

from codesign.ground.late import by_name

__getattr__, __dir__, __all__ = by_name(__name__, __file__)
