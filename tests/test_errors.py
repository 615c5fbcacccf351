"""What an error shows on a terminal."""

from __future__ import annotations

import pickle

from codesign.ground.errors import CodesignError, Fault, InputError, SpecError

NASTY = "a\x1b[31m\u202eb\udcff"


def test_no_error_reaches_the_terminal_raw() -> None:
    faults = [Fault(f"{NASTY}.yaml", 1, 1, NASTY, NASTY, NASTY)]
    for error in (CodesignError(NASTY, NASTY, NASTY), SpecError(faults)):
        shown = str(error)
        assert shown.count("a\N{REPLACEMENT CHARACTER}[31m") >= 3
        assert all(mark.isprintable() or mark == "\n" for mark in shown)
        assert str(pickle.loads(pickle.dumps(error))) == shown
    assert str(InputError("two\nlines", "here", "do")) == "here: two\nlines\n  hint: do"
