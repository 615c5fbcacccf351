"""Reports for a person: tables (text, Markdown, CSV), plots, and one self-contained HTML page.

A table is made first (``front_table(study)``, ``result_tables(result)``, ...) and shown after
(``render_text``, ``render_markdown``, ``render_csv``); pages and pictures use the same tables and words.

All figures are worked out here, in Python; templates and the command line only place them. A page asks for
nothing from the network: script, style, data and pictures stand in the file, and a content security policy
holds it to that.
matplotlib, Jinja2 and rich are imported when something is drawn or printed.
"""

from __future__ import annotations

from codesign.report.aggregated import spread_table
from codesign.report.answer import Answer, answer
from codesign.report.canvas import Picture
from codesign.report.certainty import winners_certainty_table
from codesign.report.comparison_page import comparison_page
from codesign.report.comparison_tables import comparison_table
from codesign.report.explain_tables import (
    effects_table,
    explanation_sentence,
    explanation_tables,
)
from codesign.report.front_picture import front_picture
from codesign.report.map_pictures import drive_picture, map_picture, moment_picture
from codesign.report.pictures import (
    run_map_picture,
    run_pictures,
    run_timeline_picture,
    workload_map_picture,
)
from codesign.report.planner_tables import planner_tables
from codesign.report.render import render_csv, render_markdown, render_text, write_csv
from codesign.report.reproduction_page import reproduction_page
from codesign.report.reproduction_tables import (
    findings_table,
    reproduction_csv,
    reproduction_sources_table,
    reproduction_table,
)
from codesign.report.result_page import records_page, result_page
from codesign.report.result_tables import result_reasons_table, result_tables
from codesign.report.schedule_picture import schedule_picture
from codesign.report.study_answer import study_sentence, study_tables
from codesign.report.study_page import study_page
from codesign.report.study_tables import (
    best_table,
    front_table,
    infeasible_table,
    nearest_table,
    reasons_table,
    study_csv,
    study_table,
    write_study_csv,
)
from codesign.report.table import Cell, Column, Table
from codesign.report.timelines import account_picture, mission_timeline_picture, timeline_picture
from codesign.report.winners_table import winners_table

__all__ = [
    "Answer",
    "Cell",
    "Column",
    "Picture",
    "Table",
    "account_picture",
    "answer",
    "best_table",
    "comparison_page",
    "comparison_table",
    "drive_picture",
    "effects_table",
    "explanation_sentence",
    "explanation_tables",
    "findings_table",
    "front_picture",
    "front_table",
    "infeasible_table",
    "map_picture",
    "mission_timeline_picture",
    "moment_picture",
    "nearest_table",
    "planner_tables",
    "reasons_table",
    "records_page",
    "render_csv",
    "render_markdown",
    "render_text",
    "reproduction_csv",
    "reproduction_page",
    "reproduction_sources_table",
    "reproduction_table",
    "result_page",
    "result_reasons_table",
    "result_tables",
    "run_map_picture",
    "run_pictures",
    "run_timeline_picture",
    "schedule_picture",
    "spread_table",
    "study_csv",
    "study_page",
    "study_sentence",
    "study_table",
    "study_tables",
    "timeline_picture",
    "winners_certainty_table",
    "winners_table",
    "workload_map_picture",
    "write_csv",
    "write_study_csv",
]
