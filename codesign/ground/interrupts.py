"""Ctrl-C, SIGTERM and SIGHUP (a closed terminal) end a command within about two seconds, whatever it is doing.

Python runs the handler of a signal in the main thread, between two Python instructions. It never runs inside a compiled
kernel, which may take minutes. So the handler interrupts the main thread as usual, and a second thread, the watcher,
gives it ``GRACE_S`` to unwind and to exit. Python notifies the watcher of a signal by a byte in a pipe
(``signal.set_wakeup_fd``), which C code writes when the signal arrives. After that time, or at a second signal, the
watcher removes temporary files, ends the worker processes, prints the message and exits with the exit code of the
signal. Finished points of an exploration are durable, because each group of them is a transaction.

The watcher must be able to run. So all kernels are compiled with ``nogil=True``, which costs nothing.

When a kernel returns an array, numba's C code calls the Python function ``_numba_unpickle`` for the type of the array.
A signal that arrived during the kernel is handled there. That C code does not look for an exception and dereferences a
null pointer. So the handler raises nothing there: a trace function raises the interrupt once the kernel has returned.

Rejected: kernels that return at intervals. Each would need a state to continue from, and compiled libraries cannot be
changed. Rejected: a watcher process. A process that is killed from outside has no exit code of its own.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType

from codesign.ground.errors import Interrupted, Terminated
from codesign.ground.files import remove_passing
from codesign.ground.late import late

multiprocessing = late("multiprocessing")

GRACE_S = 1.0
"""Seconds for the main thread to unwind."""

SIGNALS: dict[int, type[Interrupted]] = {signal.SIGINT: Interrupted, signal.SIGTERM: Terminated}
if os.name == "posix":
    SIGNALS[signal.SIGHUP] = Terminated


class _Ending:
    """The signal that struck this process, what the message says is kept, and what cleans the terminal."""

    def __init__(self) -> None:
        self.struck: type[Interrupted] | None = None
        self.kept = ""
        self.cleaning = b""

    def strike(self, number: int, frame: FrameType | None) -> None:
        """The handler: interrupt the main thread once. The watcher handles signals while it unwinds."""
        if self.struck is not None:
            return
        self.struck = SIGNALS[number]
        # A library may catch the interrupt, or raise its own error for it. Neither is to print a traceback.
        sys.excepthook = lambda *_: None
        sys.unraisablehook = lambda _: None
        caller = _caller_of_kernel(frame)
        if caller is None:
            raise self.struck
        caller.f_trace, caller.f_trace_opcodes = self.trace, True
        sys.settrace(self.trace)

    def trace(self, frame: FrameType, _event: str, _argument: object) -> None:
        """The trace function after a signal during a kernel: raise the interrupt in the first frame outside numba."""
        if self.struck is not None and _caller_of_kernel(frame) is None:
            raise self.struck


def _caller_of_kernel(frame: FrameType | None) -> FrameType | None:
    """The frame that called a kernel, where numba makes the kernel's results in ``frame``; otherwise None."""
    while frame is not None and frame.f_code.co_name != "_numba_unpickle":
        frame = frame.f_back
    return frame and frame.f_back


_ending = _Ending()


def end_on_signals() -> None:
    """Let Ctrl-C, SIGTERM and SIGHUP end this process as the module describes.

    For the main thread of a process that runs one command. A signal that the process ignores stays ignored.
    """
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _ending.strike)
    if os.name != "posix":
        # The pipe would have to be a socket here, so the main thread alone ends the process.
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(reading,), name="watcher of signals", daemon=True).start()


