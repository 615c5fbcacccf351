// The map at a tick, on a canvas: cells, field, trails, paths, goals, robots.
const makeDrawing = (canvas, head, timeline) => {
  const [top, left, bottom, right] = head.view;
  const image = document.createElement("canvas");
  [image.width, image.height] = [head.columns, head.rows];
  const pixels = image.getContext("2d").createImageData(head.columns, head.rows);
  const words = new Uint32Array(pixels.data.buffer);
  let colours = {}, shades = new Uint32Array(256), scale = 1;

  const NAMES = ["free", "wall", "unknown", "wall-unknown", "came", "stale", "path", "drives", "arrived", "still", "near", "goal", "halo"];
  const word = (hex) => {
    const [red, green, blue] = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
    return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  };
  /** The colours of the page as they are now; fields run from dark blue over green to yellow. */
  const readColours = () => {
    const style = getComputedStyle(document.documentElement);
    colours = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--map-${name}`).trim()]));
    const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
    shades = Uint32Array.from({ length: 256 }, (_, level) => {
      const at = (Math.max(level - 1, 0) / 254) * 4, k = Math.min(3, Math.floor(at));
      const [red, green, blue] = stops[k].map((from, part) => Math.round(from + (at - k) * (stops[k + 1][part] - from)));
      return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
    });
  };

  /** As wide as its place and no higher than most of the window; points of the canvas are those of the screen. */
  const fit = (width, height) => {
    const wide = right - left, high = bottom - top, ratio = devicePixelRatio || 1;
    scale = Math.max(Math.min(width / wide, height / high), 1e-3);
    canvas.style.width = `${wide * scale}px`;
    canvas.style.height = `${high * scale}px`;
    [canvas.width, canvas.height] = [Math.max(1, Math.round(wide * scale * ratio)), Math.max(1, Math.round(high * scale * ratio))];
  };
  const x = (column) => (column - left) * scale, y = (row) => (row - top) * scale;

  const paintCells = (context, tick) => {
    const { start, free, believed } = timeline.cellsAt(tick), field = timeline.fieldAt(tick);
    const [open, wall, unknown, dim, came, stale] = ["free", "wall", "unknown", "wall-unknown", "came", "stale"].map((name) => word(colours[name]));
    for (let i = 0; i < words.length; i += 1) {
      const belief = believed ? believed[i] : free[i] ? 0 : 2;
      if (free[i]) words[i] = field && field[i] ? shades[field[i]] : belief === 2 ? stale : belief === 1 ? unknown : open;
      else words[i] = start[i] ? came : belief === 2 ? wall : dim;
    }
    image.getContext("2d").putImageData(pixels, 0, 0);
    context.imageSmoothingEnabled = false;
    const [row, column] = head.corner, side = head.tile * scale;
    const box = [x(column - 0.5), y(row - 0.5), head.columns * side, head.rows * side];
    context.drawImage(image, ...box);
    context.strokeStyle = colours.unknown;
    context.lineWidth = 1;
    context.strokeRect(...box);
  };
  const line = (context, rows, columns, from, to) => {
    context.beginPath();
    for (let k = from; k <= to; k += 1) context.lineTo(x(columns[k]), y(rows[k]));
  };
  const paintTrails = (context, places, tick, trail) => {
    if (trail === "none") return;
    const begin = trail === "short" ? tick - head.end * 0.06 : -1;
    context.lineWidth = head.isFleet ? 1.2 : 1.8;
    context.globalAlpha = head.isFleet ? 0.6 : 0.9;
    for (const { robot, k, row, column, state } of places) {
      const from = Math.max(0, timeline.upTo(robot.time, begin) - 1);
      line(context, robot.row, robot.column, from, k);
      context.lineTo(x(column), y(row));
      context.strokeStyle = colours[head.isFleet ? state : "drives"];
      context.stroke();
    }
    context.globalAlpha = 1;
  };
  const paintPaths = (context, tick) => {
    for (const { rows, columns } of timeline.pathsAt(tick)) {
      line(context, rows, columns, 0, rows.length - 1);
      if (timeline.robots.length) context.setLineDash([5, 4]);
      else {
        context.strokeStyle = colours.halo;
        context.lineWidth = 3;
        context.stroke();
      }
      context.strokeStyle = colours.path;
      context.lineWidth = 1.6;
      context.stroke();
    }
    context.setLineDash([]);
  };
  const paintGoals = (context, tick) => {
    const goals = timeline.goalsAt(tick);
    const points = goals.length ? goals.flatMap(({ rows, columns }) => [...rows].map((row, k) => [row, columns[k]])) : head.targets;
    const size = head.isFleet ? 2.5 : Math.max(5, scale * 0.9);
    context.fillStyle = colours.goal;
    context.strokeStyle = colours.halo;
    for (const [row, column] of points) {
      context.beginPath();
      if (head.isFleet) context.rect(x(column) - size, y(row) - size, 2 * size, 2 * size);
      else for (let k = 0; k < 10; k += 1) {
        const far = k % 2 ? size * 0.45 : size, angle = -Math.PI / 2 + (k * Math.PI) / 5;
        context.lineTo(x(column) + far * Math.cos(angle), y(row) + far * Math.sin(angle));
      }
      context.closePath();
      context.lineWidth = 1;
      context.stroke();
      context.fill();
    }
  };
  const paintRobots = (context, places, { numbers, chosen }) => {
    for (const { robot, row, column, heading, state } of places) {
      const radius = Math.max(robot.radius * scale, head.isFleet ? 3 : 5), [across, down] = [x(column), y(row)];
      context.fillStyle = colours[state];
      context.strokeStyle = colours.halo;
      context.lineWidth = 1.2;
      context.beginPath();
      context.arc(across, down, radius, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
      context.beginPath();
      context.moveTo(across + radius * 0.5 * Math.cos(heading), down + radius * 0.5 * Math.sin(heading));
      context.lineTo(across + radius * 1.7 * Math.cos(heading), down + radius * 1.7 * Math.sin(heading));
      context.strokeStyle = colours[state];
      context.lineWidth = Math.max(2, radius / 5);
      context.stroke();
    }
    if (numbers && timeline.robots.length > 1) for (const place of places) paintNumber(context, place);
    const chosenPlace = places[chosen];
    if (chosenPlace) paintChosen(context, chosenPlace);
  };
  const paintNumber = (context, { robot, row, column }) => {
    const radius = robot.radius * scale, inside = radius >= 7;
    context.font = `600 ${inside ? Math.min(radius * 1.05, 14) : 9}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const [across, down] = [x(column), y(row) - (inside ? 0 : radius + 6)];
    context.lineWidth = 2.5;
    context.strokeStyle = colours.halo;
    if (!inside) context.strokeText(robot.name, across, down);
    context.fillStyle = inside ? colours.halo : colours.wall;
    context.fillText(robot.name, across, down);
  };
  const paintChosen = (context, { robot, row, column, state }) => {
    const target = head.isFleet ? head.targets[robot.number] : null;
    context.strokeStyle = colours.wall;
    context.lineWidth = 2;
    context.beginPath();
    context.arc(x(column), y(row), Math.max(robot.radius * scale, 4) + 4, 0, 2 * Math.PI);
    context.stroke();
    if (!target) return;
    context.setLineDash([3, 3]);
    context.beginPath();
    context.moveTo(x(column), y(row));
    context.lineTo(x(target[1]), y(target[0]));
    context.strokeStyle = colours[state];
    context.stroke();
    context.setLineDash([]);
  };

  /** Draw a tick; returns where the robots are. */
  const draw = (tick, options) => {
    const context = canvas.getContext("2d"), ratio = devicePixelRatio || 1;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = colours.free;
    context.fillRect(0, 0, canvas.width, canvas.height);
    paintCells(context, tick);
    const places = timeline.robotsAt(tick);
    context.lineJoin = context.lineCap = "round";
    paintTrails(context, places, tick, options.trail);
    paintPaths(context, tick);
    paintGoals(context, tick);
    paintRobots(context, places, options);
    return places;
  };
  /** The number of the robot nearest to a point of the canvas; null: none is near. */
  const nearest = (across, down, places) => {
    let best = null, least = 24;
    for (const { robot, row, column } of places) {
      const far = Math.hypot(x(column) - across, y(row) - down) - robot.radius * scale;
      if (far < least) [best, least] = [robot.number, far];
    }
    return best;
  };
  return { fit, draw, nearest, readColours };
};
