"""Certificates that were tampered with: at random, each with a name of what was done."""

from __future__ import annotations

import hashlib
import io
import json
import struct
import zipfile
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
from certificate_sample import sample
from numpy.lib import format as npy

from codesign.study.certificates.file import DEFINITION, DIGESTS, HEAD, packed, sealed
from codesign.study.certificates.form import Claim, digests_of
from codesign.study.certify import certificate_of

Members = dict[str, bytes]


def members_of(content: bytes) -> Members:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def array(content: bytes) -> Any:
    return np.array(npy.read_array(io.BytesIO(content), allow_pickle=False))


def array_bytes(values: Any) -> bytes:
    buffer = io.BytesIO()
    npy.write_array(buffer, values, (1, 0), allow_pickle=values.dtype == object)
    return buffer.getvalue()


def digested(members: Members) -> bytes:
    """The file of these members with every digest made anew: it is at one with itself."""
    columns = {name.removesuffix(".npy"): array(content) for name, content in members.items() if name.endswith(".npy")}
    digests = digests_of((members[DEFINITION], members[HEAD]), columns)
    return sealed({**members, DIGESTS: digests.model_dump_json().encode()})


# ---- bytes, the seal left as it is ----


def flip(content: bytes, rng: Random) -> bytes:
    place = rng.randrange(len(content))
    return content[:place] + bytes([content[place] ^ 1 << rng.randrange(8)]) + content[place + 1 :]


def cut(content: bytes, rng: Random) -> bytes:
    return content[: rng.randrange(len(content))]


def drop(content: bytes, rng: Random) -> bytes:
    place = rng.randrange(len(content))
    return content[:place] + content[place + rng.randint(1, 99) :]


def insert(content: bytes, rng: Random) -> bytes:
    place = rng.randrange(len(content) + 1)
    return content[:place] + rng.randbytes(rng.randint(1, 99)) + content[place:]


# ---- members, under a new seal ----


