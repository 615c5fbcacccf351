// The series of a run as small charts one below the other, with a line at the time that is shown.
const makeCharts = (place, head, column, numbers, jump) => {
  const SVG = "http://www.w3.org/2000/svg";
  const made = (name, attributes) => {
    const element = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return element;
  };
  const charts = head.series.map((series) => {
    const values = column(series.values), most = Math.max(...values);
    const figure = document.createElement("div"), label = document.createElement("p");
    figure.className = "series";
    const svg = made("svg", { viewBox: `0 0 ${values.length} 100`, preserveAspectRatio: "none", "aria-hidden": "true" });
    // Each value holds for its whole span.
    let outline = "M0 100";
    values.forEach((value, k) => { outline += `L${k} ${100 - (most ? (96 * value) / most : 0)}H${k + 1}`; });
    const now = made("line", { y1: 0, y2: 100, class: "now" });
    svg.append(made("path", { d: `${outline}V100Z` }), now);
    svg.addEventListener("click", (event) => {
      const box = svg.getBoundingClientRect();
      jump(((event.clientX - box.left) / box.width) * head.end);
    });
    figure.append(label, svg);
    place.append(figure);
    return (tick) => {
      const k = Math.min(values.length - 1, Math.floor((tick / head.end) * values.length));
      for (const end of ["x1", "x2"]) now.setAttribute(end, (tick / head.end) * values.length);
      // A measure, such as a speed, changes within a span: what it is at a time stands in the facts.
      const here = series.counted === "measure" ? "" : `: ${numbers.text(values[k], series)}`;
      label.textContent = `${series.name}${here} (at most ${numbers.text(most, series)})`;
    };
  });
  return (tick) => charts.forEach((show) => show(tick));
};
