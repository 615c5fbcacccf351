"""Digests of the messages of each trace but its summary: `traces.py OUT BEFORE`."""

import sys, subprocess, hashlib, json
from pathlib import Path
from mcap.reader import make_reader

out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)
pairs = [p.stem for p in sorted(Path(sys.argv[2]).glob("*.trace"))]
for name in pairs:
    f = out / f"{name}.txt"
    if f.exists():
        continue
    p, w = name.split("--")
    t = out / "x.mcap"
    subprocess.run(
        [sys.executable, "-m", "codesign", "run", p, w, "--json", "--no-levers", "--trace", str(t)],
        capture_output=True,
    )
    h = {}
    n = 0
    with t.open("rb") as s:
        for schema, ch, m in make_reader(s).iter_messages(log_time_order=False):
            rec = ch.metadata.get("record", "")
            if rec == "SummaryRecord" or "ummary" in ch.topic:
                continue
            n += 1
            h.setdefault(ch.topic, hashlib.sha256()).update(b"%d %d " % (m.log_time, m.sequence) + m.data)
    f.write_text(json.dumps({"n": n, **{k: v.hexdigest()[:20] for k, v in sorted(h.items())}}, indent=0))
    t.unlink()
