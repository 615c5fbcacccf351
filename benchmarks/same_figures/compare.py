"""Results before and after, field by field: `compare.py BEFORE AFTER`; renamed fields stand in `old`."""

import json, re, sys
from pathlib import Path

B, A = Path(sys.argv[1]), Path(sys.argv[2])


def flat(v, p=""):
    if isinstance(v, dict):
        for k, x in v.items():
            yield from flat(x, f"{p}.{k}")
    elif isinstance(v, list):
        for i, x in enumerate(v):
            yield from flat(x, f"{p}[{i}]")
    else:
        yield p, v


PS = re.compile(r"_ps$")


def old(p, v):
    """old path/value -> new"""
    if PS.search(p) and isinstance(v, int):
        return PS.sub("_s", p), v / 1e12
    if re.match(r'\.processor\["?|\.processor\..*\.(value|low|high)$', p):
        return p, v
    p = p.replace(".energy.total_j", ".energy.energy_j") if p.startswith(".energy") else p
    p = re.sub(r"^\.mission\.time_s$", ".mission.mission_time_s", p)
    p = p.replace(".mission.energy.total_j", ".mission.energy.mission_energy_j")
    m = re.match(r"(\.resources\[\d+\]\.items\[\d+\])\.(amount|status|source)$", p)
    if m:
        p = m[1] + ".figure." + {"amount": "value"}.get(m[2], m[2])
    return p, v


n = bad = 0
kinds = {}
for o in sorted(B.glob("*--*.json")):
    if o.name.startswith("explore"):
        continue
    a, b = o.read_text(), (A / o.name).read_text()
    n += 1
    ha, _, ra = a.partition("\n")
    hb, _, rb = b.partition("\n")
    if ha != hb:
        print(o.name, "EXIT", ha, hb, rb[:200])
        bad += 1
        continue
    try:
        x = json.loads(ra.strip().split("\n")[0] if not ra.strip().startswith("{\n") else ra)
    except ValueError:
        try:
            x = json.JSONDecoder().raw_decode(ra.strip())[0]
        except ValueError:
            x = None
    try:
        y = json.JSONDecoder().raw_decode(rb.strip())[0]
    except ValueError:
        y = None
    if x is None or y is None:
        if x is None and y is None:
            kinds["text"] = kinds.get("text", 0) + 1
            kinds["textsame"] = kinds.get("textsame", 0) + (ra == rb)
        else:
            print(o.name, "JSON?", x is None, y is None)
        continue
    fx = dict(old(p, v) for p, v in flat(x))
    fy = dict(flat(y))
    diffs = []
    for p, v in fx.items():
        w = fy.get(p, "<absent>")
        if v != w:
            if (
                isinstance(v, (int, float))
                and isinstance(w, (int, float))
                and p.startswith(".processor")
                and abs(v / 1e12 - w) <= 1e-12 * abs(w)
            ):
                continue
            if p.startswith(".processor") and p.endswith(".unit") and (v, w) == ("ps", "s"):
                continue
            if p == ".schema_version":
                continue
            diffs.append((p, v, w))
    new = [p for p in fy if p not in fx and not re.search(r"\.(unit|low|high)$", p)]
    if diffs or new:
        bad += 1
        print(o.name, len(diffs), "diffs", len(new), "new")
        for d in diffs[:6]:
            print("   ", str(d)[:260])
        for d in new[:4]:
            print("   + ", d, fy[d])
print(n, "pairs", bad, "differ", kinds)
t = s = 0
for o in sorted(B.glob("*.trace")):
    t += 1
    s += o.read_text() == (A / o.name).read_text() if (A / o.name).exists() else 0
    if not (A / o.name).exists() or o.read_text() != (A / o.name).read_text():
        print(
            "trace",
            o.name,
            o.read_text().strip()[:20],
            (A / o.name).read_text().strip()[:20] if (A / o.name).exists() else None,
        )
print(t, "traces", s, "same")
