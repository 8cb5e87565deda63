// The tool paths of two programs in one view, with the tips at one time. A is wide and B narrow above it: where both agree, A is a border
// of B, also for an eye or a printer without colours.
const Paths = (() => {
  // the two differ in lightness as well as in hue
  const LIGHT = { a: "#3f93d0", b: "#8a3b00" }, DARK = { a: "#2f7fc0", b: "#ffc46b" };
  const WIDTH = { a: 6, b: 1.7 };
  const VIEWS = { all: [0.6, 0.5], top: [0, Math.PI / 2], front: [0, 0], side: [Math.PI / 2, 0] };
  const colourOf = name => (Shared.dark() ? DARK : LIGHT)[name];
  const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const hasPath = (arrays, name) => arrays[name + ".trail"].some(Number.isFinite);

  // sides: their names, of which all have a path
  function make(canvas, arrays, names, onView) {
    let [turn, lift] = VIEWS.all, scale = null, middle = [0, 0, 0];
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    // retracts go far away from the part: cuts are framed, rapids only where there is nothing else
    const hasCuts = names.some(name => arrays[name + ".rapid"].some((rapid, k) => !rapid && Number.isFinite(arrays[name + ".trail"][3 * k])));
    let showsRapids = true;
    for (const name of names) arrays[name + ".trail"].forEach((value, k) => {
      if (!Number.isFinite(value) || arrays[name + ".rapid"][Math.floor(k / 3)] && hasCuts) return;
      low[k % 3] = Math.min(low[k % 3], value);
      high[k % 3] = Math.max(high[k % 3], value);
    });
    const corners = Array.from({ length: 8 }, (_, k) => [0, 1, 2].map(i => k >> i & 1 ? high[i] : low[i]));

    // x to the right, y up, of the screen: z of the part is up, and the eye is at -y and above
    function project(x, y, z) {
      const [c, s, up, deep] = [Math.cos(turn), Math.sin(turn), Math.cos(lift), Math.sin(lift)];
      return [c * x + s * y, deep * (c * y - s * x) + up * z];
    }
    function fit(width, height) {
      middle = [0, 1, 2].map(i => 0.5 * (low[i] + high[i]));
      const [x0, y0] = project(...middle), seen = corners.map(corner => project(...corner));
      const wide = Math.max(...seen.map(p => Math.abs(p[0] - x0)), 1e-3), tall = Math.max(...seen.map(p => Math.abs(p[1] - y0)), 1e-3);
      scale = 0.5 * Math.min((width - 60) / wide, (height - 70) / tall);
    }
    function draw(tips) {
      const { context, width, height } = Charts.fit(canvas);
      if (!width) return;
      if (scale === null) fit(width, height);
      const [x0, y0] = project(...middle);
      const place = (x, y, z) => { const [u, v] = project(x, y, z); return [0.5 * width + scale * (u - x0), 0.5 * height - scale * (v - y0)]; };
      const drawPieces = (name, kind) => {
        const trail = arrays[name + ".trail"], rapid = arrays[name + ".rapid"];
        context.strokeStyle = colourOf(name);
        context.lineWidth = kind ? 1 : WIDTH[name];
        context.globalAlpha = kind ? 0.55 : 1;
        context.setLineDash(kind ? [5, 4] : []);
        context.beginPath();
        let before = null, drawn = false;
        for (let k = 0; k < rapid.length; k++) {
          const here = place(trail[3 * k], trail[3 * k + 1], trail[3 * k + 2]);
          const joins = before && Number.isFinite(here[0]) && rapid[k] === kind;
          if (joins && !drawn) context.moveTo(...before);
          if (joins) context.lineTo(...here);
          drawn = joins;
          before = Number.isFinite(here[0]) ? here : null;
        }
        context.stroke();
      };
      context.lineJoin = context.lineCap = "round";
      for (const name of names) {
        if (showsRapids) drawPieces(name, 1);
        drawPieces(name, 0);
      }
      context.globalAlpha = 1;
      context.setLineDash([]);
      context.font = "600 12px system-ui, sans-serif";
      context.textBaseline = "middle";
      context.textAlign = "center";
      for (const [name, tip] of Object.entries(tips)) {
        const [x, y] = place(...tip), aside = name === "a" ? -16 : 16;
        if (!Number.isFinite(x)) continue;
        context.fillStyle = colourOf(name);
        context.strokeStyle = style("--text");
        context.lineWidth = 1.5;
        context.beginPath();
        context.arc(x, y, name === "a" ? 7 : 4, 0, 7);
        context.fill();
        context.stroke();
        context.fillStyle = style("--text");
        context.fillText(name.toUpperCase(), x + aside, y);
      }
      drawScale(context, width, height);
      drawAxes(context, height);
    }
    // a round length in the corner
    function drawScale(context, width, height) {
      const rough = 90 / scale, power = 10 ** Math.floor(Math.log10(rough)), length = [5, 2, 1].map(k => k * power).find(value => value <= rough);
      context.strokeStyle = context.fillStyle = style("--text");
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(width - 14 - scale * length, height - 12);
      context.lineTo(width - 14, height - 12);
      context.stroke();
      context.font = "12px system-ui, sans-serif";
      context.textAlign = "right";
      context.fillText(`${+length.toPrecision(1)} mm`, width - 14, height - 24);
    }
    function drawAxes(context, height) {
      context.textAlign = "center";
      context.lineWidth = 1.5;
      [["X", 1, 0, 0], ["Y", 0, 1, 0], ["Z", 0, 0, 1]].forEach(([name, ...axis]) => {
        const [u, v] = project(...axis);
        if (Math.hypot(u, v) < 0.1) return;  // it points at the eye
        context.beginPath();
        context.moveTo(42, height - 42);
        context.lineTo(42 + 24 * u, height - 42 - 24 * v);
        context.stroke();
        context.fillText(name, 42 + 34 * u, height - 42 - 34 * v);
      });
    }

    let held = null;
    canvas.addEventListener("pointerdown", event => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointerup", () => { held = null; });
    canvas.addEventListener("pointercancel", () => { held = null; });
    canvas.addEventListener("pointermove", event => {
      if (!held) return;
      const dx = event.clientX - held[0], dy = event.clientY - held[1];
      held = [event.clientX, event.clientY];
      if (event.buttons & 2 || event.shiftKey) {
        const [c, s, up, deep] = [Math.cos(turn), Math.sin(turn), Math.cos(lift), Math.sin(lift)], x = -dx / scale, y = dy / scale;
        middle = [middle[0] + c * x - deep * s * y, middle[1] + s * x + deep * c * y, middle[2] + up * y];
      } else {
        turn -= dx / 150;
        lift = Math.min(Math.max(lift + dy / 150, -Math.PI / 2), Math.PI / 2);
      }
      onView();
    });
    canvas.addEventListener("contextmenu", event => event.preventDefault());
    canvas.addEventListener("wheel", event => { event.preventDefault(); scale *= Math.exp(-event.deltaY / 500); onView(); }, { passive: false });
    const show = name => { [turn, lift] = VIEWS[name]; scale = null; onView(); };
    canvas.addEventListener("dblclick", () => { scale = null; onView(); });
    return { draw, show, showRapids: on => { showsRapids = on; onView(); }, refit: () => { scale = null; } };
  }
  return { make, hasPath, colourOf };
})();
