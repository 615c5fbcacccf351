from .advice_page import advice_page
from .axes import spread_table
from .canvas import Picture
from .comparison_page import comparison_page, comparison_table
from .explain_tables import effects_table, explanation_sentence, explanation_tables
from .front_picture import front_picture
from .pictures import (
    account_picture,
    drive_picture,
    map_picture,
    mission_timeline_picture,
    moment_picture,
    run_map_picture,
    run_pictures,
    run_timeline_picture,
    schedule_picture,
    timeline_picture,
    workload_map_picture,
)
from .render import render_csv, render_markdown, render_text, write_csv
from .reproduction_page import (
    findings_table,
    planner_tables,
    reproduction_csv,
    reproduction_page,
    reproduction_sources_table,
    reproduction_table,
)
from .result_page import records_page, result_page
from .result_tables import result_reasons_table, result_tables
from .sentences import Answer, answer, winners_certainty_table
from .study_page import study_page
from .study_tables import (
    best_table,
    front_table,
    infeasible_table,
    nearest_table,
    reasons_table,
    study_csv,
    study_sentence,
    study_table,
    study_tables,
    write_study_csv,
)
from .winners_table import winners_table
from .wording import Cell, Column, Table

__all__ = [
    "Answer",
    "Cell",
    "Column",
    "Picture",
    "Table",
    "account_picture",
    "advice_page",
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
