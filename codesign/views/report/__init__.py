"""Reports for a person: tables (text, Markdown, CSV), plots, and one self-contained HTML page.

A table is made first (``front_table(study)``, ``result_tables(result)``, ...) and shown after
(``render_text``, ``render_markdown``, ``render_csv``); pages and pictures use the same tables and words.

All figures are worked out here, in Python; templates and the command line only place them. A page asks for
nothing from the network: script, style, data and pictures stand in the file, and a content security policy
holds it to that.
A module is imported when one of its names is asked for; matplotlib, Jinja2 and rich when something is drawn.
"""

from __future__ import annotations

from codesign.ground.late import by_name

__getattr__, __dir__, __all__ = by_name(__name__, __file__)
