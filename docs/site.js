// Tables are marked for phones (site.css). Those of two columns keep to the width. In others the cells stand below each
// other where a cell is long, or where the table is too wide and has more texts than numbers. Roles keep those tables,
// and a cell says its column, because the head is hidden there.
const ROLES = { table: "table", thead: "rowgroup", tbody: "rowgroup", tr: "row", th: "columnheader", td: "cell" };
const mark = table => {
  if (!table.checkVisibility()) return;
  const heads = [...table.tHead.rows[0].cells].map(cell => cell.textContent.trim());
  for (const code of table.querySelectorAll("code")) code.classList.toggle("long", code.textContent.length > 24);
  if (heads.length < 3) { table.dataset.pairs = ""; return; }
  const cells = [...table.tBodies[0].rows].flatMap(row => [...row.cells].slice(1));
  // numbers of one measurement stay on one line: 0.010, 0.000 / 0.007, 0.000
  for (const cell of cells) if (/^[-\d., /]+$/.test(cell.textContent)) cell.textContent = cell.textContent.replaceAll(", ", ",\u00a0");
  // and so do X Y Z of one place, and A C
  for (const cell of cells) if (/^(-?[\d.]+ ){2}-?\d/.test(cell.textContent)) cell.textContent = cell.textContent.replace(/ (?=C)|(-?[\d.]+) (-?[\d.]+) (?=-?\d)/g, (_all, x, y) => x ? `${x}\u00a0${y}\u00a0` : "\u00a0");
  const wrap = table.closest(".md-typeset__scrollwrap") || table;
  table.toggleAttribute("data-examples", heads.length === 3 && heads[1] === "example");
  table.toggleAttribute("data-wide", wrap.scrollWidth > wrap.clientWidth);
  const texts = cells.filter(cell => !/^[-+<>]?\.?\d/.test(cell.textContent.trim())).length;
  const crowded = wrap.scrollWidth > wrap.clientWidth && texts > cells.length / 2;
  if (!crowded && !cells.some(cell => cell.textContent.length > 40)) return;
  table.dataset.texts = "";
  for (const part of [table, ...table.querySelectorAll("thead, tbody, tr, th, td")]) part.setAttribute("role", ROLES[part.localName]);
  for (const cell of cells) cell.dataset.head = heads[cell.cellIndex];
};
addEventListener("load", () => document.querySelectorAll(".md-typeset table:not([class])").forEach(mark));
// Wide tables and code scroll by keyboard too (axe: scrollable-region-focusable); the theme wraps tables before this.
const reach = () => document.querySelectorAll(".md-typeset__scrollwrap, pre > code").forEach(wrap => {
  if (wrap.scrollWidth > wrap.clientWidth) {
    wrap.tabIndex = 0;
    wrap.querySelector("table:not([class])")?.setAttribute("data-wide", "");
  }
  const show = () => wrap.toggleAttribute("data-more", wrap.scrollLeft + wrap.clientWidth < wrap.scrollWidth - 1);
  wrap.onscroll = show;
  show();
});
addEventListener("load", reach);
addEventListener("resize", reach);
// The bars with the button that copies are told apart (axe: landmark-unique); the theme adds them after the page is there.
const tell = () => document.querySelectorAll(".md-code__nav:not([aria-label])").forEach((bar, k) => bar.setAttribute("aria-label", `code ${bar.parentElement.id || k}`));
addEventListener("load", () => { tell(); new MutationObserver(tell).observe(document.body, { childList: true, subtree: true }); });
// A line of a console or an option in a text goes on at a blank (site.css), never after the hyphen of an option or of a
// negative number; one that is wider than a phone breaks there.
document.querySelectorAll(".language-console code, .md-typeset :not(pre) > code").forEach(code => {
  const walker = document.createTreeWalker(code, NodeFilter.SHOW_TEXT), texts = [];
  while (walker.nextNode()) if (/\S-|-\S/.test(walker.currentNode.data)) texts.push(walker.currentNode);
  for (const text of texts) text.replaceWith(...text.data.split(/(\S*-\S*)/).map((part, k) => {
    if (k % 2 === 0) return part;
    const whole = document.createElement("span");
    whole.className = "whole";
    whole.textContent = part;
    return whole;
  }));
});
document.querySelectorAll('.language-console [id^="line-"]').forEach(line => {
  const before = /^( {2}\S+(?: \S+)* {2,}| {8,})(?=\S)/.exec(line.textContent);
  line.classList.toggle("fixed", before !== null && line.textContent.length <= 105);
  if (before && before[0].length <= 20) line.style.setProperty("--hang", `${before[0].length}ch`);
});
// The options of all commands are many screens of a phone: there each command opens its own.
if (matchMedia("(max-width: 44.9375em)").matches) document.querySelectorAll("details.options").forEach(list => list.removeAttribute("open"));
// A table in a closed part has no width until somebody opens it.
addEventListener("toggle", event => {
  event.target.querySelectorAll("table:not([class])").forEach(mark);
  reach();
}, true);
// What the button of a console copies: the file that `cat` shows first, else the commands, without prompt and output.
document.querySelectorAll(".language-console").forEach(box => {
  const lines = box.querySelector("code").textContent.trimEnd().split("\n");
  const starts = [...lines.keys()].filter(at => lines[at].startsWith("$ "));
  const shown = starts.length && lines[starts[0]].startsWith("$ cat ") ? lines.slice(starts[0] + 1, starts[1])
    : starts.length ? starts.map(at => lines[at].slice(2)) : lines;
  box.dataset.copy = shown.join("\n");
});
// A box of a checklist has its line as name (axe: label).
document.querySelectorAll(".task-list-item > input").forEach(box => box.setAttribute("aria-label", box.parentElement.textContent.trim()));
// The search wants all words of a plain query (the theme: any of them), and takes the dashes of an option for no operator.
// The options of convert stand first then. Where nothing has all words, the theme's way is asked. drilled finds drilling:
// an ending is taken away, and the word as typed stands first (the theme's stemmer would not find a word half typed).
// CYCLE83 and G43 are whole words, and not the beginning of CYCLE832.
const cut = word => {
  if (/^[a-z]+\d[\d.]*$/i.test(word)) return `+${word}`;
  const stem = word.replace(/(?:ing|(?<!e)ed|(?<!s)e?s)$/i, "").replace(/([bdgmnprt])\1$/i, "$1");
  return stem !== word && /^[a-z]{3,}$/i.test(stem) && /[aeiouy]/i.test(stem) ? `+${stem}* ${word}^2` : `+${word}* ${word}^4`;
};
// Words of users for those of the pages.
const SYNONYMS = [
  [/\btool tables?\b/gi, "tool tables"], [/\btcpc\b/gi, "tool centre point"],
  [/\bcenter/gi, "centre"], [/\bcolor/gi, "colour"], [/\bpost-?process/gi, "post process"],
  [/\b(?:axis|axes|soft|software) (?=limits?\b)/gi, "travel "],
];
const asked = query => {
  if (!/^[-\w#.+ ]*\w[-\w#.+ ]*$/.test(query)) return query;
  const meant = SYNONYMS.reduce((text, [word, ours]) => text.replace(word, ours), query);
  const words = meant.replace(/(^|\s)[-+]+/g, " ").trim().split(/[\s-]+/).filter(word => word);
  return words.map(cut).join(" ") + (/(^|\s)--\w/.test(query) ? " title:convert^40" : "");
};
const post = Worker.prototype.postMessage, asks = [];
Worker.prototype.postMessage = function (message, ...rest) {
  if (message.type !== 2) return post.call(this, message, ...rest); // 2: a query, 3: its result
  const ask = (query, other) => { asks.push(other); post.call(this, { type: 2, data: query }); };
  this.onmessage = ({ data }) => {
    const other = data.type === 3 && asks.shift();
    if (other && !data.data.items.length && !asks.length) ask(other);
  };
  ask(asked(message.data), message.data.replace(/(^|\s)[-+]+/g, " "));
};
