"""Written by hwsw calibrate host --script: copy it to the board and run it there.

    python3 probe.py > board.json

It needs Python 3.7 or newer and NumPy. Programs in C are built with the compiler of the board (the variable CC, else
cc). Without one they are left out, and the file says so. Each plan is timed on several maps, by the clock on the wall
and by that of the processor. Let the programs of the robot run beside it.
"""

from __future__ import annotations

import base64
import ctypes
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np

PAYLOAD: Any = {}
"""The maps and the programs; a script has them here."""
LEAST_ROUNDS = 3
TOLERANCE = 0.02
"""Of the units that a program counts: some count no step along the path."""


def machine() -> tuple[str, int, int | None]:
    """The name of the processor, its cores, and its greatest clock in Hz or None."""
    name, clock = platform.processor() or platform.machine(), None
    for path, key in (("/proc/device-tree/model", ""), ("/proc/cpuinfo", "model name")):
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                lines = [line.strip("\0\n ") for line in file if line.startswith(key)]
        except OSError:
            continue
        if lines:
            name = lines[0].split(":", 1)[-1].strip()
    try:
        with open("/sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq", encoding="utf-8") as file:
            clock = 1000 * int(file.read())
    except (OSError, ValueError):
        pass
    return name, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, clock


def built(program: Any, folder: str) -> tuple[Callable[[Any, Any, Any], float], str]:
    """A function of free cells, goal and start that computes a plan, and how it was made.

    Raises OSError, subprocess.SubprocessError: there is no compiler, or it fails.
    """
    if program["suffix"] == ".py":
        names: Any = {}
        exec(compile(program["source"], "program", "exec"), names)
        made = f"Python {platform.python_version()}, NumPy {np.__version__}"
        return lambda free, goal, start: names["plan"](free, goal, start, **program["parameters"]), made
    compiler = os.environ.get("CC", "cc")
    source, library = os.path.join(folder, "program.c"), os.path.join(folder, f"{len(os.listdir(folder))}.so")
    with open(source, "w", encoding="utf-8") as file:
        file.write(program["source"])
    subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", library, source], check=True, stderr=subprocess.PIPE)
    version = subprocess.run([compiler, "--version"], check=True, stdout=subprocess.PIPE).stdout.decode().split("\n")[0]
    plan = ctypes.CDLL(library).plan
    plan.restype, plan.argtypes = ctypes.c_double, [ctypes.c_void_p, *6 * [ctypes.c_int32]]

    def run(free: Any, goal: Any, start: Any) -> float:
        return float(plan(free.ctypes.data, free.shape[0], free.shape[1], *goal, *start))

    return run, f"C by {compiler} -O2, {version}"


def timed(run: Callable[[], object]) -> tuple[float, float]:
    """The seconds of a run on the wall and of this thread on the processor."""
    wall, processor = time.perf_counter(), time.thread_time()
    run()
    return time.perf_counter() - wall, time.thread_time() - processor


def main() -> None:
    """Time all plans by turns, and print the file."""
    free: Any = {}
    runs: Any = {}
    made: Any = {}
    left_out: Any = {}
    times: Any = {}
    for name, (rows, columns, packed) in PAYLOAD["maps"].items():
        bits = np.unpackbits(np.frombuffer(zlib.decompress(base64.b64decode(packed)), np.uint8))
        free[name] = np.ascontiguousarray(bits[: rows * columns].reshape(rows, columns))
    with tempfile.TemporaryDirectory() as folder:
        for name, program in PAYLOAD["programs"].items():
            try:
                run, made[name] = built(program, folder)
            except (OSError, subprocess.SubprocessError) as error:
                told = getattr(error, "stderr", None) or b""
                left_out[name] = f"no C compiler that works: {error} {told.decode(errors='replace')[:200]}"
                continue
            for key, (on, goal, start, answer) in program["plans"].items():
                cells = free[on] if program["suffix"] == ".c" else free[on].astype(bool)
                found = run(cells, goal, start)
                if abs(found - answer) > TOLERANCE * answer:
                    left_out[name] = f"its answer on {on} is {found}, not {answer}"
                    break
                tiny = np.ones((1, 2), cells.dtype)
                runs[name, key] = (
                    lambda run=run, cells=cells, goal=goal, start=start: run(cells, goal, start),
                    lambda run=run, tiny=tiny: run(tiny, (0, 0), (0, 1)),
                )
        runs = {key: run for key, run in runs.items() if key[0] not in left_out}
        times.update({name: {} for name, _ in runs})
        for name, key in runs:
            times[name][key] = {"wall": [], "processor": [], "call": []}
        end, turn = time.perf_counter() + PAYLOAD["seconds"], 0
        while runs and (turn < LEAST_ROUNDS or time.perf_counter() < end):
            turn += 1
            sys.stderr.write(f"\rround {turn}")
            for (name, key), both in runs.items():
                of, (run, call) = times[name][key], both
                run()
                wall, processor = timed(run)
                of["wall"].append(wall)
                of["processor"].append(processor)
                call()
                of["call"].append(timed(call)[1])
    sys.stderr.write("\n")
    name, cores, clock = machine()
    head = {"kind": "board", "script": PAYLOAD["script"], "machine": name, "cores": cores, "clock_hz": clock}
    json.dump({**head, "made": made, "times": times, "not_timed": left_out}, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
