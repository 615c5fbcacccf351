// How Sphinx ranks what a search of the site finds: pages that explain come before pages that list.
// Its own values, which this file has to repeat: https://github.com/sphinx-doc/sphinx, searchtools.js.
var Scorer = {
  // result: [docname, title, anchor, description, score, filename, kind]
  score: ([page, , , , score, , kind]) =>
    page.startsWith("reference/") || kind === "object" ? score - 1000 : score,
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
