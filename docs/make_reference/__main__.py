"""``python -m docs.make_reference``: write the pages, and the tables of ``docs/boards.md``; ``make docs`` runs it."""

from __future__ import annotations

from docs.make_reference.boards import PAGE, boards_page
from docs.make_reference.pages import FOLDER, pages

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in pages().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    PAGE.write_text(boards_page(), encoding="utf-8")
