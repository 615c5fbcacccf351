"""How Ctrl-C and SIGTERM end a command: within about two seconds, whatever it is doing.

Python runs the handler of a signal in the main thread, and only between two of its own instructions: never inside a
compiled kernel, which may take minutes. So the handler interrupts the main thread as usual, and a second thread, the
watcher, gives it ``GRACE_S`` to unwind and to leave. Python tells the watcher of a signal by a byte in a pipe
(``signal.set_wakeup_fd``), written in C at the moment of the signal. When the time is over, or at a second signal, the
watcher removes temporary files, ends the worker processes, says the word and leaves with the exit code of the signal.
Points that an exploration finished are durable, as each group of them is a transaction.

The watcher must get to run: hence all kernels are compiled with ``nogil=True``, which costs nothing.

Rejected: kernels that return now and then, as each would need a state to go on from, and compiled libraries cannot be
changed; a watcher process, as a process that is killed from outside has no exit code of its own.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from codesign.errors import Interrupted, Terminated
from codesign.files import remove_passing

GRACE_S = 1.0
"""Seconds that the main thread has to unwind."""

SIGNALS: dict[int, type[Interrupted]] = {signal.SIGINT: Interrupted, signal.SIGTERM: Terminated}


class _Ending:
    """What this process knows of its end."""

    def __init__(self) -> None:
        self.struck: type[Interrupted] | None = None
        self.kept = ""

    def strike(self, number: int, _frame: FrameType | None) -> None:
        """The handler: interrupt the main thread once; what strikes while it unwinds is the watcher's."""
        if self.struck is not None:
            return
        self.struck = SIGNALS[number]
        # An interrupt that some library swallows, or raises as an error of its own, is not to be told as a traceback.
        sys.excepthook = lambda *_: None
        sys.unraisablehook = lambda _: None
        raise self.struck


_ending = _Ending()


def end_on_signals() -> None:
    """From now on until it ends, this process ends by Ctrl-C and by SIGTERM as the module says.

    For the main thread of a process that runs one command. A signal that this process ignores stays ignored.
    """
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _ending.strike)
    if os.name != "posix":
        # There the pipe would have to be a socket; the main thread alone then ends the process.
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(reading,), name="watcher of signals", daemon=True).start()


def leave_in_peace() -> None:
    """The command is done and its exit code stands: no signal changes it any more."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def keep(kept: str) -> None:
    """Note what is kept when this process is ended, such as "what was finished is kept"."""
    _ending.kept = kept


def struck(fault: BaseException | None = None) -> type[Interrupted] | None:
    """What ended the command: the signal that struck, or else ``fault`` where that is an interrupt; else None."""
    if _ending.struck is None and isinstance(fault, KeyboardInterrupt):
        return type(fault) if isinstance(fault, Interrupted) else Interrupted
    return _ending.struck


def word(interrupt: type[Interrupted]) -> str:
    """What is said at the end.

    >>> word(Terminated)
    'terminated'
    """
    return f"{interrupt.word}; {_ending.kept}" if _ending.kept else interrupt.word


@contextmanager
def held() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back in the main thread; a process started meanwhile is deaf to Ctrl-C.

    The mask is what such a process inherits. It does not do for this process: a thread of some library takes the signal
    in the place of this one, and Python interrupts this one all the same. So the handlers only take note.
    """
    handlers = {number: signal.getsignal(number) for number in SIGNALS}
    ours = {number: handler for number, handler in handlers.items() if callable(handler)}
    if threading.current_thread() is not threading.main_thread() or not ours:
        yield
        return
    struck: list[int] = []
    for number in ours:
        signal.signal(number, lambda number, _frame: struck.append(number))
    masks = os.name == "posix"
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    try:
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for number, handler in ours.items():
            signal.signal(number, handler)
        if struck:
            ours[signal.Signals(struck[0])](struck[0], None)


def _watch(reading: int) -> None:
    interrupt = SIGNALS[_next(reading, None)]
    _next(reading, GRACE_S)
    remove_passing()
    _end_workers()
    # Not through sys.stderr: the main thread may hold its lock. And nothing waits for a reader who does not read.
    with suppress(OSError):
        if select.select([], [2], [], 0)[1]:
            os.write(2, f"{word(interrupt)}\n".encode())
    os._exit(interrupt.exit_code)


def _next(reading: int, seconds: float | None) -> int:
    """The signal that strikes next; 0 where none does within so many seconds."""
    while select.select([reading], [], [], seconds)[0]:
        for number in os.read(reading, 1):
            if number in SIGNALS:
                return number
    return 0


def _end_workers() -> None:
    if "multiprocessing.process" in sys.modules:
        from multiprocessing import active_children

        for worker in active_children():
            worker.kill()
