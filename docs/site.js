// Wide tables and code scroll by keyboard too (axe: scrollable-region-focusable); the theme wraps tables before this.
const reach = () => document.querySelectorAll(".md-typeset__scrollwrap, pre > code").forEach(wrap => { if (wrap.scrollWidth > wrap.clientWidth) wrap.tabIndex = 0; });
addEventListener("load", reach);
addEventListener("resize", reach);
// The bars with the button that copies are told apart (axe: landmark-unique); the theme adds them after the page is there.
const tell = () => document.querySelectorAll(".md-code__nav:not([aria-label])").forEach((bar, k) => bar.setAttribute("aria-label", `code ${bar.parentElement.id || k}`));
addEventListener("load", () => { tell(); new MutationObserver(tell).observe(document.body, { childList: true, subtree: true }); });
