// Filters on figures (two sliders over the values that are attained) and on axes (a box for each level).
const BOXES = 40;

const makeFilters = (study, points, state, act) => {
  const rows = new Map();
  const frame = () => (state.view === "facets" ? 0 : state.view);
  const note = (key, kept) => { if (kept === null) state.filters.delete(key); else state.filters.set(key, kept); act.changed(); };

  const figureRow = (key) => {
    const id = `f:${key}`, name = points.dimension(id, 0).name;
    const row = made("div", undefined, { class: "filter", role: "group", "aria-label": name });
    const label = made("span", name, { class: "name" });
    const low = made("input", undefined, { type: "range", min: "0", "aria-label": `least ${name}` });
    const high = made("input", undefined, { type: "range", min: "0", "aria-label": `most ${name}` });
    const told = made("output");
    let values = [];
    const at = (slider) => values[Math.round(Number(slider.value) / Number(slider.max) * (values.length - 1))];
    const moved = (slider, other) => {
      if (Number(low.value) > Number(high.value)) other.value = slider.value;
      const whole = Number(low.value) === 0 && Number(high.value) === Number(high.max);
      note(id, whole ? null : [at(low), at(high)]);
    };
    low.addEventListener("input", () => moved(low, high));
    high.addEventListener("input", () => moved(high, low));
    const best = button("only best", () => {
      const { values: all } = points.dimension(id, frame());
      const place = points.best(id, frame(), points.passing(frame(), state.filters, state.all, id));
      if (place !== null) note(id, [all[place], all[place]]);
    }, { "aria-label": `only best: ${name}` });
    const open = button("go to best", () => {
      const place = points.best(id, frame(), points.passing(frame(), state.filters, state.all));
      if (place !== null) act.open(place);
    }, { "aria-label": `go to best: ${name}` });
    row.append(label, low, high, told, best, open);
    const fill = () => {
      const each = points.dimension(id, frame());
      label.textContent = each.name;
      values = points.attained(id, frame(), state.all);
      const last = Math.max(1, Math.min(values.length - 1, 1000));
      low.max = high.max = String(last);
      const kept = state.filters.get(id);
      const before = (value) => { let k = values.findIndex((own) => own >= value); if (k < 0) k = values.length - 1; return k; };
      const slide = (value) => String(Math.round(before(value) / Math.max(1, values.length - 1) * last));
      low.value = kept ? slide(kept[0]) : "0";
      high.value = kept ? slide(kept[1]) : String(last);
      row.classList.toggle("active", Boolean(kept));
      const ends = kept ?? [values[0], values[values.length - 1]];
      const [from, to] = ends.map((end) => (end === undefined ? "–" : each.write(end)));
      told.textContent = from === to ? from : `${from} to ${to}`;
      for (const part of [low, high, best, open]) part.disabled = !values.length;
      low.setAttribute("aria-valuetext", from);
      high.setAttribute("aria-valuetext", to);
    };
    rows.set(id, fill);
    return row;
  };

  const axisRow = (axis) => {
    const id = `a:${axis.key}`, count = axis.levels.length;
    const row = made("fieldset", undefined, { class: "filter levels" });
    row.append(made("legend", axis.name));
    if (count > BOXES) {
      const slider = (name, value) => made("input", undefined, { type: "range", min: "0", max: String(count - 1), value: String(value), "aria-label": `${name} ${axis.name}` });
      const low = slider("first", 0), high = slider("last", count - 1), told = made("output");
      const moved = () => {
        const from = Math.min(Number(low.value), Number(high.value)), to = Math.max(Number(low.value), Number(high.value));
        note(id, from === 0 && to === count - 1 ? null : new Set(axis.levels.map((_, k) => k).filter((k) => k >= from && k <= to)));
      };
      for (const each of [low, high]) each.addEventListener("input", moved);
      row.append(low, high, told);
      rows.set(id, () => {
        const kept = state.filters.get(id), levels = kept ? [...kept].sort((a, b) => a - b) : [0, count - 1];
        row.classList.toggle("active", Boolean(kept));
        const from = levels[0] ?? 0, to = levels[levels.length - 1] ?? 0;
        low.value = String(from);
        high.value = String(to);
        told.textContent = `${axis.levels[from]} to ${axis.levels[to]}`;
      });
      return row;
    }
    const boxes = axis.levels.map((text, level) => {
      const label = made("label"), box = made("input", undefined, { type: "checkbox" });
      box.addEventListener("change", () => {
        const kept = new Set(boxes.flatMap((each, k) => (each.checked ? [k] : [])));
        note(id, kept.size === count ? null : kept);
      });
      label.append(box, ` ${text}`);
      // A click on the name of a level keeps this one alone.
      row.append(label, button("only", () => note(id, new Set([level])), { "aria-label": `only ${axis.name} ${text}`, class: "only" }));
      return box;
    });
    rows.set(id, () => {
      const kept = state.filters.get(id);
      row.classList.toggle("active", Boolean(kept));
      boxes.forEach((box, level) => { box.checked = !kept || kept.has(level); });
    });
    return row;
  };

  byId("filter-figures").append(...points.main.map(figureRow));
  byId("filter-axes").append(...study.axes.map(axisRow));
  const more = byId("filter-more");
  more.hidden = !points.others.length;
  more.addEventListener("toggle", () => {
    if (more.open && !byId("filter-others").childElementCount) {
      byId("filter-others").append(...points.others.map(figureRow));
      refresh();
    }
  });

  /** What is filtered, in words. */
  const words = () => [...state.filters].map(([key, kept]) => {
    const each = points.dimension(key, frame());
    if (kept instanceof Set) return `${each.name} ${[...kept].sort((a, b) => a - b).map((level) => each.levels[level]).join(", ") || "none"}`;
    const [low, high] = kept.map(each.write);
    return low === high ? `${each.name} ${low}` : `${each.name} ${low} to ${high}`;
  }).join("; ");
  const refresh = () => { for (const fill of rows.values()) fill(); };
  // A figure behind "more figures" that the address filters by is to be seen.
  if (points.others.some((key) => state.filters.has(`f:${key}`))) more.open = true;
  return { refresh, words };
};
