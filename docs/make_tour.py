"""``python -m docs.make_tour``: run the cells of ``docs/tour.ipynb`` and keep what they show; ``make docs`` runs it.

Jupyter is not needed: a cell is run as a script, and its last expression is shown as IPython would show it.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

from codesign.views.report.canvas import picture_bytes

NOTEBOOK = Path(__file__).parent / "tour.ipynb"


def run_cells(notebook: dict[str, Any], folder: Path) -> list[list[dict[str, Any]]]:
    """The outputs of each code cell, run in order in one namespace, with ``folder`` as the current folder.

    Raises what a cell raises.
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    before = Path.cwd()
    os.chdir(folder)
    try:
        codes = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        return [_outputs("".join(cell["source"]), names, count) for count, cell in enumerate(codes, 1)]
    finally:
        os.chdir(before)


def _outputs(source: str, names: dict[str, Any], count: int) -> list[dict[str, Any]]:
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    value = None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, f"cell {count}", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), f"cell {count}", "eval"), names)
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": _lines(printed.getvalue())})
    if value is not None:
        outputs.append(
            {"data": _shown(value), "execution_count": count, "metadata": {}, "output_type": "execute_result"}
        )
    return outputs


def _shown(value: Any) -> dict[str, Any]:
    """What a notebook shows of a value, by media type."""
    from matplotlib.figure import Figure

    shown: dict[str, Any] = {"text/plain": _lines(repr(value))}
    if isinstance(value, Figure):
        shown["image/png"] = base64.b64encode(picture_bytes(value, "png")).decode() + "\n"
    elif hasattr(value, "_repr_html_"):
        shown["text/html"] = _lines(value._repr_html_())
    return dict(sorted(shown.items()))


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def executed(notebook: dict[str, Any]) -> dict[str, Any]:
    """The notebook with the outputs of a new run."""
    with tempfile.TemporaryDirectory() as folder:
        outputs = iter(enumerate(run_cells(notebook, Path(folder)), 1))
    cells = [cell | _kept(next(outputs)) if cell["cell_type"] == "code" else cell for cell in notebook["cells"]]
    return notebook | {"cells": cells}


def _kept(run: tuple[int, list[dict[str, Any]]]) -> dict[str, Any]:
    return {"execution_count": run[0], "outputs": run[1]}


if __name__ == "__main__":
    made = executed(json.loads(NOTEBOOK.read_text(encoding="utf-8")))
    NOTEBOOK.write_text(json.dumps(made, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
