// One scatter plot. uPlot draws axes, grid and zoom box; the points are a layer of our own, in bins where they are many.
const BINNED = 25000;
const BIN = 3;
const REACH = 16;
const POINT = 4, FRONT = 6.5;

const tracePath = (context, shape, x, y, r) => {
  const lines = (...corners) => {
    corners.forEach(([dx, dy], k) => context[k ? "lineTo" : "moveTo"](x + r * dx, y + r * dy));
    context.closePath();
  };
  context.beginPath();
  if (shape === 0) context.arc(x, y, r, 0, 2 * Math.PI);
  else if (shape === 1) lines([-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]);
  else if (shape === 2) lines([0, -1.15], [1.05, 0.8], [-1.05, 0.8]);
  else if (shape === 3) lines([0, -1.2], [1.2, 0], [0, 1.2], [-1.2, 0]);
  else if (shape === 4) lines([0, 1.15], [1.05, -0.8], [-1.05, -0.8]);
  else lines([-1.2, -0.4], [-0.4, -0.4], [-0.4, -1.2], [0.4, -1.2], [0.4, -0.4], [1.2, -0.4], [1.2, 0.4], [0.4, 0.4], [0.4, 1.2], [-0.4, 1.2], [-0.4, 0.4], [-1.2, 0.4]);
};