def member_flip(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    name = rng.choice([name for name, held in members.items() if held])
    return sealed({**members, name: flip(members[name], rng)})


def member_cut(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    name = rng.choice([name for name, held in members.items() if held])
    return sealed({**members, name: members[name][: rng.randrange(len(members[name]))]})


def member_gone(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    del members[rng.choice(list(members))]
    return sealed(members)


def member_more(content: bytes, rng: Random) -> bytes:
    return sealed({**members_of(content), rng.choice(["more.npy", "../head.json", "x"]): b"\x93NUMPY"})


def members_moved(content: bytes, rng: Random) -> bytes:
    members = list(members_of(content).items())
    first, second = rng.sample(range(len(members)), 2)
    members[first], members[second] = members[second], members[first]
    return sealed(dict(members))


def huge(content: bytes, rng: Random) -> bytes:
    """Sizes in the head, or in a column, that no memory holds."""
    members = members_of(content)
    if rng.random() < 0.5:
        head = json.loads(members[HEAD])
        head[rng.choice(["rows", "boxes", "reasons"])] = 10 ** rng.randint(3, 40)
        return sealed({**members, HEAD: json.dumps(head).encode()})
    name = rng.choice([name for name in members if name.endswith(".npy")])
    buffer = io.BytesIO()
    shape = (10 ** rng.randint(6, 12),) * rng.randint(1, 3)
    npy.write_array_header_1_0(buffer, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return sealed({**members, name: buffer.getvalue()})


def bomb(content: bytes, rng: Random) -> bytes:
    """A member of which little is packed and much comes out."""
    members = members_of(content)
    name = rng.choice([name for name, held in members.items() if held])
    return sealed({**members, name: members[name] + bytes(2**22)})


def pickled(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    name = rng.choice([name for name in members if name.endswith(".npy")])
    return sealed({**members, name: array_bytes(np.array([{}] * 3, object))})


def head_changed(content: bytes, rng: Random) -> bytes:
    """A key of the head with a value of another kind, gone, or new."""
    members = members_of(content)
    name = rng.choice([HEAD, DEFINITION, DIGESTS])
    held = json.loads(members[name])
    key = rng.choice([*held, "more"])
    if key in held and rng.random() < 0.3:
        del held[key]
    else:
        held[key] = rng.choice([None, -1, 1.5, "text", [], [[]], {"a": 1}, True, "é" * 99])
        if held == json.loads(members[name]):
            held["more"] = 1
    return sealed({**members, name: json.dumps(held).encode()})


def value_changed(content: bytes, rng: Random) -> bytes:
    """One value of a column: every claim may still be true, and the digest of the columns is not."""
    members = members_of(content)
    name = rng.choice([name for name, held in members.items() if name.endswith(".npy") and array(held).size])
    values = array(members[name])
    place = rng.randrange(values.size)
    values.reshape(-1)[place] += 1 if not np.isnan(values.reshape(-1)[place]) else 0
    if np.array_equal(values, array(members[name]), equal_nan=True):
        values.reshape(-1)[place] = 7
    return sealed({**members, name: array_bytes(values)})


def _resealed(body: bytes) -> bytes:
    return body + hashlib.sha256(body).hexdigest().encode()


def bytes_before(content: bytes, rng: Random) -> bytes:
    """Bytes before the archive, or a whole other one: a zip is read from its end."""
    before = rng.choice([b"PK\x03\x04" + rng.randbytes(99), content])
    return _resealed(before + content[:-64])


def bytes_after(content: bytes, rng: Random) -> bytes:
    """Bytes behind the archive, in a comment that is longer than the seal."""
    more = rng.randbytes(rng.randint(1, 99))
    return _resealed(content[:-66] + struct.pack("<H", 64 + len(more)) + more)


def bytes_between(content: bytes, rng: Random) -> bytes:
    """Bytes before the directory, or between two members, that no entry of the directory has."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        offsets = [each.header_offset for each in archive.infolist()]
        directory = archive.start_dir
    cut = rng.choice([*offsets[1:], directory])
    more, held = rng.randbytes(rng.randint(1, 99)), bytearray(content[:-64])
    place = directory
    while held[place : place + 4] == b"PK\x01\x02":
        (offset,) = struct.unpack_from("<L", held, place + 42)
        struct.pack_into("<L", held, place + 42, offset + len(more) * (offset >= cut))
        place += 46 + sum(struct.unpack_from("<3H", held, place + 28))
    struct.pack_into("<L", held, place + 16, directory + len(more))
    return _resealed(bytes(held[:cut]) + more + bytes(held[cut:]))


def bytes_in_entry(content: bytes, rng: Random) -> bytes:
    """A member with bytes that no reader of its content sees: behind its name, beside it, or behind its content."""
    buffer, members = io.BytesIO(), members_of(content)
    where, some = rng.choice(["extra", "comment", "content"]), rng.choice([*members])
    more = b"\x99\x99" + struct.pack("<H", 20) + rng.randbytes(20)
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, held in members.items():
            info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            if name == some and where != "content":
                setattr(info, where, more)
            archive.writestr(info, held, zipfile.ZIP_DEFLATED)
            if name == some and where == "content":
                archive.fp.write(more)  # type: ignore[union-attr]
                archive.start_dir += len(more)
                info.compress_size += len(more)
                archive.fp.seek(info.header_offset)  # type: ignore[union-attr]
                archive.fp.write(info.FileHeader(zip64=False))  # type: ignore[union-attr]
                archive.fp.seek(archive.start_dir)  # type: ignore[union-attr]
        archive.comment = b"0" * 64
    return _resealed(buffer.getvalue()[:-64])


# ---- columns and definition, with all digests made anew: refused because a claim is false ----


def _rows(members: Members, claim: Claim) -> list[int]:
    rows = json.loads(members[HEAD])["rows"]
    return np.flatnonzero(array(members["claim.npy"])[:rows] == claim).tolist()


def _boxes(members: Members, claim: Claim) -> list[int]:
    rows = json.loads(members[HEAD])["rows"]
    return (np.flatnonzero(array(members["claim.npy"])[rows:] == claim) + rows).tolist()


def _put(members: Members, name: str, place: Any, value: Any) -> None:
    values = array(members[f"{name}.npy"])
    values[place] = value
    members[f"{name}.npy"] = array_bytes(values)


def named_wrongly(content: bytes, rng: Random) -> bytes:
    """A design is said to be dominated by one that is not on the front, or by none."""
    members = members_of(content)
    claims = array(members["claim.npy"])
    others = [*np.flatnonzero(claims != Claim.FRONT).tolist(), -1, len(claims), 2**31 - 1]
    _put(members, "by", rng.choice(_rows(members, Claim.DOMINATED)), rng.choice(others))
    return digested(members)


def task_of_no_name(content: bytes, rng: Random) -> bytes:
    """A design that is dominated stands on the front, beside designs of a task that there is not."""
    members = members_of(content)
    row = rng.choice(_rows(members, Claim.DOMINATED))
    _put(members, "claim", row, Claim.FRONT)
    _put(members, "by", row, 0)
    _put(members, "task", row, rng.choice([-1, 99, 2**31 - 1]))
    return digested(members)


def claimed_front(content: bytes, rng: Random) -> bytes:
    """A design that is off the front is put on it."""
    members = members_of(content)
    kind = rng.choice([Claim.DOMINATED, Claim.CONSTRAINT, Claim.LACKING, Claim.UNFIT, Claim.FAILED, Claim.MISSING])
    row = rng.choice(_rows(members, kind))
    _put(members, "claim", row, Claim.FRONT)
    _put(members, "by", row, 0)
    return digested(members)


def taken_off_front(content: bytes, rng: Random) -> bytes:
    """A design of the front is said to be dominated, to break a constraint, to lack an objective, or missing."""
    members = members_of(content)
    row = rng.choice(_rows(members, Claim.FRONT))
    kind = rng.choice([Claim.DOMINATED, Claim.CONSTRAINT, Claim.LACKING, Claim.SAME, Claim.FAILED, Claim.MISSING])
    _put(members, "claim", row, kind)
    _put(members, "by", row, row if kind == Claim.SAME else 0)
    return digested(members)


def row_gone(content: bytes, rng: Random) -> bytes:
    """A design is in no entry."""
    members = members_of(content)
    head = json.loads(members[HEAD])
    row = rng.choice([row for row in range(head["rows"]) if array(members["claim.npy"])[row] != Claim.FRONT])
    for name in ("design", "claim", "task", "figures", "budgets"):
        values = array(members[f"{name}.npy"])
        members[f"{name}.npy"] = array_bytes(np.ascontiguousarray(np.delete(values, row, axis=-1)))
    claims = array(members["claim.npy"])
    by = np.delete(array(members["by.npy"]), row)
    rows = np.isin(claims, [Claim.DOMINATED, Claim.SAME]) & (by > row)
    members["by.npy"] = array_bytes((by - rows).astype("<i4"))
    head["rows"] -= 1
    members[HEAD] = json.dumps(head).encode()
    return digested(members)


def row_twice(content: bytes, rng: Random) -> bytes:
    """A design is in two rows."""
    members = members_of(content)
    designs = array(members["design.npy"])
    first, second = rng.sample(range(len(designs)), 2)
    _put(members, "design", first, designs[second])
    return digested(members)


def row_outside(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    row = rng.randrange(len(array(members["design.npy"])))
    _put(members, "design", row, rng.choice([-1, 72, 10**9, -(2**63), 2**63 - 1]))
    return digested(members)


def figure_made_worse(content: bytes, rng: Random) -> bytes:
    """A design of the front has a figure by which others that are better are no longer dominated, or it is none."""
    members = members_of(content)
    row = rng.choice(_rows(members, Claim.FRONT))
    worse = rng.choice([[1e9, 79, 1e9], [np.inf, 79, np.inf], [1, 1e9, 1], [1, 20, np.nan]])
    _put(members, "figures", (slice(None), row), worse)
    return digested(members)


def figure_made_better(content: bytes, rng: Random) -> bytes:
    """A design that is dominated has figures by which it is not."""
    members = members_of(content)
    _put(members, "figures", (rng.randrange(3), rng.choice(_rows(members, Claim.DOMINATED))), -1.0)
    return digested(members)


def sense_swapped(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    definition = json.loads(members[DEFINITION])
    objective = rng.choice(definition["objectives"])
    swap = {"minimise": "maximise", "maximise": "minimise"}
    objective["direction"] = swap[objective["direction"]]
    if rng.random() < 0.5:
        figure = definition["figures"][objective["figure"]]
        figure["best"] = {"least": "greatest", "greatest": "least"}[figure["best"]]
    return digested({**members, DEFINITION: json.dumps(definition).encode()})


def limit_moved(content: bytes, rng: Random) -> bytes:
    """A limit by which a design of the front is out, or one that was out is in."""
    members = members_of(content)
    definition = json.loads(members[DEFINITION])
    definition["constraints"][0]["limit"] = rng.choice([5.0, 1e6])
    return digested({**members, DEFINITION: json.dumps(definition).encode()})


def objective_named_wrongly(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    definition = json.loads(members[DEFINITION])
    key = rng.choice(["objectives", "constraints"])
    rng.choice(definition[key])["figure"] = rng.choice([-1, 3, 10**30])
    return digested({**members, DEFINITION: json.dumps(definition).encode()})


def space_changed(content: bytes, rng: Random) -> bytes:
    """Values of an axis more or less, another condition of an axis, or other parts."""
    members = members_of(content)
    definition, head = json.loads(members[DEFINITION]), json.loads(members[HEAD])
    kind = rng.randrange(5)
    if kind == 0:
        definition["axes"][rng.randrange(1, 4)]["values"].append("more")
    elif kind == 1:
        definition["axes"][rng.randrange(4)]["values"].pop()
    elif kind == 2:
        other = [{}, {"a.b": [0]}, {"a.b": [0, 1]}, {"a.c": [1]}, {"a.b": [-1]}, {"x": [0]}]
        definition["axes"][3]["when"] = rng.choice(other)
    elif kind == 3:
        head["parts"].pop(rng.randrange(2))
    else:
        part = rng.choice(head["parts"])
        part[rng.choice(list(part))].append(rng.choice([0, 9, -1]))
    return digested({**members, DEFINITION: json.dumps(definition).encode(), HEAD: json.dumps(head).encode()})


def box_moved(content: bytes, rng: Random) -> bytes:
    """A box holds designs that it did not, or holds no longer some that it did."""
    members = members_of(content)
    name = rng.choice(["low", "high"])
    values = array(members[f"{name}.npy"])
    place = rng.randrange(len(values)), rng.randrange(values.shape[1])
    _put(members, name, place, values[place] + rng.choice([-1, 1, 2**30, -(2**30)]))
    return digested(members)


def box_in_another_part(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    parts = array(members["part.npy"])
    _put(members, "part", rng.randrange(len(parts)), rng.choice([-1, 0, 2, 2**31 - 1]))
    return digested(members)


def bound_made_better(content: bytes, rng: Random) -> bytes:
    """The bound of a box is one that nothing dominates, keeps the constraint, or is not given."""
    members = members_of(content)
    box = rng.choice(_boxes(members, Claim.DOMINATED) + _boxes(members, Claim.CONSTRAINT))
    figure = 1 if box in _boxes(members, Claim.CONSTRAINT) else rng.randrange(3)
    _put(members, "figures", (figure, box), rng.choice([-1.0, np.nan]))
    return digested(members)


def box_claims_more(content: bytes, rng: Random) -> bytes:
    """A box claims what only a design can, or what there is not."""
    members = members_of(content)
    rows = json.loads(members[HEAD])["rows"]
    kinds = [Claim.FRONT, Claim.SAME, Claim.LACKING, Claim.UNREACHED, Claim.FAILED, 9, 255]
    _put(members, "claim", rng.randrange(rows, rows + 4), rng.choice(kinds))
    return digested(members)


def reason_passed_by_nothing(content: bytes, rng: Random) -> bytes:
    members = members_of(content)
    reason = rng.randrange(len(array(members["demand.npy"])))
    _put(members, "demand", reason, rng.choice([0.0, -1.0, np.nan]))
    return digested(members)


def _same_but(content: bytes, rng: Random, column: str, value: float) -> bytes:
    """A design says that it is the same as one that is on the front and has its figures, and differs in a column."""
    members = members_of(content)
    head, designs = json.loads(members[HEAD]), array(members["design.npy"])
    first = _rows(members, Claim.FRONT)[0]
    row = rng.choice([row for row in _rows(members, Claim.DOMINATED) if designs[row] > designs[first]])
    _put(members, "claim", row, Claim.SAME)
    _put(members, "by", row, first)
    for name in ("figures", "task", "budgets"):
        _put(members, name, (..., row), array(members[f"{name}.npy"])[..., first])
    _put(members, column, (..., row), value)
    head["tasks"].append("another")
    return digested({**members, HEAD: json.dumps(head).encode()})


def same_of_another_task(content: bytes, rng: Random) -> bytes:
    return _same_but(content, rng, "task", 1)


def same_with_other_budgets(content: bytes, rng: Random) -> bytes:
    return _same_but(content, rng, "budgets", rng.choice([200.0, 0.0, np.nan]))


def same_as_what_failed(content: bytes, rng: Random) -> bytes:
    """A design that was not computed counts where another one failed: none is missing."""
    members = members_of(content)
    _put(members, "by", _rows(members, Claim.MISSING), _rows(members, Claim.FAILED)[0])
    _put(members, "claim", _rows(members, Claim.MISSING), Claim.SAME)
    return digested(members)


def unfit_by_another(content: bytes, rng: Random) -> bytes:
    """A design is unfit by a demand that is not its own."""
    members = members_of(content)
    row = rng.choice(_rows(members, Claim.DOMINATED) + _rows(members, Claim.LACKING))
    _put(members, "claim", row, Claim.UNFIT)
    _put(members, "by", row, array(members["by.npy"])[_rows(members, Claim.UNFIT)[0]])
    return digested(members)


def unfit_at_another_limit(content: bytes, rng: Random) -> bytes:
    """A design is unfit by a limit that is not the budget of its part."""
    members = members_of(content)
    reason = array(members["by.npy"])[rng.choice(_rows(members, Claim.UNFIT))]
    _put(members, "limit", reason, rng.choice([99.0, 1.0]))
    return digested(members)


Tamper = Callable[[bytes, Random], bytes]

BYTES: list[Tamper] = [flip, cut, drop, insert]
MEMBERS: list[Tamper] = [
    member_flip, member_cut, member_gone, member_more, members_moved, huge, bomb, pickled, head_changed,
    value_changed, bytes_before, bytes_after, bytes_between, bytes_in_entry,
]  # fmt: skip
CLAIMS: list[Tamper] = [
    named_wrongly, task_of_no_name, claimed_front, taken_off_front, row_gone, row_twice, row_outside, figure_made_worse,
    figure_made_better, sense_swapped, limit_moved, objective_named_wrongly, space_changed, box_moved,
    box_in_another_part, bound_made_better, box_claims_more, reason_passed_by_nothing,
    same_of_another_task, same_with_other_budgets, same_as_what_failed, unfit_by_another, unfit_at_another_limit,
]  # fmt: skip
ALL = [*BYTES, *MEMBERS, *CLAIMS]


def sample_file(seed: int = 0) -> bytes:
    return packed(certificate_of(*sample(seed)))
