// Curves over the program on canvases that share one stretch of it and one cursor. Of many points in a column of pixels the lowest and
// the highest are drawn, so that no peak is lost.

// A number with so many decimals, which is never minus zero.
const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1");

const Charts = (() => {
  const LEFT = 52, RIGHT = 8, TOP = 18, BOTTOM = 18, LEGEND = 16, LANE_GAP = 4;
  // a chart whose curves turn back so often on its width is a band of colour
  const BUSY = 60;
  const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  const onPaper = () => document.documentElement.classList.contains("paper");

  function fit(canvas) {
    const ratio = onPaper() ? 3 : window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "11px system-ui, sans-serif";
    return { context, width, height };
  }
  // title and legend; returns how many rows they take
  function heading(context, width, title, entries) {
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    context.fillStyle = style("--text");
    context.font = "600 12px system-ui, sans-serif";
    // a long title has a row more: nothing is cut off
    const lines = [""], wide = text => context.measureText(text).width;
    for (const word of title.split(" ")) {
      const longer = (lines[lines.length - 1] + " " + word).trim();
      if (wide(longer) > width - 4 && longer !== word) lines.push(word); else lines[lines.length - 1] = longer;
    }
    lines.forEach((line, k) => context.fillText(line, 4, 12 + LEGEND * k));
    const beside = 12 + wide(lines[lines.length - 1]);
    context.font = "12px system-ui, sans-serif";
    const widths = entries.map(({ name }) => 24 + context.measureText(name).width), all = widths.reduce((a, b) => a + b, 0);
    const below = beside + all > width, rows = lines.length + below;
    // on a phone the gaps between entries shrink
    const squeeze = below && all > width ? (width - 4) / all : 1;
    let x = below ? 4 : beside;
    entries.forEach(({ name, colour }, k) => {
      context.fillStyle = colour;
      context.fillRect(x, 4 + LEGEND * (rows - 1), 8, 8);
      context.fillStyle = style("--text");
      context.fillText(name, x + 12, 12 + LEGEND * (rows - 1), squeeze * widths[k] - 14);
      x += squeeze * widths[k];
    });
    context.font = "11px system-ui, sans-serif";
    return rows;
  }
  function ticks(low, high, most) {
    const rough = (high - low) / Math.max(most, 1), power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(k => k * power).find(value => value >= rough) || 10 * power, list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(k * step);
    return { list, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
  }
  // first index whose x is at least a value
  function search(x, value) {
    let low = 0, high = x.length;
    while (low < high) { const middle = (low + high) >> 1; if (x[middle] < value) low = middle + 1; else high = middle; }
    return low;
  }
  function bounds(series, limits) {
    let low = Infinity, high = -Infinity;
    for (const one of series) for (const value of one.y) if (Number.isFinite(value)) { if (value < low) low = value; if (value > high) high = value; }
    if (low > high) { low = 0; high = 1; }
    // a limit that is far from the values would only flatten the curves
    const near = Math.max(high - low, 1e-6);
    for (const limit of limits) if (limit !== null && limit > low - near && limit < high + near) { low = Math.min(low, limit); high = Math.max(high, limit); }
    const border = 0.06 * (high - low || Math.abs(high) || 1);
    return [low - border, high + border];
  }

  function make(view, tick, unit, onCursor, onView) {
    const charts = [];
    const px = (x, width) => LEFT + (x - view.low) / (view.high - view.low) * (width - LEFT - RIGHT);

    // of busy charts every curve has a lane of its own: in one place the last one drawn would hide the others
    const lanesOf = chart => chart.lanes ? chart.series.length : 1;
    // where curves begin: lower where the legend has a row of its own
    const topOf = chart => TOP + (chart.rows === 2 ? LEGEND : 0);
    function axes(chart, context, width, height) {
      context.textBaseline = "middle";
      context.lineWidth = 1;
      const across = ticks(view.low, view.high, width / 90);
      context.textAlign = "center";
      for (const value of across.list) {
        const x = Math.round(px(value, width)) + 0.5;
        context.strokeStyle = style("--grid");
        context.beginPath(); context.moveTo(x, topOf(chart)); context.lineTo(x, height - BOTTOM); context.stroke();
        context.fillStyle = style("--quiet");
        context.fillText(fixed(value, across.digits) + (value === across.list[across.list.length - 1] ? " " + unit : ""), Math.min(x, width - 24), height - 8);
      }
      if (!chart.series) return;
      const up = ticks(...chart.bounds, (height - topOf(chart) - BOTTOM) / lanesOf(chart) / 28);
      context.textAlign = "right";
      for (let lane = 0; lane < lanesOf(chart); lane++) for (const value of up.list) {
        const y = Math.round(py(chart, value, height, lane)) + 0.5;
        context.strokeStyle = style("--grid");
        context.beginPath(); context.moveTo(LEFT, y); context.lineTo(width - RIGHT, y); context.stroke();
        context.fillStyle = style("--quiet");
        context.fillText(fixed(value, up.digits), LEFT - 5, y);
      }
    }
    const py = (chart, value, height, lane) => {
      const room = (height - topOf(chart) - BOTTOM) / lanesOf(chart), gap = chart.lanes ? LANE_GAP : 0;
      return topOf(chart) + (lane + 1) * room - 0.5 * gap - (value - chart.bounds[0]) / (chart.bounds[1] - chart.bounds[0]) * (room - gap);
    };

    function curve(chart, one, k, context, width, height) {
      const lane = chart.lanes ? k : 0, above = chart.lanes ? 0 : chart.series.length - 1 - k;
      const first = Math.max(search(one.x, view.low / tick) - 1, 0), last = Math.min(search(one.x, view.high / tick) + 1, one.x.length);
      context.strokeStyle = one.colour;
      // of joints with equal curves each shows beside the next one, which is above it
      context.lineWidth = one.wide || 1.25 + above * Math.min(1, 3 / chart.series.length);
      context.setLineDash(one.dash || []);
      context.beginPath();
      let open = false, column = null, low = 0, high = 0, end = 0;
      const put = () => {
        if (column === null) return;
        if (!open) context.moveTo(column, low); else context.lineTo(column, low);
        if (high !== low) context.lineTo(column, high);
        if (end !== high) context.lineTo(column, end);
        open = true;
      };
      const dense = last - first > 2 * width;
      for (let i = first; i < last; i++) {
        const value = one.y[i];
        if (!Number.isFinite(value)) { put(); column = null; open = false; continue; }
        const x = px(one.x[i] * tick, width), y = py(chart, value, height, lane), at = dense ? Math.round(x) : x;
        if (column !== null && at === column) { if (y < low) low = y; if (y > high) high = y; end = y; continue; }
        put();
        column = at; low = high = end = y;
      }
      put();
      context.stroke();
      context.setLineDash([]);
    }

    function valueAt(one, x) {
      const k = Math.min(Math.max(search(one.x, x / tick + 0.5) - 1, 0), one.x.length - 1);
      return one.y[k];
    }
    function entries(chart, cursor) {
      return (chart.series || []).map(one => {
        const value = valueAt(one, cursor);
        if (onPaper()) return { colour: one.colour, name: one.name };  // which has no cursor
        return { colour: one.colour, name: one.name + " " + (Number.isFinite(value) ? fixed(value, chart.digits) : "–") };
      });
    }

    function draw(cursor) {
      for (const chart of charts) {
        const { context, width, height } = fit(chart.canvas);
        if (!width) continue;
        const top = TOP + LEGEND * (heading(context, width, chart.title, entries(chart, cursor)) - 1);
        // once low, they stay low: the numbers of the legend change with the cursor
        if (chart.wide !== width) { chart.wide = width; chart.rows = 1; }
        if (top > TOP) chart.rows = 2;
        axes(chart, context, width, height);
        context.save();
        context.beginPath(); context.rect(LEFT, topOf(chart) - 1, width - LEFT - RIGHT, height - topOf(chart) - BOTTOM + 2); context.clip();
        for (const limit of chart.limits || []) {
          if (limit === null) continue;
          for (let lane = 0; lane < lanesOf(chart); lane++) {
            const y = py(chart, limit, height, lane);
            context.strokeStyle = style("--error");
            context.lineWidth = 1; context.setLineDash([5, 4]);
            context.beginPath(); context.moveTo(LEFT, y); context.lineTo(width - RIGHT, y); context.stroke(); context.setLineDash([]);
          }
        }
        if (chart.runs) {
          for (const run of chart.runs) {
            const a = px(run.from, width), b = px(run.to, width);
            if (b < LEFT || a > width || !run.colour) continue;
            context.fillStyle = run.colour;
            context.fillRect(a, topOf(chart), Math.max(b - a, 0.6), height - topOf(chart) - BOTTOM);
          }
        }
        (chart.series || []).forEach((one, k) => curve(chart, one, k, context, width, height));
        const x = px(cursor, width);
        context.strokeStyle = style("--line");
        context.lineWidth = 1;
        if (!onPaper()) { context.beginPath(); context.moveTo(x, 0); context.lineTo(x, height); context.stroke(); }
        context.restore();
      }
    }

    function listen(canvas) {
      const at = event => view.low + (event.offsetX - LEFT) / (canvas.clientWidth - LEFT - RIGHT) * (view.high - view.low);
      let grabbed = null;
      canvas.addEventListener("wheel", event => {
        event.preventDefault();
        zoom(at(event), Math.exp(0.0015 * event.deltaY));
      }, { passive: false });
      canvas.addEventListener("pointerdown", event => { grabbed = { x: event.offsetX, low: view.low, moved: false }; });
      canvas.addEventListener("pointermove", event => {
        if (!grabbed || !(event.buttons & 1)) return;
        if (Math.abs(event.offsetX - grabbed.x) > 3) grabbed.moved = true;
        if (grabbed.moved) move(grabbed.low - (event.offsetX - grabbed.x) / (canvas.clientWidth - LEFT - RIGHT) * (view.high - view.low), view.high - view.low);
      });
      canvas.addEventListener("pointerup", event => { if (grabbed && !grabbed.moved) onCursor(at(event)); grabbed = null; });
      canvas.addEventListener("dblclick", () => move(0, view.end));
    }
    // a place keeps its own place on the screen
    function zoom(x, factor) {
      const span = Math.min(Math.max((view.high - view.low) * factor, 20 * tick), view.end), share = (x - view.low) / (view.high - view.low);
      move(x - share * span, span);
    }
    // by keys: about the cursor, which comes into view if it is not there
    function zoomAt(x, factor) {
      if (x < view.low || x > view.high) move(x - 0.5 * (view.high - view.low), view.high - view.low);
      zoom(x, factor);
    }
    function move(low, span) {
      view.low = Math.min(Math.max(low, 0), view.end - span);
      view.high = view.low + span;
      onView();
    }
    function add(canvas, chart) {
      chart.canvas = canvas;
      chart.lanes = Boolean(chart.limits) && chart.shares && chart.series.some(one => turns(one.y) > BUSY);
      canvas.classList.toggle("lanes", chart.lanes);
      if (chart.series) {
        chart.bounds = chart.bounds || bounds(chart.series, chart.limits || []);
        const most = chart.series.map(one => one.name + " from " + fixed(one.y.reduce((a, b) => b < a ? b : a, Infinity), chart.digits) + " to " + fixed(one.y.reduce((a, b) => b > a ? b : a, -Infinity), chart.digits));
        canvas.setAttribute("aria-label", chart.title + ": " + most.join(", "));
      } else canvas.setAttribute("aria-label", chart.title);
      charts.push(chart);
      listen(canvas);
    }
    return { add, draw, charts, zoomAt, showAll: () => move(0, view.end) };
  }

  // how often a curve in per cent of a limit turns back by more than a tenth of it
  function turns(values) {
    let count = 0, low = values[0], high = values[0], rising = true;
    for (const value of values) {
      if (rising ? value > high : value < low) { high = low = value; continue; }
      if (rising ? value < high - 10 : value > low + 10) { rising = !rising; count++; high = low = value; }
    }
    return count;
  }

  // bands of frequency, both scales logarithmic
  function spectrum(canvas, edges, series, title) {
    const { context, width, height } = fit(canvas);
    if (!width) return;
    const upper = TOP + LEGEND * (heading(context, width, title, series) - 1);
    const low = Math.log10(edges[0]), high = Math.log10(edges[edges.length - 1]);
    let top = 1e-9;
    for (const one of series) for (const value of one.y) top = Math.max(top, value);
    const ceiling = Math.log10(top) + 0.15, floor = ceiling - 4;
    const x = value => LEFT + (Math.log10(value) - low) / (high - low) * (width - LEFT - RIGHT);
    const y = value => height - BOTTOM - (Math.max(Math.log10(Math.max(value, 1e-12)), floor) - floor) / (ceiling - floor) * (height - upper - BOTTOM);
    context.textBaseline = "middle";
    for (let power = Math.ceil(low); power <= high; power++) {
      for (const k of [1, 2, 5]) {
        const value = k * 10 ** power;
        if (value < edges[0] || value > edges[edges.length - 1]) continue;
        context.strokeStyle = style("--grid");
        context.beginPath(); context.moveTo(x(value), upper); context.lineTo(x(value), height - BOTTOM); context.stroke();
        context.fillStyle = style("--quiet");
        context.textAlign = "center";
        context.fillText(value + (k === 1 && power === Math.ceil(low) ? " Hz" : ""), Math.min(x(value), width - 14), height - 8);
      }
    }
    for (let power = Math.ceil(floor); power <= ceiling; power++) {
      const at = y(10 ** power);
      context.strokeStyle = style("--grid");
      context.beginPath(); context.moveTo(LEFT, at); context.lineTo(width - RIGHT, at); context.stroke();
      context.fillStyle = style("--quiet");
      context.textAlign = "right";
      context.fillText(power < -3 || power > 3 ? "1e" + power : String(+(10 ** power).toPrecision(1)), LEFT - 5, at);
    }
    for (const one of series) {
      context.strokeStyle = one.colour;
      context.lineWidth = 1.4;
      context.beginPath();
      one.y.forEach((value, k) => { context.lineTo(x(edges[k]), y(value)); context.lineTo(x(edges[k + 1]), y(value)); });
      context.stroke();
    }
  }

  // a square map of reach, with the path and the cursor in it
  function slice(canvas, map, reach, side, trail, tip) {
    const { context, width, height } = fit(canvas);
    if (!width) return;
    const room = Math.min(width - LEFT - 150, height - BOTTOM - 8), x0 = LEFT, y0 = 4;
    let most = 0;
    for (const value of reach) if (value > most) most = value;
    const isReached = reach.some(Number.isFinite);
    const cell = room / side;
    for (let row = 0; row < side; row++) for (let column = 0; column < side; column++) {
      const value = reach[row * side + column];
      context.fillStyle = Number.isFinite(value) ? `hsl(205 60% ${88 - 48 * Math.max(value, 0) / (most || 1)}%)` : style("--fixed");
      context.fillRect(x0 + column * cell, y0 + room - (row + 1) * cell, cell + 0.6, cell + 0.6);
    }
    const x = value => x0 + (value - map.x[0]) / (map.x[1] - map.x[0]) * room, y = value => y0 + room - (value - map.y[0]) / (map.y[1] - map.y[0]) * room;
    // rapids lead out of the map
    context.save();
    context.beginPath();
    context.rect(x0, y0, room, room);
    context.clip();
    context.strokeStyle = "#10202e";
    context.lineWidth = 1;
    context.beginPath();
    for (let k = 0; k < trail.length; k += 3) context.lineTo(x(trail[k]), y(trail[k + 1]));
    context.stroke();
    context.fillStyle = "#d32f2f";
    context.beginPath(); context.arc(x(tip[0]), y(tip[1]), 4, 0, 7); context.fill();
    context.restore();
    context.fillStyle = style("--quiet");
    context.textBaseline = "middle";
    const few = Math.min(5, room / 32); // numbers stay apart on a narrow map
    for (const value of ticks(...map.x, few).list) { context.textAlign = "center"; context.fillText(String(+value.toFixed(3)), x(value), y0 + room + 10); }
    for (const value of ticks(...map.y, few).list) { context.textAlign = "right"; context.fillText(String(+value.toFixed(3)), x0 - 5, y(value)); }
    context.textAlign = "left";
    const inside = isReached ? [[`${most.toFixed(0)} mm to a limit`, "hsl(205 60% 40%)"], ["at a limit", "hsl(205 60% 88%)"]] : [];
    [...inside, ["out of reach", style("--fixed")]].forEach(([text, colour], k) => {
      context.fillStyle = colour; context.fillRect(x0 + room + 10, 10 + 20 * k, 10, 10);
      context.fillStyle = style("--text"); context.fillText(text, x0 + room + 24, 16 + 20 * k);
    });
  }
  return { make, spectrum, slice, fit };
})();