def leave_in_peace() -> None:
    """Ignore signals from now: the command is done, and its exit code is final."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def keep(kept: str) -> None:
    """Set what the message says is kept when this process ends, such as "finished points are kept"."""
    _ending.kept = kept


def clean_terminal_by(codes: bytes) -> None:
    """Set what is written to standard error before the message, where the watcher ends this process.

    It erases what a display has drawn there, which the main thread then cannot do.
    """
    _ending.cleaning = codes


def struck(fault: BaseException | None = None) -> type[Interrupted] | None:
    """The interrupt that ended the command: of the signal, or of ``fault`` if it is an interrupt; otherwise None."""
    if _ending.struck is None and isinstance(fault, KeyboardInterrupt):
        return type(fault) if isinstance(fault, Interrupted) else Interrupted
    return _ending.struck


def word(interrupt: type[Interrupted]) -> str:
    """The message at the end.

    >>> word(Terminated)
    'terminated'
    """
    return f"{interrupt.word}; {_ending.kept}" if _ending.kept else interrupt.word


@contextmanager
def held() -> Iterator[None]:
    """Delay Ctrl-C and SIGTERM in the main thread until the end of the block. Child processes ignore Ctrl-C.

    A child process inherits the mask. For this process the mask is not enough: a thread of a library may receive the
    signal instead, and Python then interrupts the main thread anyway. So the handlers only record the signal.
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


_children: set[subprocess.Popen[bytes]] = set()


@contextmanager
def child(
    command: Sequence[str], cwd: Path, stdin: int = subprocess.DEVNULL, temporary: Path | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """A tool in a process of its own, with pipes for its output. All its processes end at the end of the block.

    They end with this process too: at an exception, at a signal, and when it is killed. ``temporary``: the folder for
    their temporary files.

    Raises:
        OSError: the tool cannot be started.
    """
    process = None
    try:
        # A signal during the start strikes at the end of this block.
        with held():
            if _ending.struck is not None:
                raise _ending.struck
            pipe = subprocess.PIPE
            own = os.name == "posix"
            folders = {} if temporary is None else dict.fromkeys(("TMPDIR", "TMP", "TEMP"), str(temporary))
            process = subprocess.Popen(
                command,
                cwd=cwd,
                stdin=stdin,
                stdout=pipe,
                stderr=pipe,
                start_new_session=own,
                env={**os.environ, **folders},
            )
            _children.add(process)
        with _guard(process):
            yield process
    finally:
        if process is not None:
            _end_child(process)
            with suppress(OSError), process:
                pass  # closes the pipes, and waits
            _children.discard(process)


@contextmanager
def _guard(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """A shell ends the tool once this process is gone, however it ended; this holds until the end of the block.

    Only this process can write to the shell's input, so the input ends with it.
    """
    if os.name != "posix":
        yield
        return
    command = ("/bin/sh", "-c", 'read _; kill -9 -"$0"', str(process.pid))
    none = subprocess.DEVNULL
    guard = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=none, stderr=none, start_new_session=True)
    try:
        yield
    finally:
        guard.kill()
        with guard:
            pass  # closes the pipe, and waits


def end_children() -> None:
    """End every tool that ``child`` started, of any thread."""
    for process in list(_children):
        _end_child(process)


def _end_child(process: subprocess.Popen[bytes]) -> None:
    with suppress(OSError):
        if os.name == "posix":
            # The processes of the tool may outlive it, so the whole session is ended.
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


def _watch(reading: int) -> None:
    interrupt = SIGNALS[_next(reading, None)]
    _next(reading, GRACE_S)
    remove_passing()
    _end_workers()
    end_children()
    # Not through sys.stderr: the main thread may hold its lock. Nothing waits for a reader that does not read.
    with suppress(OSError):
        if select.select([], [2], [], 0)[1]:
            os.write(2, _ending.cleaning + f"{word(interrupt)}\n".encode())
    os._exit(interrupt.exit_code)


def _next(reading: int, seconds: float | None) -> int:
    """The next signal, or 0 where none arrives within ``seconds``."""
    while select.select([reading], [], [], seconds)[0]:
        for number in os.read(reading, 1):
            if number in SIGNALS:
                return number
    return 0


def _end_workers() -> None:
    if "multiprocessing.process" in sys.modules:
        for worker in multiprocessing.active_children():
            worker.kill()
