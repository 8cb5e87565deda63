// Two programs against the same time: their paths with both tips, which limit governs, and the speed of the tip.
(async () => {
  const byId = id => document.getElementById(id), root = document.documentElement;
  const data = JSON.parse(byId("data").textContent), arrays = await Shared.unpack(byId("bytes").textContent, data.arrays);
  const sides = data.sides.filter(side => side.timed), end = Math.max(...sides.map(side => side.end), 0) || 1;
  const range = { low: 0, high: end, end };
  let waiting = false, at = 0, paths = null;
  const redraw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  };
  // one scale for both, or the eye compares nothing
  const curve = (side, name) => ({ x: arrays[`${side.name}.${name}.0.x`], y: arrays[`${side.name}.${name}.0.y`] });
  const highest = one => one.y.reduce((a, b) => b > a ? b : a, 0);
  const most = Math.max(...sides.map(side => highest(curve(side, "feed")))), fastest = Math.max(...sides.map(side => highest(curve(side, "speed"))));
  const top = most > 0 && fastest > 2 * most ? 1.4 * most : 1.05 * fastest || 1;
  for (const side of sides) {
    const both = document.createElement("div");
    both.className = "side";
    byId("curves").append(both);
    side.charts = Charts.make(range, side.tick, "s", x => { at = Math.min(Math.max(x, 0), end); redraw(); }, redraw);
    const canvas = more => {
      const element = document.createElement("canvas");
      element.className = "chart" + more;
      element.setAttribute("role", "img");
      both.append(element);
      return element;
    };
    const name = side.name.toUpperCase();
    side.strip = { title: `${name}: which limit governs`, runs: [] };
    side.charts.add(canvas(" strip"), side.strip);
    side.charts.add(canvas(""), { title: `${name}: tip, mm/s`, digits: 2, bounds: [0, top], series: [
      { name: "programmed", ...curve(side, "feed"), dash: [6, 4], wide: 1.5, role: "--quiet" }, { name: "actual", ...curve(side, "speed"), wide: 1.5, role: "--focus" }] });
  }
  if (!sides.length) byId("curves").remove();

  // --- both paths ---------------------------------------------------------------------------------------
  const drawn = data.sides.filter(side => Paths.hasPath(arrays, side.name));
  if (drawn.length) {
    paths = Paths.make(byId("both"), arrays, drawn.map(side => side.name), () => redraw());
    for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => paths.show(button.dataset.view));
  } else byId("paths").remove();
  if (!sides.length) byId("transport")?.remove();
  // the last frame at or before the cursor
  function frameOf(side) {
    const x = arrays[side.name + ".x"];
    let low = 0, high = x.length - 1;
    while (low < high) { const middle = (low + high + 1) >> 1; if (x[middle] <= at) low = middle; else high = middle - 1; }
    return low;
  }
  // between two frames the tip is on the line between them
  function tipOf(side) {
    const x = arrays[side.name + ".x"], tip = arrays[side.name + ".tip"], k = frameOf(side), next = Math.min(k + 1, x.length - 1);
    const share = x[next] > x[k] ? Math.min((at - x[k]) / (x[next] - x[k]), 1) : 0;
    return [0, 1, 2].map(i => tip[3 * k + i] + share * (tip[3 * next + i] - tip[3 * k + i]));
  }
  function drawPaths() {
    if (!paths) return;
    paths.draw(Object.fromEntries(sides.map(side => [side.name, tipOf(side)])));
    if (!sides.length) return;
    byId("time").value = String(Math.round(1000 * at / end));
    byId("clock").textContent = `${at.toFixed(3)} s: ` + sides.map(side => `${side.name.toUpperCase()} ${at > side.end ? "ended" : "line " + arrays[side.name + ".line"][frameOf(side)]}`).join(", ");
  }
  let playing = false, before = 0;
  function play(on) {
    playing = on;
    byId("play").textContent = on ? "pause" : "play";
    if (!on) return;
    if (at >= end) at = 0;
    before = performance.now();
    requestAnimationFrame(tick);
  }
  function tick(now) {
    if (!playing) return;
    // a long program in 20 s
    at = Math.min(at + Math.max(now - before, 0) / 1000 * Math.max(end / 20, 1), end);
    before = now;
    draw();
    if (at >= end) play(false); else requestAnimationFrame(tick);
  }
  byId("play")?.addEventListener("click", () => play(!playing));
  byId("time")?.addEventListener("input", () => { at = end * Number(byId("time").value) / 1000; redraw(); });

  function draw() {
    drawPaths();
    for (const side of sides) {
      side.strip.title = `${side.name.toUpperCase()}: ${root.classList.contains("paper") ? "limit" : at > side.end ? "ended" : side.limits[arrays[side.name + ".governing"][frameOf(side)]]}`;
      side.charts.draw(at);
    }
  }
  // a fiftieth of what is seen
  function step(direction) {
    at = Math.min(Math.max(at + direction * (range.high - range.low) / 50, 0), end);
    redraw();
  }
  function theme(on) {
    root.dataset.theme = on ? "dark" : "light";
    byId("theme").textContent = on ? "light" : "dark";
    for (const side of sides) {
      side.strip.runs = Shared.runs(arrays[side.name + ".x"], arrays[side.name + ".governing"], k => Shared.limitColour(k, side.joints, side.limits.length));
      for (const chart of side.charts.charts) for (const one of chart.series || []) one.colour = getComputedStyle(root).getPropertyValue(one.role).trim();
    }
    byId("path-legend")?.replaceChildren(...drawn.map(side => {
      const entry = document.createElement("span"), line = document.createElement("i");
      line.className = side.name;
      line.style.background = Paths.colourOf(side.name);
      entry.append(line, side.name.toUpperCase() + (drawn.length < 2 ? "" : side.name === "a" ? ", wide" : ", narrow"));
      return entry;
    }));
    if (drawn.some(side => arrays[side.name + ".rapid"].some(value => value))) {
      const entry = document.createElement("span"), line = document.createElement("i");
      line.className = "rapid";
      entry.append(line, "rapids, dashed");
      byId("path-legend")?.append(entry);
    }
    draw();
  }
  byId("rapids")?.addEventListener("change", event => paths.showRapids(event.target.checked));
  byId("theme").addEventListener("click", () => theme(!Shared.dark()));
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey || !sides.length && !"dr".includes(event.key.toLowerCase())) return;
    const charts = sides[0]?.charts, keys = {
      d: () => theme(!Shared.dark()), D: () => theme(!Shared.dark()), "+": () => charts.zoomAt(at, 0.5), "-": () => charts.zoomAt(at, 2), 0: () => charts.showAll(),
      r: () => byId("rapids")?.click(), R: () => byId("rapids")?.click(), ArrowLeft: () => step(-1), ArrowRight: () => step(1), " ": () => play(!playing),
    };
    if (!keys[event.key] || event.key.startsWith("Arrow") && event.target.closest(".table")) return;  // tables scroll by arrows
    if (event.key === " " && (event.target.tagName === "BUTTON" || !byId("play"))) return;
    event.preventDefault();
    keys[event.key]();
  });
  let wasDark = false;
  const paper = on => {
    if (on) wasDark = Shared.dark();
    root.classList.toggle("paper", on);
    paths?.refit();
    theme(on ? false : wasDark);
  };
  window.addEventListener("beforeprint", () => paper(true));
  window.addEventListener("afterprint", () => paper(false));
  if (paths) new ResizeObserver(() => { paths.refit(); redraw(); }).observe(byId("both"));
  new ResizeObserver(redraw).observe(document.querySelector("main"));
  theme(window.matchMedia("(prefers-color-scheme: dark)").matches);
  document.body.dataset.ready = "yes";
})().catch(error => { document.body.dataset.ready = "failed"; throw error; });
