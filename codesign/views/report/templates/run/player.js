// Play, pause, the slider, keys, the list of events, the table of robots, and the address.
const begin = async () => {
  const byId = (id) => document.getElementById(id);
  const head = JSON.parse(byId("run-data").textContent);
  const column = await readColumns(head.packed);
  const numbers = makeNumbers(head.scales), timeline = makeTimeline(head, column);
  const canvas = byId("stage"), drawing = makeDrawing(canvas, head, timeline);
  const slider = byId("time"), play = byId("play"), pace = byId("pace");
  const buttons = [...document.querySelectorAll("#events [data-at]")];
  const eventTimes = buttons.map((button) => Number(button.dataset.at));
  const length = (head.end * head.tick) / 1e12;
  let tick = head.end, playing = false, last = 0, printing = false, places = [], chosen = null, current = null;

  const options = () => ({ trail: byId("trail").value, numbers: byId("numbers").checked, chosen });
  const time = (at) => numbers.quantity(at * head.tick, "ps");
  const redraw = () => { places = drawing.draw(tick, options()); sayFacts(); };

  const STATES = { drives: "drives", arrived: "rests at its target", still: "stands", near: "touches another robot" };
  const robotFacts = ({ robot, row, column: across, speed, state }) => {
    const parts = [`robot ${robot.name} ${STATES[state]}`, `row ${row.toFixed(1)}, column ${across.toFixed(1)}`];
    if (speed !== null) parts[0] = speed > 0 ? `${robot.name} drives at ${numbers.quantity(Number(speed.toPrecision(3)), "m/s")}` : `${robot.name} stands`;
    const target = head.isFleet && head.targets[robot.number];
    if (target) parts.push(`${Math.hypot(target[0] - row, target[1] - across).toFixed(1)} cells from its target`);
    if (timeline.planning(robot.number, tick)) parts.push("a plan is under way");
    return parts.join(", ");
  };
  const sayFacts = () => {
    const facts = [`at ${time(tick)}`];
    if (head.isFleet) {
      const count = (state) => places.filter((place) => place.state === state).length;
      facts.push(Object.entries(STATES).map(([state]) => [count(state), { drives: "drive", arrived: "rest at their targets", still: "stand", near: "touch" }[state]])
        .filter(([number]) => number).map(([number, word]) => `${number} ${word}`).join(", "));
      if (chosen !== null) facts.push(robotFacts(places[chosen]));
    } else facts.push(...places.map(robotFacts));
    const stage = head.fields && timeline.upTo(head.fields.time, tick);
    if (head.fields) facts.push(stage ? `the field after stage ${head.fields.stage[stage - 1]}` : "no stage has ended");
    byId("facts").textContent = facts.filter(Boolean).join("; ");
  };
  const showCharts = makeCharts(byId("series"), head, column, numbers, (at) => { stop(); go(at); });

  // ---- one time for all: canvas, slider, charts, events ----
  const go = (at, andAddress = true) => {
    tick = Math.round(Math.min(Math.max(at, 0), head.end));
    slider.value = tick;
    const text = `${time(tick)} of ${time(head.end)}`;
    byId("now").textContent = text;
    slider.setAttribute("aria-valuetext", text);
    redraw();
    showCharts(tick);
    const reached = timeline.upTo(eventTimes, tick) - 1;
    if (buttons[reached] !== current) {
      current?.removeAttribute("aria-current");
      current = buttons[reached] ?? null;
      current?.setAttribute("aria-current", "time");
      const list = byId("events").querySelector("ol");
      if (current && list) list.scrollTop = current.offsetTop - list.offsetTop - list.clientHeight / 2;
    }
    if (andAddress && !playing) writeAddress();
  };
  // The address holds the time in seconds, to the tick.
  const writeAddress = () => history.replaceState(null, "", `#t=${Number(((tick * head.tick) / 1e12).toPrecision(12))}${chosen === null ? "" : `&robot=${chosen}`}`);
  const readAddress = () => {
    const asked = new URLSearchParams(location.hash.slice(1)), at = asked.has("t") ? (Number(asked.get("t")) * 1e12) / head.tick : head.end, robot = Number(asked.get("robot") ?? NaN);
    chosen = Number.isInteger(robot) && robot >= 0 && robot < timeline.robots.length ? robot : null;
    go(Number.isFinite(at) ? at : head.end, false);
  };

  // ---- playing ----
  const stop = () => { playing = false; play.textContent = "play"; };
  const frame = (now) => {
    if (!playing) return;
    // A tab that was hidden goes on where it was.
    const passed = last ? Math.min((now - last) / 1000, 0.25) : 0;
    last = now;
    go(tick + passed * Number(pace.value) * head.end, false);
    if (tick >= head.end) { stop(); writeAddress(); } else requestAnimationFrame(frame);
  };
  const toggle = () => {
    if (playing) { stop(); writeAddress(); return; }
    if (tick >= head.end) go(0);
    [playing, last] = [true, 0];
    play.textContent = "pause";
    requestAnimationFrame(frame);
  };
  // The value of a pace: the share of the run that passes in a second.
  const paces = [[1 / 10, "all in 10 s"], [1 / 30, "all in 30 s"], [1 / 90, "all in 90 s"]];
  if (length > 2 && length < 3600) paces.push([1 / length, "as it was"]);
  for (const [value, text] of paces) pace.append(new Option(text, value, value === 1 / 30, value === 1 / 30));

  // ---- robots ----
  const choose = (number) => {
    chosen = number === chosen ? null : number;
    for (const button of document.querySelectorAll("[data-robot]")) {
      button.setAttribute("aria-pressed", String(Number(button.dataset.robot) === chosen));
      button.closest("tr").classList.toggle("chosen", Number(button.dataset.robot) === chosen);
    }
    go(tick);
  };
  for (const cell of document.querySelectorAll("table.robots tbody tr td:first-child")) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = cell.textContent;
    button.dataset.robot = cell.textContent;
    button.setAttribute("aria-label", `show robot ${cell.textContent} on the map`);
    button.addEventListener("click", () => choose(Number(button.dataset.robot)));
    cell.replaceChildren(button);
  }
  canvas.addEventListener("click", (event) => {
    if (timeline.robots.length < 2) return;
    const box = canvas.getBoundingClientRect(), number = drawing.nearest(event.clientX - box.left, event.clientY - box.top, places);
    if (number !== null || chosen !== null) choose(number ?? chosen);
  });

  // ---- controls and keys ----
  play.addEventListener("click", toggle);
  slider.addEventListener("input", () => { stop(); go(Number(slider.value)); });
  for (const id of ["trail", "numbers"]) byId(id).addEventListener("change", redraw);
  buttons.forEach((button) => button.addEventListener("click", () => { stop(); go(Number(button.dataset.at)); }));
  const toEvent = (step) => {
    const at = step > 0 ? eventTimes.find((each) => each > tick) : eventTimes.filter((each) => each < tick).pop();
    if (at !== undefined) go(at);
  };
  const KEYS = {
    " ": toggle, ArrowRight: (far) => go(tick + head.end * far), ArrowLeft: (far) => go(tick - head.end * far),
    Home: () => go(0), End: () => go(head.end), n: () => toEvent(1), p: () => toEvent(-1),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
    event.preventDefault();
    if (event.key !== " ") stop();
    KEYS[event.key](event.shiftKey ? 0.05 : 0.005);
  });

  // ---- the page around it ----
  const box = canvas.parentElement;
  const fit = () => {
    drawing.readColours();
    drawing.fit(box.clientWidth, printing ? 560 : Math.max(280, innerHeight * 0.72));
    redraw();
  };
  let width = 0;
  new ResizeObserver(() => { if (box.clientWidth !== width && !printing) { width = box.clientWidth; fit(); } }).observe(box);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", fit);
  const forPaper = (on) => {
    if (printing === on) return;
    printing = on;
    document.documentElement.classList.toggle("paper", on);
    fit();
  };
  addEventListener("beforeprint", () => forPaper(true));
  addEventListener("afterprint", () => forPaper(false));
  matchMedia("print").addEventListener("change", (event) => forPaper(event.matches));
  addEventListener("hashchange", readAddress);
  width = box.clientWidth;
  drawing.readColours();
  drawing.fit(box.clientWidth, Math.max(280, innerHeight * 0.72));
  readAddress();
  document.documentElement.dataset.ready = "yes";
};
begin().catch((fault) => {
  const failed = document.getElementById("failed");
  failed.hidden = false;
  failed.textContent = `The run cannot be shown by this browser (${fault.message}). The tables and pictures stand without it.`;
  throw fault;
});
