// Wide tables scroll by keyboard too (axe: scrollable-region-focusable); the theme wraps them before this.
addEventListener("load", () => document.querySelectorAll(".md-typeset__scrollwrap").forEach(wrap => { wrap.tabIndex = 0; }));
