"use strict";
// Places what the page's data says: every figure, text and front was worked out before.
(() => {
  const byId = (id) => document.getElementById(id);
  const read = (id) => JSON.parse(byId(id).textContent);
  const views = read("study-data").views;
  // The page is loaded again to show another condition: nothing of the view before is left over.
  const asked = Number(new URLSearchParams(location.hash.slice(1)).get("view"));
  const shown = views[asked] ? asked : 0;
  const data = views[shown];
  const plots = byId("study-plots") ? read("study-plots") : null;
  const count = data.points.length;
  const everyPlace = [...Array(count).keys()];
  const ramp = ["#46327e", "#3b528b", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#e5d71f"];
  const hues = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#b3a800", "#7a7f87"];
  const chosen = new Set();

  const made = (name, text, attributes = {}) => {
    const element = document.createElement(name);
    if (text !== undefined) element.textContent = text;
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return element;
  };

  const chooseView = byId("choose-view");
  for (const view of views) chooseView.append(made("option", view.name));
  chooseView.selectedIndex = shown;
  chooseView.addEventListener("change", () => {
    location.hash = `view=${chooseView.selectedIndex}`;
    location.reload();
  });

  // ---- table of all points ----
  const columns = [
    { name: views.length > 1 ? "design" : "point", right: true, text: (i) => String(data.points[i]), sortable: (i) => data.points[i] },
    ...data.axes.map((axis) => ({
      name: axis.name, text: (i) => axis.levels[axis.level[i]], sortable: (i) => axis.level[i],
    })),
    ...data.figures.map((figure) => ({
      name: figure.name, right: true, text: (i) => figure.texts[i], sortable: (i) => figure.values[i],
    })),
    { name: "front", text: (i) => (data.front[i] ? "yes" : ""), sortable: (i) => -data.front[i] },
    { name: "why not", text: (i) => data.whys[data.why[i]], sortable: (i) => data.whys[data.why[i]] },
  ];
  const filters = [
    ["feasible", (i) => data.feasible[i]],
    ["on the front", (i) => data.front[i]],
    ["chosen", (i) => chosen.has(i)],
    ["not feasible", (i) => !data.feasible[i]],
    ["all", () => true],
  ];
  const pageSize = 25;
  let sort = { column: 0, down: false };
  let page = 0;

  const compare = (a, b) => {
    // A point without the figure comes last, whichever way the table is sorted.
    if (a === null || b === null) return (a === null) - (b === null);
    const order = a < b ? -1 : a > b ? 1 : 0;
    return sort.down ? -order : order;
  };

  const listed = () => {
    const keep = filters[byId("choose-rows").selectedIndex][1];
    const key = columns[sort.column].sortable;
    return everyPlace.filter(keep).sort((i, j) => compare(key(i), key(j)) || i - j);
  };

  const drawTable = () => {
    const rows = listed();
    const pages = Math.max(1, Math.ceil(rows.length / pageSize));
    page = Math.min(page, pages - 1);
    const head = made("tr");
    columns.forEach((column, number) => {
      const cell = made("th", undefined, { scope: "col", class: column.right ? "right" : "left" });
      const sorted = number === sort.column;
      cell.setAttribute("aria-sort", sorted ? (sort.down ? "descending" : "ascending") : "none");
      const button = made("button", column.name + (sorted ? (sort.down ? " ▼" : " ▲") : ""), { type: "button" });
      button.addEventListener("click", () => {
        sort = { column: number, down: sorted && !sort.down };
        page = 0;
        drawTable();
        byId("points").querySelectorAll("th button")[number].focus({ preventScroll: true });
      });
      cell.append(button);
      head.append(cell);
    });
    const body = made("tbody");
    for (const i of rows.slice(page * pageSize, (page + 1) * pageSize)) {
      const row = made("tr");
      row.classList.toggle("chosen", chosen.has(i));
      columns.forEach((column, number) => {
        const cell = made("td", undefined, { class: column.right ? "right" : "left" });
        cell.classList.toggle("short", column.text(i).length <= 28);
        if (number === 0 && plots && data.feasible[i]) {
          const button = made("button", column.text(i), { type: "button", "aria-pressed": String(chosen.has(i)), "data-place": i });
          button.title = "show in the plot";
          button.addEventListener("click", () => {
            if (!chosen.delete(i)) chosen.add(i);
            drawTable();
            byId("points").querySelector(`[data-place="${i}"]`)?.focus({ preventScroll: true });
            showChosen();
          });
          cell.append(button);
        } else {
          cell.textContent = column.text(i);
        }
        row.append(cell);
      });
      body.append(row);
    }
    const headRow = made("thead");
    headRow.append(head);
    byId("points").replaceChildren(headRow, body);
    byId("row-count").textContent = `${rows.length} ${views.length > 1 ? "designs" : "points"}, page ${page + 1} of ${pages}`;
    byId("earlier").disabled = page === 0;
    byId("later").disabled = page >= pages - 1;
  };

  for (const [name] of filters) byId("choose-rows").append(made("option", name));
  byId("choose-rows").selectedIndex = plots ? 0 : 3;
  byId("choose-rows").addEventListener("change", () => { page = 0; drawTable(); });
  byId("earlier").addEventListener("click", () => { page -= 1; drawTable(); });
  byId("later").addEventListener("click", () => { page += 1; drawTable(); });
  if (data.left_out) {
    byId("left-out").hidden = false;
    byId("left-out").textContent =
      `${data.left_out} more points are in the CSV and the JSON; every point of the front is here.`;
  }

  // ---- plot ----
  let showChosen = () => {};
  drawTable();
  if (!plots) return;

  const x = byId("choose-x");
  const y = byId("choose-y");
  const colour = byId("choose-colour");
  data.figures.forEach((figure) => {
    for (const select of [x, y, colour]) select.append(made("option", figure.name));
  });
  data.axes.forEach((axis) => colour.append(made("option", axis.name)));
  x.selectedIndex = 0;
  y.selectedIndex = 1;
  // The figure that the first two say least about: the last objective, where there are more than two.
  colour.selectedIndex = data.figures.length > 2 ? data.figures.length - 1 : 0;

  const blend = (share) => {
    const place = share * (ramp.length - 1);
    const low = Math.min(Math.floor(place), ramp.length - 2);
    const part = (text, k) => parseInt(text.slice(1 + 2 * k, 3 + 2 * k), 16);
    const mix = (k) => Math.round(part(ramp[low], k) + (place - low) * (part(ramp[low + 1], k) - part(ramp[low], k)));
    return `rgb(${mix(0)},${mix(1)},${mix(2)})`;
  };

  const colouring = () => {
    const number = colour.selectedIndex;
    const key = byId("key");
    if (number >= data.figures.length) {
      const axis = data.axes[number - data.figures.length];
      const few = axis.levels.length <= hues.length;
      const hue = (level) => (few ? hues[level] : blend(level / (axis.levels.length - 1)));
      const shown = few ? axis.levels : [axis.levels[0], axis.levels[axis.levels.length - 1]];
      key.replaceChildren(made("span", axis.name), ...shown.map((text) => {
        const entry = made("span");
        const dot = made("i");
        dot.style.background = hue(axis.levels.indexOf(text));
        entry.append(dot, text);
        return entry;
      }));
      return (i) => hue(axis.level[i]);
    }
    const figure = data.figures[number];
    const known = everyPlace.filter((i) => data.feasible[i] && figure.values[i] !== null);
    if (!known.length) { key.replaceChildren(); return () => hues[7]; }
    const byValue = known.slice().sort((i, j) => figure.values[i] - figure.values[j]);
    const [first, last] = [byValue[0], byValue[byValue.length - 1]];
    const scale = figure.logarithm ? Math.log : (value) => value;
    const low = scale(figure.values[first]);
    const span = scale(figure.values[last]) - low;
    const strip = made("span", "", { class: "ramp" });
    strip.style.background = `linear-gradient(to right, ${ramp.join(", ")})`;
    key.replaceChildren(
      made("span", `${figure.name}${figure.logarithm ? " (logarithmic)" : ""}`),
      made("span", figure.texts[first]), strip, made("span", figure.texts[last]),
    );
    return (i) => {
      if (figure.values[i] === null) return hues[7];
      return blend(span > 0 ? (scale(figure.values[i]) - low) / span : 0.5);
    };
  };

  let drawing = Promise.resolve();
  let current = null;

  const dress = () => {
    if (!current) return;
    const style = getComputedStyle(document.documentElement);
    const tone = (name) => style.getPropertyValue(name).trim();
    const { plot, bound } = current;
    for (const axis of [...plot.below, ...plot.left]) {
      axis.setv({
        axis_label_text_color: tone("--ink"), major_label_text_color: tone("--soft"), axis_line_color: tone("--line"),
        major_tick_line_color: tone("--line"), minor_tick_line_color: tone("--line"),
        axis_label_text_font_style: "normal",
      });
    }
    for (const item of plot.center) if ("grid_line_color" in item) item.grid_line_color = tone("--line");
    plot.outline_line_color = tone("--line");
    bound.glyph.line_color = tone("--soft");
  };

  const fill = (view) => {
    const [first, second] = [data.figures[x.selectedIndex], data.figures[y.selectedIndex]];
    const places = everyPlace.filter(
      (i) => data.feasible[i] && first.values[i] !== null && second.values[i] !== null);
    // Points of the front are drawn last, so that they lie on top.
    places.sort((i, j) => data.front[i] - data.front[j] || i - j);
    const shade = colouring();
    const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
    const filled = {
      x: places.map((i) => first.values[i]), y: places.map((i) => second.values[i]),
      colour: places.map(shade), size: places.map((i) => (data.front[i] ? 13 : 8)),
      edge: places.map((i) => (data.front[i] ? ink : "rgba(0,0,0,0)")),
      alpha: places.map((i) => (data.front[i] ? 1 : 0.6)), point: places.map((i) => data.points[i]),
    };
    data.axes.forEach((axis, n) => { filled[`axis${n}`] = places.map((i) => axis.levels[axis.level[i]]); });
    data.figures.forEach((figure, n) => { filled[`figure${n}`] = places.map((i) => figure.texts[i]); });
    view.places = places;
    view.points.data = filled;
    const line = x.selectedIndex === y.selectedIndex ? [] : data.fronts[`${x.selectedIndex},${y.selectedIndex}`];
    view.boundary.data = { x: line.map((i) => first.values[i]), y: line.map((i) => second.values[i]) };
    // A larger x can stand in for a smaller one only where more of it is better: the corner lies on the other side.
    view.bound.glyph.mode = first.maximise ? "before" : "after";
    view.plot.below[0].axis_label = first.label;
    view.plot.left[0].axis_label = second.label;
  };

  const embed = async () => {
    const scale = (box) => (byId(box).checked ? "log" : "linear");
    const item = plots[`${scale("log-x")},${scale("log-y")}`];
    byId("plot").replaceChildren();
    const views = await Bokeh.embed.embed_item(item, "plot");
    const plot = [...views][0].model;
    const named = (name) => plot.document.get_model_by_name(name);
    current = {
      plot, points: named("points"), boundary: named("bound"), bound: named("bound_line"), places: [],
    };
    fill(current);
    dress();
    showChosen();
    current.points.selected.properties.indices.change.connect(() => {
      const picked = current.points.selected.indices.map((k) => current.places[k]);
      if (picked.length === chosen.size && picked.every((i) => chosen.has(i))) return;
      chosen.clear();
      picked.forEach((i) => chosen.add(i));
      byId("choose-rows").selectedIndex = chosen.size ? 2 : 0;
      page = 0;
      drawTable();
    });
  };

  showChosen = () => {
    if (!current) return;
    const indices = current.places.flatMap((i, k) => (chosen.has(i) ? [k] : []));
    current.points.selected.indices = indices;
  };

  const redraw = () => { drawing = drawing.then(embed); };
  const suit = (box, select) => {
    const figure = data.figures[select.selectedIndex];
    const positive = figure.values.every((value, i) => !data.feasible[i] || value === null || value > 0);
    byId(box).checked = figure.logarithm && positive;
    byId(box).disabled = !positive;
  };
  x.addEventListener("change", () => { suit("log-x", x); redraw(); });
  y.addEventListener("change", () => { suit("log-y", y); redraw(); });
  colour.addEventListener("change", redraw);
  byId("log-x").addEventListener("change", redraw);
  byId("log-y").addEventListener("change", redraw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  suit("log-x", x);
  suit("log-y", y);
  redraw();
})();
