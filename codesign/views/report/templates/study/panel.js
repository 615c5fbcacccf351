// Elements, and the panel with all that is known of one point.
const byId = (id) => document.getElementById(id);
const made = (name, text, attributes = {}) => {
  const element = document.createElement(name);
  if (text !== undefined) element.textContent = text;
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};
const button = (text, act, attributes = {}) => {
  const element = made("button", text, { type: "button", ...attributes });
  element.addEventListener("click", act);
  return element;
};

const fate = (study, frame, i) => {
  const { feasible, front, why } = study.frames[frame];
  if (front[i]) return "on the front";
  if (!feasible[i]) return "not feasible";
  return study.whys[why[i]] ? "not on the front" : "feasible, not on the front";
};

/** A point in one sentence, for a line below the plot and for who listens. */
const sentence = (study, points, frame, i, keys) => {
  const figures = keys.map((key) => points.dimension(key, frame)).map((each) => `${each.name} ${each.text(i)}`);
  return `${study.kind} ${study.points[i]}: ${[...new Set(figures)].join(", ")}; ${fate(study, frame, i)}`;
};

const makePanel = (study, points, act) => {
  const panel = byId("details");
  const list = (pairs) => {
    const terms = made("dl");
    for (const [name, text] of pairs) terms.append(made("dt", name), made("dd", text));
    return terms;
  };
  const byCondition = (i) => {
    const table = made("table"), head = made("tr"), body = made("tbody");
    head.append(made("th", "condition", { scope: "col" }));
    for (const key of points.main) head.append(made("th", points.dimension(`f:${key}`, 1).name, { scope: "col", class: "right" }));
    study.frames.slice(1).forEach((frame, k) => {
      const row = made("tr");
      row.append(made("td", frame.name, { "data-label": "condition" }));
      for (const key of points.main) {
        const each = points.dimension(`f:${key}`, k + 1);
        row.append(made("td", each.text(i), { class: "right short", "data-label": each.name }));
      }
      body.append(row);
    });
    const top = made("thead");
    top.append(head);
    table.append(top, body);
    const box = made("div", undefined, { class: "wide", role: "region", tabindex: "0", "aria-label": "By condition" });
    box.append(table);
    return box;
  };

  /** Fill the panel with a point of a frame; with null, say how to open it. */
  const show = (i, frame, chosen) => {
    panel.classList.toggle("open", i !== null);
    if (i === null) {
      panel.replaceChildren(made("p", `Choose a ${study.kind} in the plot or in the table: its details stand here.`, { class: "note" }));
      return;
    }
    const { why } = study.frames[frame];
    const head = made("div", undefined, { class: "head" });
    head.append(
      made("h3", `${study.kind[0].toUpperCase()}${study.kind.slice(1)} ${study.points[i]}`, { id: "details-title" }),
      button(chosen ? "unmark" : "mark", () => act.mark(i)), button("close", act.close, { id: "close-details" }),
    );
    const parts = [head, made("p", fate(study, frame, i), { class: "fate" })];
    const reasons = study.whys[why[i]];
    if (reasons) {
      const items = made("ul", undefined, { class: "lacks" });
      for (const reason of reasons.split("; ")) items.append(made("li", reason));
      parts.push(made("h4", "What it lacks"), items);
    }
    if (study.axes.length) parts.push(made("h4", "Axes"), list(study.axes.map((axis) => [axis.name, axis.levels[axis.level[i]]])));
    const figure = (key) => { const each = points.dimension(`f:${key}`, frame); return [each.name, each.text(i)]; };
    const first = points.others.includes("misses") && !study.frames[frame].feasible[i] ? ["misses", ...points.main] : points.main;
    parts.push(made("h4", "Figures"), list(first.map(figure)));
    const others = points.others.filter((key) => !first.includes(key)).map(figure).filter(([, text]) => text !== "–");
    if (others.length) {
      const more = made("details");
      more.append(made("summary", "more figures"), list(others));
      parts.push(more);
    }
    if (study.frames.length > 1) parts.push(made("h4", "By condition"), byCondition(i));
    panel.replaceChildren(...parts);
  };
  return { show };
};
