// The dimensions that points are placed, coloured and filtered by, and what passes the filters.
const RAMP = ["#46327e", "#3b528b", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#e5d71f"];
const HUES = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#b3a800", "#7a7f87"];
const STEPS = 48;
const SHAPES = 6;

const blend = (share) => {
  const place = share * (RAMP.length - 1);
  const low = Math.min(Math.floor(place), RAMP.length - 2);
  const part = (text, k) => parseInt(text.slice(1 + 2 * k, 3 + 2 * k), 16);
  const mix = (k) => Math.round(part(RAMP[low], k) + (place - low) * (part(RAMP[low + 1], k) - part(RAMP[low], k)));
  return `rgb(${mix(0)},${mix(1)},${mix(2)})`;
};

const makePoints = (study, numbers) => {
  const count = study.points.length;
  const nothing = new Float64Array(count).fill(NaN);
  const keys = new Map();
  const named = new Map();
  for (const frame of study.frames) {
    for (const figure of frame.figures) if (!named.has(figure.key)) named.set(figure.key, { ...figure, values: nothing });
  }
  const first = study.frames[0].figures.map((figure) => figure.key);
  const main = first.slice(0, study.main);
  const others = [...named.keys()].filter((key) => !main.includes(key));
  for (const key of [...main, ...others]) keys.set(`f:${key}`, null);
  study.axes.forEach((axis) => keys.set(`a:${axis.key}`, axis.levels.length));
  const held = new Map();

  /** An axis or a figure in a frame: the value of each point, its text, and whether it is known. */
  const dimension = (key, frame) => {
    const id = `${frame}|${key}`;
    if (held.has(id)) return held.get(id);
    const name = key.slice(2);
    let made;
    if (key.startsWith("a:")) {
      const axis = study.axes.find((each) => each.key === name);
      made = { ...axis, key, values: axis.level, write: (value) => axis.levels[Math.round(value)] ?? "" };
    } else {
      const figure = study.frames[frame].figures.find((each) => each.key === name) ?? named.get(name);
      made = { ...figure, key, values: figure.values, levels: null, write: (value) => numbers.text(value, figure) };
    }
    made.text = (i) => made.write(made.values[i]);
    held.set(id, made);
    return made;
  };

  const isPlotted = (i, frame, all) => study.frames[frame].feasible[i] || all;

  /** Which points pass the filters but the one of ``without``; feasible ones, or all. */
  const passing = (frame, filters, all, without = null) => {
    const { feasible } = study.frames[frame];
    const kept = new Uint8Array(count);
    for (let i = 0; i < count; i += 1) kept[i] = all || feasible[i] ? 1 : 0;
    for (const [key, limit] of filters) {
      if (key === without) continue;
      const { values } = dimension(key, frame);
      if (limit instanceof Set) {
        for (let i = 0; i < count; i += 1) if (!limit.has(values[i])) kept[i] = 0;
      } else {
        const [low, high] = limit;
        for (let i = 0; i < count; i += 1) if (!(values[i] >= low && values[i] <= high)) kept[i] = 0;
      }
    }
    return kept;
  };

  /** The finite values that a figure takes at feasible points, or at all, each once, by rising value. */
  const attained = (key, frame, all) => {
    const { values } = dimension(key, frame);
    const { feasible } = study.frames[frame];
    const finite = values.filter((value, i) => (all || feasible[i]) && Number.isFinite(value)).sort();
    return finite.filter((value, k) => k === 0 || value !== finite[k - 1]);
  };

  /** The place of the best point among those kept, by a figure; of equals the first on the front. Infeasible ones are never it. */
  const best = (key, frame, kept) => {
    const { values, maximise } = dimension(key, frame);
    const { feasible, front } = study.frames[frame];
    let found = null;
    for (let i = 0; i < count; i += 1) {
      if (!kept[i] || !feasible[i] || Number.isNaN(values[i])) continue;
      if (found === null) { found = i; continue; }
      const gain = maximise ? values[i] - values[found] : values[found] - values[i];
      if (gain > 0 || (gain === 0 && front[i] > front[found])) found = i;
    }
    return found;
  };

  /** The feasible points among those of ``places`` that no other beats in both figures, by rising x. */
  const staircase = (places, x, y, feasible) => {
    if (x.levels || y.levels || x.key === y.key) return [];
    const turnX = x.maximise ? -1 : 1, turnY = y.maximise ? -1 : 1;
    const sorted = places.filter((i) => feasible[i])
      .sort((i, j) => turnX * (x.values[i] - x.values[j]) || turnY * (y.values[i] - y.values[j]) || i - j);
    const line = [];
    let least = Infinity;
    for (const i of sorted) {
      if (turnY * y.values[i] < least) { least = turnY * y.values[i]; line.push(i); }
    }
    return x.maximise ? line.reverse() : line;
  };

  const extent = (dimensions, places) => {
    let low = Infinity, high = -Infinity, least = Infinity;
    dimensions.forEach(({ values }, k) => {
      for (const i of places[k]) {
        const value = values[i];
        if (value < low) low = value;
        if (value > high) high = value;
        if (value > 0 && value < least) least = value;
      }
    });
    return { low, high, positive: low > 0, wantsLogarithm: low > 0 && high / low > 20 };
  };

  /** A palette, the colour of each point in it, and what the key of the plot shows. */
  const colouring = (dimensions, places) => {
    const [one] = dimensions;
    const coded = (code) => dimensions.map(({ values }) => Uint8Array.from(values, code));
    if (one.levels && one.levels.length <= HUES.length) {
      return { name: one.name, palette: HUES, codes: coded((level) => level), entries: one.levels.map((text, k) => [HUES[k], text]) };
    }
    const { low, high, wantsLogarithm } = extent(dimensions, places);
    const scale = wantsLogarithm ? Math.log : (value) => value;
    const palette = [...Array.from({ length: STEPS }, (_, k) => blend(k / (STEPS - 1))), HUES[7]];
    const from = scale(low), span = scale(high) - from;
    const code = (value) => {
      if (!Number.isFinite(value)) return STEPS;
      const share = span > 0 ? (scale(value) - from) / span : 0.5;
      return Math.round(Math.min(1, Math.max(0, share)) * (STEPS - 1)) || 0;
    };
    const ends = low <= high ? [one.write(low), one.write(high)] : null;
    return { name: `${one.name}${wantsLogarithm ? " (logarithmic)" : ""}`, palette, codes: coded(code), ends };
  };

  /** The shape of each point, and what each shape stands for: levels, values, or quarters of them. */
  const shaping = (dimensions, frames, all) => {
    if (!dimensions) return null;
    const [one] = dimensions;
    if (one.levels) {
      const texts = one.levels.length <= SHAPES ? one.levels : [...one.levels.slice(0, SHAPES - 1), "others"];
      return { name: one.name, texts, codes: dimensions.map(({ values }) => Uint8Array.from(values, (level) => Math.min(level, SHAPES - 1))) };
    }
    const values = attained(one.key, frames[0], all);
    const few = values.length <= SHAPES;
    const limits = few ? [...values] : [0.25, 0.5, 0.75, 1].map((share) => values[Math.ceil(share * values.length) - 1]);
    const code = (value) => { const k = limits.findIndex((limit) => value <= limit); return k < 0 ? SHAPES - 1 : k; };
    return {
      name: one.name, texts: limits.map((limit) => (few ? "" : "to ") + one.write(limit)),
      codes: dimensions.map((each) => Uint8Array.from(each.values, code)),
    };
  };

  return { count, keys, main, others, dimension, passing, attained, best, staircase, extent, colouring, shaping, isPlotted };
};