const isRound = (value) => Number.isInteger(Number((value / 10 ** Math.floor(Math.log10(value))).toPrecision(6)));
const tone = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const makeScatter = (holder, events) => {
  let chart = null;
  let view = null;
  let px = new Float32Array(0), py = px;
  let grid = null;
  const marker = document.createElement("div");
  marker.className = "marker";
  const sprites = new Map();

  const sprite = (colour, shape, radius, edge, hollow, ratio) => {
    const key = `${colour}|${shape}|${radius}|${edge}|${hollow}|${ratio}`;
    if (!sprites.has(key)) {
      const side = Math.ceil(2 * ratio * (1.3 * radius + 2));
      const canvas = document.createElement("canvas");
      canvas.width = canvas.height = side;
      const context = canvas.getContext("2d");
      tracePath(context, shape, side / 2, side / 2, radius * ratio);
      context.globalAlpha = edge ? 1 : hollow ? 0.8 : 0.65;
      context.fillStyle = colour;
      if (!hollow) context.fill();
      if (edge || hollow) {
        context.strokeStyle = hollow && !edge ? colour : edge;
        context.lineWidth = 1.4 * ratio;
        context.stroke();
      }
      sprites.set(key, canvas);
    }
    return sprites.get(key);
  };

  const place = () => {
    const { left, top, width, height } = chart.bbox;
    const { places, x, y } = view;
    const along = (axis, scale, turn, begin, size) => {
      const { min, max } = chart.scales[scale];
      const at = axis.log ? Math.log10 : (value) => value;
      const from = at(min), step = size / (at(max) - from);
      const jitter = axis.levels ? 0.32 : 0;
      return (i) => {
        const value = axis.values[i] + (jitter ? jitter * ((((i * 2654435761) >>> 0) % 1000) / 999 - 0.5) : 0);
        const far = (at(value) - from) * step;
        return begin + (turn ? size - far : far);
      };
    };
    const toX = along(x, "x", false, left, width), toY = along({ ...y }, "y", true, top, height);
    px = new Float32Array(places.length);
    py = new Float32Array(places.length);
    for (let k = 0; k < places.length; k += 1) { px[k] = toX(places[k]); py[k] = toY(places[k]); }
    grid = null;
    return { left, top, width, height, toX, toY };
  };

  const drawBins = (context, box, ratio, usual) => {
    const side = Math.max(1, Math.round(BIN * ratio));
    const columns = Math.ceil(box.width / side) + 1, rows = Math.ceil(box.height / side) + 1;
    const counts = new Uint32Array(columns * rows), lasts = new Uint32Array(columns * rows);
    let most = 1;
    for (let k = 0; k < usual; k += 1) {
      const column = Math.floor((px[k] - box.left) / side), row = Math.floor((py[k] - box.top) / side);
      if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
      const bin = row * columns + column;
      counts[bin] += 1;
      lasts[bin] = k;
      if (counts[bin] > most) most = counts[bin];
    }
    for (let bin = 0; bin < counts.length; bin += 1) {
      if (!counts[bin]) continue;
      context.globalAlpha = most > 1 ? 0.5 + 0.5 * Math.log(counts[bin]) / Math.log(most) : 0.8;
      context.fillStyle = view.palette[view.codes[view.places[lasts[bin]]]];
      context.fillRect(box.left + (bin % columns) * side, box.top + Math.floor(bin / columns) * side, side, side);
    }
    context.globalAlpha = 1;
  };

  const drawLine = (context, { toX, toY, left, top, width, height }, ratio) => {
    if (view.line.length < 2) return;
    context.save();
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    context.beginPath();
    view.line.forEach((i, k) => {
      const x = toX(i), y = toY(i);
      if (k === 0) context.moveTo(x, y);
      // A larger x can stand in for a smaller one only where less is better: else the corner lies on the other side.
      else if (view.x.maximise) { context.lineTo(toX(view.line[k - 1]), y); context.lineTo(x, y); } else { context.lineTo(x, toY(view.line[k - 1])); context.lineTo(x, y); }
    });
    context.setLineDash([5 * ratio, 4 * ratio]);
    context.lineWidth = 1.4 * ratio;
    context.strokeStyle = tone("--soft");
    context.stroke();
    context.restore();
  };

  const drawPoints = () => {
    if (!view) return;
    const ratio = chart.pxRatio ?? uPlot.pxRatio, context = chart.ctx;
    const box = place();
    const { places, feasible, front, chosen, palette, codes, shapes } = view;
    drawLine(context, box, ratio);
    const right = box.left + box.width, bottom = box.top + box.height;
    const ink = tone("--ink"), accent = tone("--accent");
    // Points of the front stand last in places, so that they lie on top.
    let usual = places.length;
    while (usual > 0 && front[places[usual - 1]]) usual -= 1;
    const binned = usual > BINNED;
    if (binned) drawBins(context, box, ratio, usual);
    const drawn = (k, radius, edge) => {
      if (px[k] < box.left - 1 || px[k] > right + 1 || py[k] < box.top - 1 || py[k] > bottom + 1) return;
      const i = places[k];
      const image = sprite(palette[codes[i]], shapes ? shapes[i] : 0, radius, edge, !feasible[i], ratio);
      context.drawImage(image, px[k] - image.width / 2, py[k] - image.height / 2);
    };
    if (!binned) for (let k = 0; k < usual; k += 1) drawn(k, POINT, "");
    for (let k = usual; k < places.length; k += 1) drawn(k, FRONT, ink);
    if (chosen.size) for (let k = 0; k < places.length; k += 1) if (chosen.has(places[k])) drawn(k, FRONT, accent);
    showMarker();
    events.drawn();
  };

  const showMarker = () => {
    const k = view.places.indexOf(view.current ?? -1);
    const ratio = uPlot.pxRatio;
    const x = (px[k] - chart.bbox.left) / ratio, y = (py[k] - chart.bbox.top) / ratio;
    marker.hidden = k < 0 || !(x >= -1 && y >= -1 && x <= chart.bbox.width / ratio + 1 && y <= chart.bbox.height / ratio + 1);
    if (!marker.hidden) { marker.style.left = `${x}px`; marker.style.top = `${y}px`; }
  };

  /** The place of the point nearest to a spot of the plot, in pixels of the page, or null. */
  const pick = (left, top) => {
    const ratio = uPlot.pxRatio;
    const x = left * ratio + chart.bbox.left, y = top * ratio + chart.bbox.top, reach = REACH * ratio;
    const columns = Math.ceil(chart.bbox.width / reach) + 3;
    const cell = (a, b) => (Math.floor((b - chart.bbox.top) / reach) + 1) * columns + Math.floor((a - chart.bbox.left) / reach) + 1;
    if (!grid) {
      grid = new Map();
      for (let k = 0; k < px.length; k += 1) {
        const at = cell(px[k], py[k]);
        if (grid.has(at)) grid.get(at).push(k); else grid.set(at, [k]);
      }
    }
    let nearest = null, least = reach * reach;
    for (const down of [-1, 0, 1]) {
      for (const across of [-1, 0, 1]) {
        for (const k of grid.get(cell(x + across * reach, y + down * reach)) ?? []) {
          const far = (px[k] - x) ** 2 + (py[k] - y) ** 2;
          // Of points on one spot the one that is drawn last.
          if (far <= least) { least = far; nearest = view.places[k]; }
        }
      }
    }
    return nearest;
  };

  /** The nearest point in a direction: left, right, up or down of another one. */
  const step = (from, across, down) => {
    const at = view.places.indexOf(from);
    let found = null, least = Infinity;
    for (let k = 0; k < px.length; k += 1) {
      const dx = px[k] - px[at], dy = py[k] - py[at];
      const ahead = across * dx + down * dy, aside = Math.abs(across ? dy : dx);
      // Points on the same spot are visited by their order.
      const same = dx === 0 && dy === 0 && (across + down > 0 ? k > at : k < at);
      const far = same ? Math.abs(k - at) * 1e-6 : ahead > 0.01 ? ahead + 3 * aside : Infinity;
      if (far < least) { least = far; found = view.places[k]; }
    }
    return found;
  };

  const within = ({ left, top, width, height }) => {
    const ratio = uPlot.pxRatio, x = left * ratio + chart.bbox.left, y = top * ratio + chart.bbox.top;
    return Array.from(view.places).filter((_, k) => px[k] >= x && px[k] <= x + width * ratio && py[k] >= y && py[k] <= y + height * ratio);
  };

  const axisOptions = (scale, axis) => ({
    scale, label: axis.name, labelSize: 22, labelFont: "13px system-ui, sans-serif", font: "12px system-ui, sans-serif",
    stroke: () => tone("--ink"), grid: { stroke: () => tone("--line"), width: 1 }, ticks: { stroke: () => tone("--line"), width: 1 },
    ...(axis.levels ? { splits: (u, _, low, high) => axis.levels.map((__, level) => level).filter((level) => level >= low && level <= high) } : {}),
    space: scale === "x" ? 80 : 34,
    // A logarithmic axis begins with a tick at its end, whatever number this is.
    values: (_, splits) => splits.map((split, k) => (split === null || (axis.log && k === 0 && splits.length > 3 && !isRound(split)) ? "" : axis.tick(split))),
    ...(scale === "y" ? { size: (_, values) => Math.min(150, Math.max(44, 18 + 6.6 * Math.max(0, ...(values ?? []).map((text) => text.length)))) } : { size: 40 }),
  });

  const draw = (next) => {
    view = next;
    chart?.destroy();
    const options = {
      width: view.width, height: view.height, title: view.title, legend: { show: false }, padding: [12, 18, 0, 0],
      cursor: { x: false, y: false, points: { show: false }, drag: { x: true, y: true, setScale: false }, bind: { dblclick: () => () => events.zoom(null) } },
      scales: {
        x: { time: false, distr: view.x.log ? 3 : 1, range: () => view.x.range },
        y: { distr: view.y.log ? 3 : 1, range: () => view.y.range },
      },
      axes: [axisOptions("x", view.x), axisOptions("y", view.y)],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      hooks: {
        draw: [drawPoints],
        setSelect: [(u) => {
          const box = { ...u.select };
          if (box.width < 5 && box.height < 5) return;
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          if (events.drag() === "choose") { events.choose(within(box)); return; }
          events.zoom([
            u.posToVal(box.left, "x"), u.posToVal(box.left + box.width, "x"),
            u.posToVal(box.top + box.height, "y"), u.posToVal(box.top, "y"),
          ]);
        }],
      },
    };
    chart = new uPlot(options, [view.x.range, view.y.range], holder);
    chart.over.append(marker);
    let down = null;
    chart.over.addEventListener("mousedown", (event) => { down = [event.clientX, event.clientY]; });
    chart.over.addEventListener("click", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const box = chart.over.getBoundingClientRect();
      events.pick(pick(event.clientX - box.left, event.clientY - box.top), event.shiftKey || event.ctrlKey || event.metaKey);
    });
    chart.over.addEventListener("mousemove", (event) => {
      if (event.buttons) return;
      const box = chart.over.getBoundingClientRect();
      events.hover(pick(event.clientX - box.left, event.clientY - box.top));
    });
    chart.over.addEventListener("mouseleave", () => events.hover(null));
  };

  return {
    draw, step,
    range: () => [[view.x.log, chart.scales.x], [view.y.log, chart.scales.y]].map(([log, { min, max }]) => ({ log, ends: [min, max] })),
    mark: (current) => { if (view) { view.current = current; showMarker(); } },
    places: () => view?.places ?? [],
    picture: () => chart?.ctx.canvas,
    destroy: () => { chart?.destroy(); chart = null; },
  };
};
