// What both pages need: packed numbers, and the colours of joints and limits.
const Shared = (() => {
  // numbers as zlib and base64, and where each array is in them
  async function unpack(text, contents) {
    const packed = Uint8Array.from(atob(text), character => character.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const buffer = await new Response(stream).arrayBuffer(), found = {};
    for (const [name, entry] of Object.entries(contents)) {
      found[name] = new window[entry.type](buffer, entry.begin, entry.shape.reduce((a, b) => a * b, 1));
    }
    return found;
  }
  // as many as a hexapod has joints
  const LIGHT = ["#0067a8", "#b36b00", "#007a55", "#a63d86", "#c44900", "#5a3fc0", "#6a7400", "#0a8a9c"];
  const DARK = ["#5db4f0", "#f2b04a", "#3fcf9f", "#e592c9", "#ff8f57", "#b3a2ff", "#c6d055", "#5fdbe8"];
  const dark = () => document.documentElement.dataset.theme === "dark";
  const jointColour = k => (dark() ? DARK : LIGHT)[k % LIGHT.length];
  const channels = colour => [1, 3, 5].map(k => parseInt(colour.slice(k, k + 2), 16));
  const hex = rgb => "#" + rgb.map(value => Math.round(value).toString(16).padStart(2, "0")).join("");
  function mix(a, b, share) { const x = channels(a), y = channels(b); return hex(x.map((value, k) => value + share * (y[k] - value))); }
  // velocity dark, acceleration between, jerk pale, in the colour of the joint; the last three of all are no limits of joints
  function limitColour(k, joints, limits) {
    const order = Math.floor(k / joints), other = limits - 3;
    if (k >= other) return k === other ? (dark() ? "#6d7a86" : "#8b98a5") : k === other + 1 ? (dark() ? "#3a444f" : "#cfd6dc") : null;
    return mix(jointColour(k % joints), dark() ? "#161c23" : "#ffffff", [0, 0.35, 0.62][order]);
  }
  // stretches of one colour
  function runs(x, governing, colourOf) {
    const found = [];
    for (let i = 0; i < x.length; i++) {
      const run = found[found.length - 1], colour = colourOf(governing[i]), to = i + 1 < x.length ? x[i + 1] : x[i];
      if (run && run.colour === colour) run.to = to; else found.push({ from: x[i], to, colour });
    }
    return found;
  }
  return { unpack, dark, jointColour, channels, mix, limitColour, runs };
})();
