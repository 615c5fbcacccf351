// What the reader chose. It stands in the address, so that a colleague who opens it sees the same.
const makeState = (known) => {
  const state = {};
  const reset = () => Object.assign(state, {
    x: known.x, y: known.y, colour: known.colour, shape: "", logX: null, logY: null,
    view: 0, all: known.all, rows: known.all ? "all" : "feasible",
    filters: new Map(), current: null, chosen: new Set(), zoom: null, drag: "choose",
  });
  const number = (text) => (text.trim() === "" ? NaN : Number(text));
  const spans = (text, count) => {
    const ends = text.split("..").map(number);
    return ends.length === count && ends.every((end) => !Number.isNaN(end)) ? ends : null;
  };
  const flag = (text) => (text === "1" ? true : text === "0" ? false : null);

  /** Of an address that names what is not here, the rest is taken. */
  const read = () => {
    reset();
    const asked = new URLSearchParams(location.hash.slice(1));
    for (const [key, text] of asked) {
      if (["x", "y", "colour"].includes(key) && known.dimensions.has(text)) state[key] = text;
      else if (key === "shape" && (text === "" || known.dimensions.has(text))) state.shape = text;
      else if (key === "logx") state.logX = flag(text);
      else if (key === "logy") state.logY = flag(text);
      else if (key === "all") state.all = flag(text) ?? known.all;
      else if (key === "rows" && known.rows.includes(text)) state.rows = text;
      else if (key === "drag" && text === "zoom") state.drag = text;
      else if (key === "view" && (text === "facets" ? known.views > 1 : Number(text) in [...Array(known.views)])) {
        state.view = text === "facets" ? text : Number(text);
      } else if (key === "zoom") state.zoom = spans(text, 4);
      else if (key === "point") state.current = known.place(text);
      else if (key === "chosen") {
        for (const each of text.split(".")) if (known.place(each) !== null) state.chosen.add(known.place(each));
      } else if (known.dimensions.has(key)) {
        const levels = known.dimensions.get(key);
        if (levels) {
          const kept = text.split(".").map(number).filter((level) => Number.isInteger(level) && level >= 0 && level < levels);
          state.filters.set(key, new Set(kept));
        } else if (spans(text, 2)) state.filters.set(key, spans(text, 2));
      }
    }
  };

  const write = () => {
    const told = new URLSearchParams();
    const tell = (key, value, usual) => { if (value !== usual) told.set(key, String(value)); };
    tell("x", state.x, known.x);
    tell("y", state.y, known.y);
    tell("colour", state.colour, known.colour);
    tell("shape", state.shape, "");
    if (state.logX !== null) told.set("logx", state.logX ? "1" : "0");
    if (state.logY !== null) told.set("logy", state.logY ? "1" : "0");
    tell("view", state.view, 0);
    if (state.all !== known.all) told.set("all", state.all ? "1" : "0");
    tell("rows", state.rows, known.all ? "all" : "feasible");
    tell("drag", state.drag, "choose");
    for (const [key, kept] of state.filters) told.set(key, kept instanceof Set ? [...kept].sort((a, b) => a - b).join(".") : kept.join(".."));
    if (state.zoom) told.set("zoom", state.zoom.map((end) => Number(end.toPrecision(6))).join(".."));
    if (state.current !== null) told.set("point", known.number(state.current));
    // A long selection is no address: the first ones stand for it.
    if (state.chosen.size) told.set("chosen", [...state.chosen].slice(0, 100).map(known.number).join("."));
    const text = told.toString();
    if (`#${text}` !== location.hash && (text || location.hash)) history.replaceState(null, "", text ? `#${text}` : "#");
  };
  reset();
  return { state, read, write, reset };
};
