// One cursor: it moves through frames, and with it the machine, the program's text, the modal state, the curves and the map.
(async () => {
  const byId = id => document.getElementById(id), root = document.documentElement;
  const data = JSON.parse(byId("data").textContent);
  const arrays = await Shared.unpack(byId("bytes").textContent, data.arrays);
  const n = data.frames, joints = data.joints.length;
  data.shapes = Object.fromEntries(Object.entries(data.arrays).map(([name, entry]) => [name, entry.shape]));
  const places = [...document.querySelectorAll("button[data-frame]")];
  data.places = places.map(button => Number(button.dataset.frame));

  // --- colours -------------------------------------------------------------------------------------
  const { dark, jointColour, channels, mix } = Shared, limitColour = k => Shared.limitColour(k, joints, data.limits.length);
  const scaled = (stops, share) => {
    const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
    return mix(stops[k], stops[k + 1], at - k);
  };
  const MARGIN = ["#d98e00", "#2a9d8f", "#1c4fb0"], SPEED = ["#3b2a8c", "#1f9e89", "#e0b400"];
  const text = (tag, content) => { const element = document.createElement(tag); element.textContent = content; return element; };

  // --- the program's text -----------------------------------------------------------------------------
  const ROW = 18, lines = new TextDecoder().decode(arrays.text).split("\n");
  const numbers = data.numbered ? arrays.numbers : null;
  const rowOf = line => {
    if (!numbers) return line - 1;
    let low = 0, high = numbers.length - 1;
    while (low < high) { const middle = (low + high) >> 1; if (numbers[middle] < line) low = middle + 1; else high = middle; }
    return low;
  };
  const numberOf = row => numbers ? numbers[row] : row + 1;
  const firstFrame = new Map();
  for (let i = n - 1; i >= 0; i--) firstFrame.set(arrays.line[i], i);
  byId("code-size").style.height = ROW * lines.length + "px";
  byId("code-size").style.minWidth = Math.min(7 + lines.reduce((most, line) => Math.max(most, line.length), 0), 120) + "ch";
  let lineNow = 0, onPaper = false;
  // so many lines of the program are printed: of more, the first ones, and those about changes of tools, stops and findings
  const PAPER_LINES = 300, PAPER_FIRST = 50, PAPER_NEAR = 4;
  function listPaperRows() {
    const all = lines.map((_, row) => row);
    if (lines.length <= PAPER_LINES) return all;
    const kept = new Set(all.slice(0, PAPER_FIRST));
    for (const line of [data.firstLine, ...data.marks.map(one => one[0]), ...data.stops]) {
      const row = rowOf(line);
      if (!line || kept.size > PAPER_LINES - 2 * PAPER_NEAR) continue;
      for (let k = Math.max(row - PAPER_NEAR, 0); k <= Math.min(row + PAPER_NEAR, lines.length - 1); k++) kept.add(k);
    }
    return [...kept].sort((a, b) => a - b);
  }
  function drawCode() {
    const pane = byId("code"), first = Math.max(Math.floor(pane.scrollTop / ROW) - 5, 0), rows = [];
    const last = Math.min(first + Math.ceil(pane.clientHeight / ROW) + 10, lines.length);
    const shown = onPaper ? listPaperRows() : Array.from({ length: Math.max(last - first, 0) }, (_, k) => first + k);
    byId("left-out").hidden = !onPaper || shown.length === lines.length;
    byId("left-out").textContent = `Printed are ${shown.length} of ${data.programLines} lines: the first ${PAPER_FIRST}, and those about changes of tools, stops and findings.`;
    shown.forEach((row, k) => {
      const element = document.createElement("div"), number = numberOf(row);
      const mark = data.marks.find(one => number >= one[0] && number <= one[1]);
      if (mark) element.className = mark[2];
      if (number === lineNow) element.setAttribute("aria-current", "true");
      if (k && row > shown[k - 1] + 1) element.classList.add("gap");
      // no line ends behind a minus
      element.append(text("span", number), " ", ...lines[row].split(/(\S+-\S+)/).map((part, i) => i % 2 ? Object.assign(text("b", part), { className: "word" }) : part));
      element.dataset.line = number;
      rows.push(element);
    });
    // three columns of paper have room for so many characters each; a few lines may be broken; a short text is on one page
    const long = shown.filter(row => lines[row].length > 28).length;
    byId("code-lines").classList.toggle("narrow", long <= 0.1 * shown.length);
    byId("code-lines").classList.toggle("few", shown.length <= 70);
    byId("code-lines").style.top = first * ROW + "px";
    byId("code-lines").replaceChildren(...rows);
  }
  function showLine(line) {
    if (line === lineNow) return;
    lineNow = line;
    const pane = byId("code"), top = rowOf(line) * ROW;
    if (line > 0 && (top < pane.scrollTop + ROW || top > pane.scrollTop + pane.clientHeight - 3 * ROW)) pane.scrollTop = top - pane.clientHeight / 2;
    drawCode();
  }
  byId("code").addEventListener("scroll", drawCode);
  byId("code").addEventListener("click", event => {
    const row = event.target.closest("[data-line]");
    if (row) toLine(Number(row.dataset.line));
  });
  function toLine(line) {
    for (let next = line; next <= line + 200; next++) if (firstFrame.has(next)) { setCursor(firstFrame.get(next)); return; }
  }

  // --- what stands at the cursor ---------------------------------------------------------------------
  const readout = data.joints.map(joint => {
    const row = byId("readout").tBodies[0].insertRow(), head = text("th", joint.name);
    head.scope = "row";
    row.append(head);
    const value = row.insertCell(), bar = row.insertCell();
    let mark = null;
    if (joint.low !== null && joint.high !== null) {
      bar.innerHTML = "<div class=travel><i></i></div>";
      bar.title = `travel ${joint.low} to ${joint.high} ${joint.unit}`;
      mark = bar.querySelector("i");
    } else bar.textContent = "no limit";
    return { row, value, mark, joint };
  });
  const pairs = (list, into) => into.replaceChildren(...list.map(([name, value]) => {
    const cell = document.createElement("div");
    if (value.length > 16) cell.className = "long";
    cell.append(text("dt", name), text("dd", value));
    return cell;
  }));
  const shown = (value, digits, unit) => Number.isFinite(value) ? fixed(value, digits) + unit : "out of reach";
  function describe(i) {
    readout.forEach(({ row, value, mark, joint }, k) => {
      const q = arrays.q[joints * i + k];
      value.textContent = shown(q, 3, " " + joint.unit);
      const beyond = joint.low !== null && q < joint.low - 1e-6 || joint.high !== null && q > joint.high + 1e-6;
      row.classList.toggle("beyond", beyond);
      if (mark) mark.style.left = 100 * Math.min(Math.max((q - joint.low) / (joint.high - joint.low), 0), 1) + "%";
    });
    const list = [["tip on the table", [0, 1, 2].map(k => fixed(arrays.tip[3 * i + k], 3)).join("  ") + " mm"]];
    if (Number.isFinite(arrays.speed[i])) list.push(["tip speed", fixed(arrays.speed[i], 2) + " mm/s"]);
    const name = data.marginNames[arrays.nearest[i]];
    list.push(["margin", shown(arrays.margin[i], 3, "") + (name ? ", " + name : "")]);
    // a limit without a margin, such as contact
    const broken = data.marks.filter(one => one[2] === "error" && arrays.line[i] >= one[0] && arrays.line[i] <= one[1]).map(one => one[3]);
    if (broken.length) list.push(["violation", [...new Set(broken)].join(", ") + " on this line"]);
    if (data.tilts) list.push(["platform tilt", shown(arrays.alpha_deg[i], 2, " deg")]);
    if (data.limits.length) list.push(["limit", data.limits[arrays.governing[i]]]);
    pairs(list, byId("now"));
    if (arrays.state) pairs(data.modal[arrays.state[i]], byId("modal"));
    byId("clock").textContent = arrays.x[i].toFixed(data.unit === "s" ? 3 : 2) + " " + data.unit + ", line " + arrays.line[i];
  }

  // --- scene --------------------------------------------------------------------------------------------
  let scene = null;
  if (n) {
    try { scene = Scene.make(byId("scene"), byId("close"), data, arrays); }
    catch (error) { byId("note").textContent = "No picture of the machine: this browser does not offer WebGL. " + error.message; }
  }
  const trail = arrays["trail.frame"], colours = new Float32Array(3 * trail.length);
  const entry = (colour, name) => { const row = document.createElement("div"), box = document.createElement("i"); box.style.background = colour; row.append(box, name); return row; };
  function paint() {
    if (!scene) return;
    const kind = byId("colour").value, margin = arrays["trail.margin"], speed = arrays["trail.speed"];
    let fastest = 1e-9;
    for (const value of speed) if (value > fastest) fastest = value;
    const tools = ["#1c6dd0", "#b36b00", "#007a55", "#a63d86", "#c44900", "#57606a"], used = new Set();
    const of = k => {
      if (arrays["trail.bad"][k]) return "#d32f2f";
      if (kind === "margin") return scaled(MARGIN, Number.isFinite(margin[k]) ? margin[k] : 0);
      if (kind === "speed") return scaled(SPEED, speed[k] / fastest);
      const index = (kind === "limit" ? arrays.governing : arrays.tool)[trail[k]];
      used.add(index);
      return kind === "limit" ? limitColour(index) || "#9aa7b4" : tools[index % tools.length];
    };
    for (let k = 0; k < trail.length; k++) channels(of(k)).forEach((value, c) => { colours[3 * k + c] = value / 255; });
    scene.paint(colours);
    scene.draw();
    const legend = byId("legend");
    if (kind === "margin" || kind === "speed") {
      const scale = text("span", ""), ends = kind === "margin" ? ["0 at a limit", "1"] : ["0", fastest.toFixed(1) + " mm/s"];
      scale.className = "scale";
      scale.style.background = `linear-gradient(90deg, ${(kind === "margin" ? MARGIN : SPEED).join(",")})`;
      legend.replaceChildren(text("span", kind === "margin" ? `margin (${data.marginOf}):` : "speed of the tip:"), text("span", ends[0]), scale, text("span", ends[1]));
    } else legend.replaceChildren(...[...used].sort((a, b) => a - b).map(k => kind === "limit" ? entry(limitColour(k) || "#9aa7b4", data.limits[k]) : entry(tools[k % tools.length], data.toolNames[k] ? "tool " + data.toolNames[k] : "the tool")));
    if (arrays["trail.bad"].some(value => value)) legend.append(entry("#d32f2f", "violation"));
    if (arrays["trail.rapid"].some(value => value)) {
      const row = entry("", "rapid, thin and pale");
      row.firstChild.className = "rapid";
      legend.append(row);
    }
  }
  // --- the part and the stock on the table ----------------------------------------------------------------
  const BODIES = { part: "part, deviation", left: "stock that is left", stock: "stock" };
  function showBody(name) {
    scene.showBody(name);
    for (const id of ["part-legend", "probe"]) byId(id).hidden = name !== "part";
    byId("probe").textContent = "click the part to see its deviation there";
  }
  if (scene && scene.bodies.length) {
    const select = byId("body"), { gouge, excess, search } = data.wanted || {};
    for (const [name, title] of Object.entries(BODIES)) if (scene.bodies.includes(name)) select.add(new Option(title, name));
    byId("body-choice").hidden = select.options.length < 2;
    select.addEventListener("change", () => showBody(select.value));
    if (data.wanted) byId("part-legend").replaceChildren(text("span", "part:"), ...[
      ["#c81414", `cut deeper than ${gouge} mm`], ["#1e3cd2", `more than ${excess} mm left on`], ["#bebebe", "within both bounds"],
      ["#786e64", `no cutter within ${search} mm`], ["#e6c828", "not decided"]].map(([colour, name]) => entry(colour, name)));
    showBody(select.value);
  }
  // what is under a place of the picture; the cursor goes to the row that comes nearest to it
  function probe(x, y, isClose) {
    const found = scene.probe(x, y, isClose);
    if (!found) return false;
    const { value, frame } = found, size = fixed(Math.abs(value), 3) + " mm along the normal";
    byId("probe").textContent = "there: " + (Number.isFinite(value) ? (value < 0 ? "cut into by " : "left on: ") + size + ", line " + arrays.line[frame] : "no cutter comes near");
    if (frame >= 0) setCursor(frame);
    return true;
  }
  if (n && scene) byId("note").textContent = ["Assumed sizes: " + data.scene.assumed.join(", ") + ".", data.scene.note].join(" ");
  const options = byId("colour").options;
  if (!data.limits.length) { options[1].remove(); options[1].remove(); }
  byId("colour").addEventListener("change", paint);
  byId("tool-axes").addEventListener("change", event => scene && scene.showAxes(event.target.checked));
  byId("rapids").addEventListener("change", event => scene && scene.showRapids(event.target.checked));
  byId("solids").addEventListener("change", event => scene && scene.show(event.target.checked));
  let viewNow = "fit";
  function view(name) {
    if (!scene) return;
    viewNow = name;
    scene.view(name);
    for (const button of document.querySelectorAll("[data-view]")) button.setAttribute("aria-pressed", String(button.dataset.view === name));
  }
  for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => view(button.dataset.view));
  for (const [canvas, isClose] of [[byId("scene"), false], [byId("close"), true]]) {
    let pressed = null;
    canvas.addEventListener("pointerdown", event => { pressed = [event.offsetX, event.offsetY]; });
    canvas.addEventListener("pointerup", event => {
      if (!scene || !pressed || Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 4) return;
      if (probe(event.offsetX, event.offsetY, isClose)) return;
      const point = scene.pick(event.offsetX, event.offsetY, isClose);
      if (point >= 0) setCursor(trail[point]);
    });
  }

  // --- charts ---------------------------------------------------------------------------------------------
  const end = n ? arrays.x[n - 1] || 1 : 1, range = { low: 0, high: end, end };
  const charts = Charts.make(range, data.tick, data.unit, x => setCursor(nearest(x)), () => redraw());
  const curves = name => data.joints.map((joint, k) => ({ name: joint.name, x: arrays[`${name}.${k}.x`], y: arrays[`${name}.${k}.y`], joint: k })).filter(one => one.x);
  const single = (name, title, more) => arrays[name + ".0.x"] ? [{ name: title, x: arrays[name + ".0.x"], y: arrays[name + ".0.y"], ...more }] : [];
  function addChart(title, digits, series, limits, shares = false, runs = null) {
    if (!series.length) return;
    const canvas = document.createElement("canvas");
    canvas.className = "chart";
    canvas.setAttribute("role", "img");
    byId("charts").append(canvas);
    charts.add(canvas, { title, digits, series, limits, shares, runs });
  }
  let strip = null, bands = null;
  if (n) {
    if (data.limits.length) {
      strip = { title: "limit", runs: [] };
      charts.add(byId("chart-governing"), strip);
      const speeds = [...single("feed", "programmed", { dash: [6, 4], wide: 1.5, role: "--quiet" }), ...single("speed", "actual", { role: "--focus", wide: 1.5 })];
      const [most, fastest] = speeds.map(one => one.y.reduce((a, b) => b > a ? b : a, 0)), beyond = most > 0 && fastest > 2 * most;
      if (beyond) byId("governing-note").textContent = "the curve ends below the speed of rapids";
      // rapids would flatten the feed moves, which are compared here
      charts.add(byId("chart-speed"), { title: "Tip, mm/s", digits: 2, series: speeds, bounds: beyond ? [0, 1.4 * most] : null });
    } else for (const id of ["chart-governing", "times"]) byId(id).closest("section").remove();
    for (const [name, title] of [["velocity", "Velocity, % of limit"], ["acceleration", "Acceleration, % of limit"], ["jerk", "Jerk, % of limit"]]) {
      addChart(title, 1, curves(name), [-100, 100], true);
    }
    // linear joints share a chart, each rotary one has its own
    const position = curves("position"), linear = position.filter(one => data.joints[one.joint].unit === "mm");
    for (const group of [linear, ...position.filter(one => !linear.includes(one)).map(one => [one])]) {
      const own = group.map(one => data.joints[one.joint]);
      addChart(`${own.map(joint => joint.name).join(", ")}, ${own[0]?.unit}`, 3, group, [Math.min(...own.map(j => j.low ?? -Infinity)), Math.max(...own.map(j => j.high ?? Infinity))].map(v => Number.isFinite(v) ? v : null));
    }
    const bad = new Uint8Array(n);
    arrays["trail.frame"].forEach((frame, k) => { bad[frame] ||= arrays["trail.bad"][k]; });
    const broken = Shared.runs(arrays.x, bad, value => value ? "#d32f2f40" : null);
    addChart(`Margin (${data.marginOf}), 0 at a limit` + (bad.some(Boolean) ? "; red: violation" : ""), 3, single("margin", "smallest", { role: "--focus" }), [0], false, broken);
    if (data.tilts) addChart("Platform tilt, deg", 3, single("alpha", "alpha", { role: "--focus" }), []);
    if (data.bands.length) {
      bands = document.createElement("canvas");
      bands.className = "chart";
      bands.style.cursor = "default";
      bands.setAttribute("role", "img");
      bands.setAttribute("aria-label", "Spectrum of each joint's acceleration");
      byId("charts").append(bands);
    }
    if (data.slice) {
      byId("slice-title").textContent = data.slice.title;
      byId("slice").setAttribute("aria-label", "reach of the tip at " + data.slice.title);
    }
  } else document.body.classList.add("empty");

  function recolour() {
    for (const chart of charts.charts) for (const one of chart.series || []) {
      one.colour = one.role ? getComputedStyle(root).getPropertyValue(one.role).trim() : jointColour(one.joint);
    }
    if (strip) strip.runs = Shared.runs(arrays.x, arrays.governing, limitColour);
    for (const box of document.querySelectorAll("[data-limit]")) {
      const colour = limitColour(Number(box.dataset.limit));
      box.style.background = colour || "transparent";
      box.style.border = colour ? "" : "1px solid currentColor";
    }
    if (scene) scene.dark(dark());
    paint();
  }
  let waiting = false;
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      drawCharts();
    });
  }
  function drawCharts() {
    if (!n) return;
    if (strip) strip.title = onPaper ? "limit" : data.limits[arrays.governing[cursor]];
    charts.draw(arrays.x[cursor]);
    if (bands) {
      Charts.spectrum(bands, data.bands, data.joints.map((joint, k) => ({
        name: joint.name, colour: jointColour(k), y: arrays.spectrum.subarray(k * (data.bands.length - 1), (k + 1) * (data.bands.length - 1)) })), "Acceleration by frequency, mm/s², deg/s²");
    }
    if (data.slice) Charts.slice(byId("slice"), data.slice, arrays.reach, data.shapes.reach[0], arrays["trail.tip"], arrays.tip.subarray(3 * cursor, 3 * cursor + 3));
  }

  // --- the cursor -------------------------------------------------------------------------------------------
  let cursor = 0;
  function frameAt(x) {
    let low = 0, high = n - 1;
    while (high > low) { const middle = (low + high + 1) >> 1; if (arrays.x[middle] <= x) low = middle; else high = middle - 1; }
    return low;
  }
  function nearest(x) {
    const i = frameAt(x);
    return i + 1 < n && arrays.x[i + 1] - x < x - arrays.x[i] ? i + 1 : i;
  }
  function setCursor(i, share = 0) {
    if (!n) return;
    cursor = Math.max(0, Math.min(n - 1, Math.round(i)));
    document.body.dataset.cursor = String(cursor);
    byId("time").value = String(cursor);
    showLine(arrays.line[cursor]);
    describe(cursor);
    if (scene) {
      scene.pose(cursor, Math.min(cursor + 1, n - 1), share);
      byId("unreached").hidden = scene.reached();
      scene.draw();
    }
    for (const button of places) button.setAttribute("aria-current", String(Number(button.dataset.frame) === cursor));
    redraw();
  }
  // the first frame of the next block, or of this one or the one before
  function step(forward) {
    let i = cursor;
    if (forward) { while (i < n - 1 && arrays.line[i] === arrays.line[cursor]) i++; }
    else {
      i = Math.max(i - 1, 0);
      while (i > 0 && arrays.line[i - 1] === arrays.line[i]) i--;
    }
    setCursor(i);
  }
  const rates = data.unit === "s" ? [["1/10", 0.1], ["1/4", 0.25], ["1 ×", 1], ["4 ×", 4], ["all in 20 s", end / 20]] : [["all in 60 s", end / 60], ["all in 20 s", end / 20], ["all in 5 s", end / 5]];
  for (const [name, value] of rates) byId("rate").add(new Option(name, value));
  byId("rate").selectedIndex = data.unit !== "s" ? 1 : end > 60 ? 4 : 2;
  let playing = false, place = 0, before = 0;
  function play(on) {
    playing = on && n > 1;
    byId("play").textContent = playing ? "pause" : "play";
    if (!playing) return;
    if (cursor === n - 1) setCursor(0);
    place = arrays.x[cursor];
    before = performance.now();
    requestAnimationFrame(tick);
  }
  function tick(now) {
    if (!playing) return;
    // somebody has moved the cursor meanwhile
    if (frameAt(place) !== cursor) place = arrays.x[cursor];
    place = Math.min(place + Number(byId("rate").value) * Math.max(now - before, 0) / 1000, end);
    before = now;
    const i = frameAt(place), gap = i + 1 < n ? arrays.x[i + 1] - arrays.x[i] : 1;
    setCursor(i, (place - arrays.x[i]) / gap);
    if (place >= end) play(false); else requestAnimationFrame(tick);
  }
  byId("play").addEventListener("click", () => play(!playing));
  byId("block-back").addEventListener("click", () => step(false));
  byId("block-on").addEventListener("click", () => step(true));
  byId("time").max = String(Math.max(n - 1, 0));
  byId("time").addEventListener("input", () => setCursor(Number(byId("time").value)));
  for (const button of places) button.addEventListener("click", () => {
    play(false);
    setCursor(Number(button.dataset.frame));
    if (scene) { scene.look(); byId("stage").scrollIntoView({ block: "nearest" }); for (const other of document.querySelectorAll("[data-view]")) other.setAttribute("aria-pressed", "false"); viewNow = null; }
  });
  const zoom = factor => n && charts.zoomAt(arrays.x[cursor], factor);
  const keys = {
    " ": () => play(!playing), ArrowLeft: () => setCursor(cursor - 1), ArrowRight: () => setCursor(cursor + 1), "[": () => step(false), "]": () => step(true),
    PageUp: () => step(false), PageDown: () => step(true), Home: () => setCursor(0), End: () => setCursor(n - 1), d: () => theme(!dark()), D: () => theme(!dark()), r: () => byId("rapids").click(), R: () => byId("rapids").click(),
    1: () => view("fit"), 2: () => view("part"), 3: () => view("top"), 4: () => view("front"), 5: () => view("tool"),
    "+": () => zoom(0.5), "-": () => zoom(2), 0: () => charts.showAll(),
  };
  document.addEventListener("keydown", event => {
    const tag = event.target.tagName, typed = event.key === " " && (tag === "BUTTON" || tag === "INPUT" && event.target.type === "checkbox");
    if (event.ctrlKey || event.altKey || event.metaKey || typed || tag === "SELECT" || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });

  // --- light and dark -------------------------------------------------------------------------------------------
  function theme(on) {
    root.dataset.theme = on ? "dark" : "light";
    byId("theme").textContent = on ? "light" : "dark";
    recolour();
    redraw();
  }
  byId("theme").addEventListener("click", () => theme(!dark()));
  // paper is white and as wide as A4; what is drawn is drawn for it before the browser takes it
  let wasDark = false;
  function paper(on) {
    if (on) wasDark = dark();
    onPaper = on;
    root.classList.toggle("paper", on);
    byId("printed-on").textContent = "printed on " + new Date().toLocaleDateString("sv");  // as 2026-05-31
    theme(on ? false : wasDark);
    drawCode();
    // two small ones share the width of the paper; a refused program has one
    if (byId("reached")?.childElementCount) byId(on ? "side-by-side" : "main").append(byId("workspace"));
    // the close-up shows all cuts there: the view of the path would be the same picture twice
    if (scene) { scene.resize(); if (viewNow) scene.view(on && viewNow === "part" ? "fit" : viewNow); scene.render(); }
    // browsers may print what the graphics card has drawn as a blank: paper gets a copy
    if (scene && on) {
      const copy = byId("printed"), drawn = byId("scene");
      copy.width = drawn.width;
      copy.height = drawn.height;
      copy.getContext("2d").drawImage(drawn, 0, 0);
    }
    drawCharts();
  }
  window.addEventListener("beforeprint", () => paper(true));
  window.addEventListener("afterprint", () => paper(false));
  for (const button of document.querySelectorAll("button[data-line]")) button.addEventListener("click", () => {
    play(false);
    showLine(Number(button.dataset.line));
    byId("code").scrollIntoView({ block: "nearest" });
  });
  const list = byId("findings"), more = byId("all-findings");
  if (list.children.length > 8) {
    list.classList.add("few");
    more.textContent = `show all ${list.children.length} entries`;
    more.hidden = false;
    more.addEventListener("click", () => { list.classList.remove("few"); more.hidden = true; });
  }
  function resized() {
    if (onPaper) return;  // drawn already, and its height follows from what is drawn
    if (scene) { scene.resize(); if (viewNow) scene.view(viewNow); }
    drawCode();
    redraw();
  }
  new ResizeObserver(resized).observe(byId("stage"));
  new ResizeObserver(redraw).observe(byId("main"));
  theme(window.matchMedia("(prefers-color-scheme: dark)").matches);
  if (scene) scene.resize();
  setCursor(Math.max(data.first, 0));
  if (data.firstLine) showLine(data.firstLine);
  // of a refused program the machine shows which joint is beyond its travel
  view(data.limits.length ? "part" : "fit");
  drawCode();
  window.report = { scene, data, arrays, setCursor, charts, view };
  document.body.dataset.ready = "yes";
})().catch(error => { document.body.dataset.ready = "failed"; throw error; });
