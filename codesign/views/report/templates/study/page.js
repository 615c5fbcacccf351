// The page of a study: what the reader chooses is kept in the state, and everything is drawn from it.
const PAPER = 900;
const begin = async () => {
  performance.mark("page begins");
  const head = JSON.parse(byId("study-data").textContent);
  const study = await readStudy(head, head.columns);
  const numbers = makeNumbers(head.scales);
  const points = makePoints(study, numbers);
  performance.measure("read", "page begins");
  const anyFeasible = study.frames[0].feasible.includes(1);
  const main = points.main.map((key) => `f:${key}`);
  const placeOf = new Map(Array.from(study.points, (number, i) => [String(number), i]));
  const { state, read, write, reset } = makeState({
    x: main[0], y: main[1], colour: main[main.length > 2 ? main.length - 1 : 0],
    all: !anyFeasible, dimensions: points.keys, rows: ROWS, views: study.frames.length,
    place: (text) => placeOf.get(text) ?? null, number: (i) => study.points[i],
  });
  read();
  const plot = byId("plot");
  let scatters = [];
  let printing = false;
  const frames = () => (state.view !== "facets" ? [state.view] : study.frames.map((_, k) => k).slice(1));
  const say = (text) => { byId("said").textContent = text; };

  // ---- drawing ----
  const tick = (dimension) => {
    if (dimension.levels) return (value) => { const text = dimension.levels[value] ?? ""; return text.length > 18 ? `${text.slice(0, 17)}…` : text; };
    return (value) => dimension.write(value);
  };
  const placed = (key, wantsLog, shown, zoom) => {
    const dimensions = frames().map((frame) => points.dimension(key, frame));
    const { low, high, positive, wantsLogarithm } = points.extent(dimensions, shown);
    const log = !dimensions[0].levels && positive && (wantsLog ?? wantsLogarithm);
    let range = zoom ?? [low, high];
    if (!zoom) {
      if (!(low <= high)) range = log ? [1, 10] : [0, 1];
      else if (dimensions[0].levels) range = [-0.6, dimensions[0].levels.length - 0.4];
      else if (log) { const margin = Math.max((high / low) ** 0.04, 1.02); range = [low / margin, high * margin]; } else {
        const margin = 0.04 * (high - low) || Math.abs(high) * 0.05 || 1;
        range = [low - margin, high + margin];
      }
    }
    return dimensions.map((dimension) => ({ ...dimension, values: dimension.values, range, log, positive, tick: tick(dimension) }));
  };

  const placesOf = (frame) => {
    const kept = points.passing(frame, state.filters, state.all);
    const x = points.dimension(state.x, frame).values, y = points.dimension(state.y, frame).values;
    const { front } = study.frames[frame];
    const usual = [], last = [];
    for (let i = 0; i < points.count; i += 1) {
      if (kept[i] && Number.isFinite(x[i]) && Number.isFinite(y[i])) (front[i] ? last : usual).push(i);
    }
    return Uint32Array.from(usual.concat(last));
  };

  const sized = () => {
    const wide = printing ? PAPER : plot.clientWidth || 600, count = frames().length;
    if (state.view !== "facets") return [wide, Math.max(300, Math.min(520, Math.round(wide * 0.62)))];
    const across = Math.max(1, Math.min(count, Math.floor(wide / 300)));
    return [Math.floor(wide / across) - 6, 260];
  };

  const drawKey = (colours, shapes) => {
    const parts = [made("span", colours.name)];
    const entry = (text, node) => { const span = made("span"); span.append(node, text); return span; };
    for (const [colour, text] of colours.entries ?? []) {
      const dot = made("i");
      dot.style.background = colour;
      parts.push(entry(text, dot));
    }
    if (colours.ends && colours.ends[0] === colours.ends[1]) parts.push(made("span", colours.ends[0]));
    else if (colours.ends) {
      const strip = made("span", "", { class: "ramp" });
      strip.style.background = `linear-gradient(to right, ${RAMP.join(", ")})`;
      parts.push(made("span", colours.ends[0]), strip, made("span", colours.ends[1]));
    }
    if (shapes) {
      parts.push(made("span", shapes.name, { class: "second" }));
      shapes.texts.forEach((text, k) => {
        const sign = made("canvas", undefined, { width: 28, height: 28, "aria-hidden": "true" });
        const context = sign.getContext("2d");
        tracePath(context, Math.min(k, SHAPES - 1), 14, 14, 9);
        context.fillStyle = tone("--soft");
        context.fill();
        parts.push(entry(text, sign));
      });
    }
    byId("key").replaceChildren(...parts);
  };

  const drawPlot = () => {
    const shown = frames().map(placesOf);
    const zoom = state.zoom;
    const xs = placed(state.x, state.logX, shown, zoom?.slice(0, 2)), ys = placed(state.y, state.logY, shown, zoom?.slice(2));
    for (const [box, axis] of [["log-x", xs[0]], ["log-y", ys[0]]]) {
      byId(box).checked = axis.log;
      byId(box).disabled = Boolean(axis.levels) || !axis.positive;
    }
    const colours = points.colouring(frames().map((frame) => points.dimension(state.colour, frame)), shown);
    const shapes = points.shaping(state.shape ? frames().map((frame) => points.dimension(state.shape, frame)) : null, frames(), state.all);
    drawKey(colours, shapes);
    const [width, height] = sized();
    plot.classList.toggle("facets", state.view === "facets");
    while (scatters.length > shown.length) scatters.pop().destroy();
    shown.forEach((places, k) => {
      const frame = frames()[k], { feasible, front } = study.frames[frame];
      scatters[k] ??= makeScatter(plot, events(k));
      scatters[k].draw({
        width, height, places, feasible, front, chosen: state.chosen, current: state.current, x: xs[k], y: ys[k],
        palette: colours.palette, codes: colours.codes[k], shapes: shapes?.codes[k] ?? null,
        title: state.view === "facets" ? study.frames[frame].name : undefined,
        line: points.staircase(Array.from(places), xs[k], ys[k], feasible),
      });
    });
    const most = Math.max(...shown.map((places) => places.length));
    const binned = most > BINNED ? " Squares stand for all points in them: the darker, the more." : "";
    byId("shown-count").textContent = `${most.toLocaleString("en")} of ${points.count.toLocaleString("en")} ${study.kind}s shown`;
    const words = filters.words();
    byId("filtered").textContent = `${words ? `Only: ${words}.` : "No filter."}${binned}`;
    plot.setAttribute("aria-label", `Scatter plot of ${points.dimension(state.y, 0).name} against ${points.dimension(state.x, 0).name}, ${most} ${study.kind}s. Arrow keys move between them, Enter opens the details.`);
  };

  const showPoint = () => {
    const frame = frames().length > 1 ? 0 : frames()[0];
    panel.show(state.current, frame, state.chosen.has(state.current));
    for (const scatter of scatters) scatter.mark(state.current);
  };
  const redraw = () => { drawPlot(); filters.refresh(); table.draw(); showPoint(); write(); };

  /** Draw once before the next frame, however often it is asked for, and measure from the first time it was. */
  let pending = null;
  const later = (name) => {
    if (pending) return;
    pending = name;
    performance.mark(`${name} begins`);
    requestAnimationFrame(() => {
      pending = null;
      redraw();
      performance.measure(name, `${name} begins`);
    });
  };

  // ---- what the reader does ----
  const open = (i) => {
    state.current = i;
    if (i !== null && !byId("details").contains(document.activeElement)) say(sentence(study, points, frames().length > 1 ? 0 : frames()[0], i, spoken()));
    showPoint();
    table.draw();
    write();
  };
  const spoken = () => [state.x, state.y, state.colour];
  const mark = (i) => {
    if (!state.chosen.delete(i)) state.chosen.add(i);
    redraw();
  };
  const close = () => { open(null); plot.focus({ preventScroll: true }); };
  const events = (k) => ({
    drag: () => state.drag, drawn: () => {},
    pick: (i, more) => { if (more && i !== null) { state.current = i; mark(i); } else open(i); },
    hover: (i) => { byId("under").textContent = i === null ? "" : sentence(study, points, frames()[k], i, spoken()); },
    choose: (places) => { state.chosen = new Set(places); state.rows = places.length ? "chosen" : "feasible"; table.first(); redraw(); },
    zoom: (ends) => { state.zoom = ends; later("zoom"); },
  });
  const panel = makePanel(study, points, { mark, close });
  const table = makeTable(study, points, state, { open, told: write });
  const filters = makeFilters(study, points, state, { changed: () => { table.first(); later("filter"); }, open });
  const zoomBy = (factor) => {
    const range = scatters[0].range();
    state.zoom = range.flatMap(({ log, ends }) => {
      const to = log ? Math.log : (value) => value, back = log ? Math.exp : (value) => value;
      const [low, high] = ends.map(to), middle = (low + high) / 2, half = (high - low) / 2 * factor;
      return [back(middle - half), back(middle + half)];
    });
    later("zoom");
  };

  plot.addEventListener("keydown", (event) => {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const places = scatters[0]?.places() ?? [];
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key in moves || event.key === "Home" || event.key === "End") {
      event.preventDefault();
      if (!places.length) return;
      const at = places.indexOf(state.current ?? -1);
      // From nowhere, the first point of the front, else the first of all.
      const found = event.key === "Home" ? places[0] : event.key === "End" || at < 0 ? places[places.length - 1] : scatters[0].step(state.current, ...moves[event.key]);
      if (found !== null) open(found);
    } else if (event.key === "Enter" && state.current !== null) {
      event.preventDefault();
      panel.show(state.current, frames().length > 1 ? 0 : frames()[0], state.chosen.has(state.current));
      byId("details").focus();
    } else if (event.key === " " && state.current !== null) {
      event.preventDefault();
      mark(state.current);
    } else if (event.key === "Escape") open(null);
    else if (event.key === "+" || event.key === "=") zoomBy(0.6);
    else if (event.key === "-") zoomBy(1 / 0.6);
    else if (event.key === "0") { state.zoom = null; later("zoom"); }
  });
  byId("details").addEventListener("keydown", (event) => { if (event.key === "Escape") close(); });

  // ---- controls ----
  const controls = { "choose-x": "x", "choose-y": "y", "choose-colour": "colour", "choose-shape": "shape" };
  for (const [id, name] of Object.entries(controls)) {
    const select = byId(id);
    if (name === "shape") select.append(made("option", "one shape", { value: "" }));
    const group = (label, keys) => {
      const set = made("optgroup", undefined, { label });
      for (const key of keys) set.append(made("option", points.dimension(key, 0).name, { value: key }));
      if (keys.length) select.append(set);
    };
    group("figures", main);
    group("axes", study.axes.map((axis) => `a:${axis.key}`));
    group("more figures", points.others.map((key) => `f:${key}`));
    select.addEventListener("change", () => {
      state[name] = select.value;
      if (name === "x") state.logX = null;
      if (name === "y") state.logY = null;
      if (name === "x" || name === "y") state.zoom = null;
      later("axis");
    });
  }
  const view = byId("choose-view");
  study.frames.forEach((frame, k) => view.append(made("option", k ? frame.name : `all, ${frame.name}`, { value: String(k) })));
  if (study.frames.length > 1) view.append(made("option", "one plot for each condition", { value: "facets" }));
  view.addEventListener("change", () => { state.view = view.value === "facets" ? "facets" : Number(view.value); state.zoom = null; later("view"); });
  byId("log-x").addEventListener("change", (event) => { state.logX = event.target.checked; state.zoom = null; later("axis"); });
  byId("log-y").addEventListener("change", (event) => { state.logY = event.target.checked; state.zoom = null; later("axis"); });
  byId("show-all").addEventListener("change", (event) => { state.all = event.target.checked; later("filter"); });
  byId("choose-drag").addEventListener("change", (event) => { state.drag = event.target.value; write(); });
  byId("whole").addEventListener("click", () => { state.zoom = null; later("zoom"); });
  byId("clear-filters").addEventListener("click", () => { state.filters.clear(); later("filter"); });
  byId("start-again").addEventListener("click", () => { reset(); fillControls(); later("filter"); });
  byId("save-picture").addEventListener("click", () => {
    const link = made("a", undefined, { download: "plot.png" });
    link.href = scatters[0].picture().toDataURL("image/png");
    link.click();
  });
  const fillControls = () => {
    for (const [id, name] of Object.entries(controls)) byId(id).value = state[name];
    view.value = String(state.view);
    byId("show-all").checked = state.all;
    byId("choose-drag").value = state.drag;
  };
  byId("left-out").hidden = !head.left_out;
  byId("left-out").textContent = `${head.left_out.toLocaleString("en")} more points are in the CSV and the JSON; every point of the front is here.`;

  // ---- the page around it ----
  addEventListener("hashchange", () => { read(); fillControls(); later("address"); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => later("colours"));
  let width = plot.clientWidth;
  new ResizeObserver(() => { if (plot.clientWidth !== width && !printing) { width = plot.clientWidth; later("size"); } }).observe(plot);
  // Paper is light and as wide as it is: the plots are drawn for it before it is printed.
  const forPaper = (on) => {
    if (printing === on) return;
    printing = on;
    document.documentElement.classList.toggle("paper", on);
    drawPlot();
    showPoint();
  };
  addEventListener("beforeprint", () => forPaper(true));
  addEventListener("afterprint", () => forPaper(false));
  matchMedia("print").addEventListener("change", (event) => forPaper(event.matches));

  fillControls();
  redraw();
  document.documentElement.dataset.ready = "yes";
  performance.measure("drawn", "page begins");
};
begin().catch((fault) => {
  byId("failed").hidden = false;
  byId("failed").textContent = `The points cannot be shown by this browser (${fault.message}). The tables stand without it.`;
  throw fault;
});
