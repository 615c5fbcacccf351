// What pages share: a table of class "sortable" is sorted by a click on a heading, by number or by text.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0], headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, k) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = heading.textContent;
    button.addEventListener("click", () => {
      const falling = heading.getAttribute("aria-sort") === "ascending", sign = falling ? -1 : 1;
      headings.forEach((each) => each.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", falling ? "descending" : "ascending");
      // What has no value comes last in either order.
      const order = (a, b) => {
        const [one, two] = [a, b].map((row) => row.cells[k].dataset.value);
        if (one === "" || two === "") return (one === "") - (two === "");
        return sign * (Number.isNaN(Number(one) - Number(two)) ? one.localeCompare(two) : Number(one) - Number(two));
      };
      body.append(...[...body.rows].sort(order));
    });
    heading.replaceChildren(button);
  });
}
