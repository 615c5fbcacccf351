// The table of the points that pass the filters; cards where the page is narrow.
const PAGE = 25;
const ROWS = ["feasible", "front", "chosen", "infeasible", "all"];
const ROW_NAMES = ["feasible", "on the front", "marked", "not feasible", "all"];

const makeTable = (study, points, state, act) => {
  let sort = { key: "point", down: false };
  let page = 0;
  const table = byId("points");
  const frame = () => (state.view === "facets" ? 0 : state.view);

  const columns = () => {
    const { why, front } = study.frames[frame()];
    const dimension = (key) => {
      const each = points.dimension(key, frame());
      return { key, name: each.name, right: !each.levels, text: each.text, value: (i) => each.values[i] };
    };
    const figures = new Set(points.main.map((key) => `f:${key}`));
    for (const key of [state.x, state.y, state.colour, state.shape, ...state.filters.keys()]) if (key.startsWith("f:")) figures.add(key);
    return [
      { key: "point", name: study.kind, right: true, text: (i) => String(study.points[i]), value: (i) => study.points[i] },
      ...study.axes.map((axis) => dimension(`a:${axis.key}`)), ...[...figures].map(dimension),
      { key: "front", name: "front", text: (i) => (front[i] ? "yes" : ""), value: (i) => -front[i] },
      { key: "why", name: "why not", text: (i) => study.whys[why[i]], value: (i) => why[i] },
    ];
  };

  const listed = (column) => {
    const { feasible, front } = study.frames[frame()];
    const keep = {
      feasible: (i) => feasible[i], front: (i) => front[i], chosen: (i) => state.chosen.has(i),
      infeasible: (i) => !feasible[i], all: () => true,
    }[state.rows];
    const passed = points.passing(frame(), state.filters, true);
    const places = [];
    for (let i = 0; i < points.count; i += 1) if (passed[i] && keep(i)) places.push(i);
    if (sort.key === "point" && !sort.down) return places;
    const turn = sort.down ? -1 : 1;
    // A point without the figure comes last, whichever way the table is sorted.
    return places.sort((i, j) => {
      const a = column.value(i), b = column.value(j);
      if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b) || i - j;
      return turn * (a - b) || i - j;
    });
  };

  const headOf = (all) => {
    const head = made("tr");
    all.forEach((column) => {
      const sorted = column.key === sort.key;
      const cell = made("th", undefined, { scope: "col", class: column.right ? "right" : "left", "aria-sort": sorted ? (sort.down ? "descending" : "ascending") : "none" });
      cell.append(button(column.name + (sorted ? (sort.down ? " ▼" : " ▲") : ""), () => {
        sort = { key: column.key, down: sorted && !sort.down };
        page = 0;
        draw();
        table.querySelector(`th [data-key="${CSS.escape(column.key)}"]`)?.focus({ preventScroll: true });
      }, { "data-key": column.key }));
      head.append(cell);
    });
    return head;
  };

  const draw = () => {
    const all = columns();
    const column = all.find((each) => each.key === sort.key) ?? all[0];
    const rows = listed(column);
    const pages = Math.max(1, Math.ceil(rows.length / PAGE));
    page = Math.min(page, pages - 1);
    const body = made("tbody");
    for (const i of rows.slice(page * PAGE, (page + 1) * PAGE)) {
      const row = made("tr");
      row.classList.toggle("chosen", state.chosen.has(i));
      row.classList.toggle("current", state.current === i);
      all.forEach((each, number) => {
        const text = each.text(i);
        const cell = made("td", number ? text : undefined, { class: each.right ? "right" : "left", "data-label": each.name });
        cell.classList.toggle("short", text.length <= 28);
        if (!number) cell.append(button(text, () => act.open(i), { "data-place": i, title: "show its details" }));
        row.append(cell);
      });
      body.append(row);
    }
    const head = made("thead");
    head.append(headOf(all));
    table.replaceChildren(head, body);
    byId("row-count").textContent = `${rows.length.toLocaleString("en")} ${study.kind}${rows.length === 1 ? "" : "s"}, page ${page + 1} of ${pages}`;
    byId("earlier").disabled = page === 0;
    byId("later").disabled = page >= pages - 1;
  };

  const choose = byId("choose-rows");
  ROW_NAMES.forEach((name, k) => choose.append(made("option", name, { value: ROWS[k] })));
  choose.addEventListener("change", () => { state.rows = choose.value; page = 0; act.told(); draw(); });
  byId("earlier").addEventListener("click", () => { page -= 1; draw(); });
  byId("later").addEventListener("click", () => { page += 1; draw(); });
  return { draw: () => { choose.value = state.rows; draw(); }, first: () => { page = 0; } };
};
