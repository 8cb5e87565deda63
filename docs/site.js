// Wide tables and code scroll by keyboard too (axe: scrollable-region-focusable); the theme wraps tables before this.
const reach = () => document.querySelectorAll(".md-typeset__scrollwrap, pre > code").forEach(wrap => { if (wrap.scrollWidth > wrap.clientWidth) wrap.tabIndex = 0; });
addEventListener("load", reach);
addEventListener("resize", reach);
// The bars with the button that copies are told apart (axe: landmark-unique); the theme adds them after the page is there.
const tell = () => document.querySelectorAll(".md-code__nav:not([aria-label])").forEach((bar, k) => bar.setAttribute("aria-label", `code ${bar.parentElement.id || k}`));
addEventListener("load", () => { tell(); new MutationObserver(tell).observe(document.body, { childList: true, subtree: true }); });
// Tables of texts with three columns or more are marked for phones; roles keep them tables where their cells are blocks.
const ROLES = { table: "table", thead: "rowgroup", tbody: "rowgroup", tr: "row", th: "columnheader", td: "cell" };
const mark = table => {
  const long = [...table.rows].some(row => row.cells.length > 2 && [...row.cells].slice(1).some(cell => cell.innerText.length > 40));
  if (!long) return;
  table.dataset.texts = "";
  for (const part of [table, ...table.querySelectorAll("thead, tbody, tr, th, td")]) part.setAttribute("role", ROLES[part.localName]);
};
addEventListener("load", () => document.querySelectorAll(".md-typeset table:not([class])").forEach(mark));
