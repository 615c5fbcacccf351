// The run as data: the cells, the robots, the paths and the field at any tick.
const makeTimeline = (head, column) => {
  const [NOW_BLOCKED, NOW_FREE] = [0, 1];
  const BELIEF = { 2: 1, 3: 0, 4: 2 };
  const EVERY = 4000;

  /** How many of rising numbers are at most this one. */
  const upTo = (numbers, tick) => {
    let low = 0, high = numbers.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (numbers[middle] <= tick) low = middle + 1; else high = middle;
    }
    return low;
  };

  // ---- cells: changes are applied one after the other; now and then the state is kept for the way back ----
  const start = column(head.free), begin = head.believed && column(head.believed);
  const changes = { time: column(head.changes.time), cell: column(head.changes.cell), kind: column(head.changes.kind) };
  let free = Uint8Array.from(start), believed = begin && Uint8Array.from(begin), done = 0;
  const kept = new Map([[0, [start, begin]]]);
  const cellsAt = (tick) => {
    const wanted = upTo(changes.time, tick);
    if (wanted < done) {
      done = Math.floor(wanted / EVERY) * EVERY;
      const [world, belief] = kept.get(done);
      free = Uint8Array.from(world);
      believed = belief && Uint8Array.from(belief);
    }
    for (; done < wanted; done += 1) {
      if (done % EVERY === 0 && !kept.has(done)) kept.set(done, [Uint8Array.from(free), believed && Uint8Array.from(believed)]);
      const cell = changes.cell[done], kind = changes.kind[done];
      if (kind === NOW_BLOCKED) free[cell] = 0;
      else if (kind === NOW_FREE) free[cell] = 1;
      else believed[cell] = BELIEF[kind];
    }
    return { start, free, believed };
  };

  // ---- robots ----
  const robots = head.robots.map((robot, number) => {
    const time = column(robot.time), row = column(robot.row).map((v) => v / 64), across = column(robot.column).map((v) => v / 64);
    const speed = robot.speed && column(robot.speed);
    let heading = robot.heading && Float64Array.from(column(robot.heading), (turn) => (turn * Math.PI) / 128);
    if (!heading) {
      // A robot of a fleet points where it moves next, or where it last moved.
      heading = new Float64Array(time.length);
      for (let k = 0; k < time.length; k += 1) {
        const down = k + 1 < time.length ? row[k + 1] - row[k] : 0, right = k + 1 < time.length ? across[k + 1] - across[k] : 0;
        heading[k] = down || right ? Math.atan2(down, right) : k ? heading[k - 1] : 0;
      }
    }
    return { ...robot, number, time, row, column: across, speed, heading };
  });
  const turned = (from, to, share) => from + share * (((to - from + 3 * Math.PI) % (2 * Math.PI)) - Math.PI);
  const placeAt = (robot, tick) => {
    const k = Math.max(0, upTo(robot.time, tick) - 1), next = Math.min(k + 1, robot.time.length - 1);
    const span = robot.time[next] - robot.time[k], share = span ? Math.min(1, Math.max(0, (tick - robot.time[k]) / span)) : 0;
    const between = (values) => values[k] + share * (values[next] - values[k]);
    return {
      k, row: between(robot.row), column: between(robot.column),
      heading: robot.speed ? turned(robot.heading[k], robot.heading[next], share) : robot.heading[k],
      speed: robot.speed ? between(robot.speed) : null,
      moves: next > k && (robot.row[next] !== robot.row[k] || robot.column[next] !== robot.column[k]),
    };
  };

  // ---- paths and goals: all points behind one another ----
  const pieces = ({ time, robot, count, row, column: across }) => {
    const rows = column(row), columns = column(across);
    let from = 0;
    return time.map((at, k) => {
      const piece = { time: at, robot: robot[k], rows: rows.slice(from, from + count[k]).map((v) => v / 64), columns: columns.slice(from, from + count[k]).map((v) => v / 64) };
      from += count[k];
      return piece;
    });
  };
  const paths = pieces(head.paths), goals = pieces(head.goals);
  /** The last piece of each robot up to a tick; without robots all of them. */
  const lastAt = (all, tick) => {
    const before = all.filter((piece) => piece.time <= tick);
    return robots.length ? [...new Map(before.map((piece) => [piece.robot, piece])).values()] : before;
  };

  // ---- fields of stages ----
  const levels = head.fields && column(head.fields.levels), size = head.rows * head.columns;
  const fieldAt = (tick) => {
    const stages = head.fields ? upTo(head.fields.time, tick) : 0;
    return stages ? levels.subarray((stages - 1) * size, stages * size) : null;
  };

  // ---- what the events say of a robot ----
  const planning = (number, tick) => {
    let under = false;
    for (const [at, robot, kind] of head.events) {
      if (at > tick) break;
      if (robot !== number) continue;
      if (kind === "plan_requested") under = true;
      else if (kind === "plan_ready" || kind === "no_way" || kind === "ended") under = false;
    }
    return under;
  };
  /** Where all robots are, and in which state: arrived, near (closer than their bodies allow), still, drives. */
  const robotsAt = (tick) => {
    const places = robots.map((robot) => ({ robot, ...placeAt(robot, tick) }));
    for (const place of places) {
      const reach = 2 * place.robot.radius;
      const near = reach && places.some((other) => other !== place && Math.hypot(other.row - place.row, other.column - place.column) < reach);
      const arrived = place.robot.arrived !== null && tick >= place.robot.arrived;
      const moves = place.speed === null ? place.moves : place.speed > 0;
      place.state = near ? "near" : arrived ? "arrived" : moves ? "drives" : "still";
    }
    return places;
  };
  return { cellsAt, robotsAt, fieldAt, planning, upTo, robots, pathsAt: (tick) => lastAt(paths, tick), goalsAt: (tick) => lastAt(goals, tick) };
};
