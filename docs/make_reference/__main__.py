"""``python -m docs.make_reference``: write the pages, the tables of boards and the headlines; ``make docs`` runs it."""

from __future__ import annotations

from codesign.planners.registered import HEADLINES
from docs.make_reference.boards import PAGE, boards_page
from docs.make_reference.headlines import headlines_text
from docs.make_reference.pages import FOLDER, pages

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in pages().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    PAGE.write_text(boards_page(), encoding="utf-8")
    HEADLINES.write_text(headlines_text(), encoding="utf-8")
