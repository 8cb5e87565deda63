// Two programs against the same time: which limit governs, and the speed of the tip; zoomed and moved together.
(async () => {
  const byId = id => document.getElementById(id), root = document.documentElement;
  const data = JSON.parse(byId("data").textContent), arrays = await Shared.unpack(byId("bytes").textContent, data.arrays);
  const sides = data.sides.filter(side => side.timed), end = Math.max(...sides.map(side => side.end), 0) || 1;
  const range = { low: 0, high: end, end };
  let waiting = false, at = 0;
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
  function draw() {
    for (const side of sides) {
      const x = arrays[side.name + ".x"];
      let k = 0;
      while (k + 1 < x.length && x[k + 1] <= at) k++;
      side.strip.title = `${side.name.toUpperCase()}: ${at > side.end ? "ended" : side.limits[arrays[side.name + ".governing"][k]]}`;
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
    draw();
  }
  byId("theme").addEventListener("click", () => theme(!Shared.dark()));
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey || !sides.length && event.key.toLowerCase() !== "d") return;
    const charts = sides[0]?.charts, keys = {
      d: () => theme(!Shared.dark()), D: () => theme(!Shared.dark()), "+": () => charts.zoomAt(at, 0.5), "-": () => charts.zoomAt(at, 2), 0: () => charts.showAll(),
      ArrowLeft: () => step(-1), ArrowRight: () => step(1),
    };
    if (!keys[event.key] || event.key.startsWith("Arrow") && event.target.closest(".table")) return;  // tables scroll by arrows
    event.preventDefault();
    keys[event.key]();
  });
  let wasDark = false;
  const paper = on => {
    if (on) wasDark = Shared.dark();
    root.classList.toggle("paper", on);
    theme(on ? false : wasDark);
  };
  window.addEventListener("beforeprint", () => paper(true));
  window.addEventListener("afterprint", () => paper(false));
  new ResizeObserver(redraw).observe(document.querySelector("main"));
  theme(window.matchMedia("(prefers-color-scheme: dark)").matches);
  document.body.dataset.ready = "yes";
})().catch(error => { document.body.dataset.ready = "failed"; throw error; });
