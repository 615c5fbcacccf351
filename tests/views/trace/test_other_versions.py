"""Traces of other versions, and under other versions of NumPy: read, or refused with the version, never wrong."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import MISSING, fields, make_dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from numpy.typing import NDArray
from trace_samples import a_mission, a_run, same

from codesign import __version__
from codesign.ground.errors import TraceError
from codesign.ground.records import RECORD_TYPES, ArrayOf, Record
from codesign.views.trace import open_trace
from codesign.views.trace.messages import descriptor_set, encode, plan_of, schema_name

SAMPLES: dict[str, Record] = {type(record).__name__: record for record in [*a_run(), *a_mission()]}


def test_there_is_a_sample_of_every_class_of_record() -> None:
    assert set(SAMPLES) == set(RECORD_TYPES)


OTHER_HINTS = """
import numpy as np, numpy.typing, typing
Item = typing.TypeVar("Item")
class NDArray(typing.Generic[Item]):
    "Of a form that NumPy may give it next: what is within is its own affair."
numpy.typing.NDArray = NDArray
from codesign.ground.records import RECORD_TYPES
from codesign.views.trace.messages import descriptor_set
for name, kind in RECORD_TYPES.items():
    print(name, descriptor_set(kind).hex())
"""


def test_messages_do_not_depend_on_the_inner_form_of_type_hints() -> None:
    done = subprocess.run([sys.executable, "-c", OTHER_HINTS], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout.split("\n")[:-1] == [
        f"{name} {descriptor_set(kind).hex()}" for name, kind in RECORD_TYPES.items()
    ]


def another(kind: type[Record], **changed: Any) -> type[Record]:
    """The class as another version may have it: fields of other types or, where the class has none, appended."""
    own = {plan.name: plan for plan in plan_of(kind)}
    hints: dict[str, Any] = {}
    for name, plan in own.items():
        array = plan.array and Annotated[NDArray[Any], plan.array]
        plain = {"int64": int, "double": float, "string": str, "bool": bool, "mapping": dict[str, Any]}
        hint = array or plain[plan.kind]
        hints[name] = hint | None if plan.optional else hint
    defaults = {each.name: each.default for each in fields(kind) if each.default is not MISSING}
    hints |= {name: hint for name, (hint, _) in changed.items()}
    defaults |= {name: default for name, (_, default) in changed.items() if name not in own}
    return make_dataclass(
        kind.__name__,
        [(name, hint, *([defaults[name]] if name in defaults else [])) for name, hint in hints.items()],
        bases=(Record,),
        frozen=True,
        namespace={"TIMES": tuple(name for name in kind.TIMES if name not in changed)},
    )


def written(path: Path, record: Record, kind: type[Record], **run: str) -> Path:
    """A file of another version, with one record."""
    from mcap.writer import Writer

    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.add_metadata("run", {"format": "2", "codesign": "9.9", **run})
        schema = writer.register_schema(schema_name(kind), "protobuf", descriptor_set(kind))
        names = {"record": kind.__name__, "source": record.source}
        channel = writer.register_channel("/any", "protobuf", schema, names)
        writer.add_message(channel, record.time // 1000, encode(record), 0)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


@pytest.mark.parametrize("name", RECORD_TYPES)
def test_a_field_that_a_later_version_adds_is_left_out(tmp_path: Path, name: str) -> None:
    record, kind = SAMPLES[name], another(RECORD_TYPES[name], later=(int | None, 7))
    trace = open_trace(written(tmp_path / "run.mcap", kind(**vars(record)), kind))
    assert trace.complete
    assert same(*trace.records(), record)


@pytest.mark.parametrize("name", RECORD_TYPES)
def test_a_field_of_another_type_is_no_damage(tmp_path: Path, name: str) -> None:
    """Nor is it a zero: a message of protobuf in which a field has another type looks like one without it."""
    record, kind = SAMPLES[name], RECORD_TYPES[name]
    own = [plan for plan in plan_of(kind) if plan.name not in ("time", "source")]
    assert own
    for plan in own:
        if plan.array:
            value: Any = np.zeros([1 if side is None else side for side in plan.array.shape], np.int16)
            hint: Any = Annotated[NDArray[Any], ArrayOf("int16", plan.array.shape)]
        else:
            hint, value = (int, 3) if plan.kind in ("string", "mapping") else (str, "three")
        other = another(kind, **{plan.name: (hint, None)})
        path = written(tmp_path / "run.mcap", other(**vars(record) | {plan.name: value}), other)
        trace = open_trace(path)
        assert trace.complete
        with pytest.raises(TraceError) as caught:
            list(trace.records())
        assert "damage" not in str(caught.value), plan.name
        assert f"hwsw 9.9 wrote it, this is hwsw {__version__}" in str(caught.value)


@pytest.mark.parametrize("name", RECORD_TYPES)
def test_a_field_that_an_older_version_lacks_takes_its_default_or_is_refused(tmp_path: Path, name: str) -> None:
    record, kind = SAMPLES[name], RECORD_TYPES[name]
    last = plan_of(kind)[-1]
    kept = [plan.name for plan in plan_of(kind)][:-1]
    whole = another(kind)
    older = make_dataclass(
        kind.__name__,
        [(each.name, each.type, *([each.default] if each.default is not MISSING else [])) for each in fields(whole)][
            :-1
        ],
        bases=(Record,),
        frozen=True,
        namespace={"TIMES": tuple(name for name in kind.TIMES if name in kept)},
    )
    given = {name: value for name, value in vars(record).items() if name in kept}
    trace = open_trace(written(tmp_path / "run.mcap", older(**given), older, codesign="0.0"))
    if last.has_default or last.optional:
        assert same(*trace.records(), kind(**given | {last.name: last.default}))
    else:
        with pytest.raises(TraceError, match=r"hwsw 0\.0 wrote it"):
            list(trace.records())


def test_a_format_that_would_be_misread_is_refused_and_its_facts_are_shown(tmp_path: Path) -> None:
    record = SAMPLES["TaskRecord"]
    trace = open_trace(written(tmp_path / "run.mcap", record, type(record), format="3"))
    assert ("run.format", "3") in trace.rows()
    for read in (lambda: list(trace.records()), lambda: trace.result):
        with pytest.raises(TraceError, match="has format 3 of traces, and this version reads up to 2"):
            read()


def test_a_fault_of_the_installation_is_not_said_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    record = SAMPLES["MapRecord"]
    trace = open_trace(written(tmp_path / "run.mcap", record, type(record)))
    monkeypatch.setattr("codesign.views.trace.messages._PLANS", {})
    monkeypatch.setattr("codesign.views.trace.messages._CLASSES", {})
    monkeypatch.setattr("codesign.views.trace.messages._PLAIN", {})
    with pytest.raises(TraceError, match="which no message holds") as caught:
        list(trace.records())
    assert "damage" not in str(caught.value)
