// Drawing on canvases: size, ticks of axes, numbers in print, colours.

const COLOURS = ["#1f77b4", "#d55e00", "#009e73", "#cc79a7", "#8c564b", "#56b4e9"];
const MOST = COLOURS.length;
const RAMP = [
  [68, 1, 84],
  [70, 50, 126],
  [54, 92, 141],
  [39, 127, 142],
  [31, 161, 135],
  [74, 193, 109],
  [160, 218, 57],
  [253, 231, 37],
];
const FILM = [
  [255, 255, 255],
  [226, 208, 232],
  [186, 138, 200],
  [123, 45, 139],
  [62, 16, 78],
];
const LETTERS = "12px system-ui, sans-serif",
  SMALL = "11px system-ui, sans-serif";

// sizes in which canvases are shown; to measure them in each frame would lay out the page each time
const SIZES = new Map();

// a canvas of the size in which it is shown, cleared
function sheet(canvas) {
  if (!SIZES.has(canvas)) SIZES.set(canvas, [canvas.clientWidth, canvas.clientHeight]);
  const [width, height] = SIZES.get(canvas),
    scale = devicePixelRatio || 1;
  const size = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== size[0]) canvas.width = size[0];
  if (canvas.height !== size[1]) canvas.height = size[1];
  const g = canvas.getContext("2d");
  g.setTransform(scale, 0, 0, scale, 0, 0);
  g.clearRect(0, 0, width, height);
  g.font = LETTERS;
  g.lineJoin = g.lineCap = "round";
  return [g, width, height];
}

// round numbers from low to high, about as many as wanted
function ticks(low, high, wanted) {
  const raw = (high - low) / Math.max(wanted, 1);
  if (!(raw > 0) || !isFinite(raw)) return { step: 1, at: [low] };
  const ten = 10 ** Math.floor(Math.log10(raw)),
    step = [1, 2, 5, 10].find((s) => s * ten >= raw * 0.999) * ten;
  const places = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++)
    places.push(k * step);
  return { step, at: places };
}

// powers of ten from low to high, with steps between where they are few
function decades(low, high) {
  const places = [],
    from = Math.floor(Math.log10(low)),
    to = Math.ceil(Math.log10(high));
  const steps = to - from < 2 ? [1, 2, 3, 5] : to - from < 4 ? [1, 3] : [1],
    every = Math.ceil((to - from) / 6);
  for (let e = from; e <= to; e += every) for (const s of steps) places.push(s * 10 ** e);
  return places.filter((v) => v >= low * 0.999 && v <= high * 1.001);
}

// a tick in print, with as many digits as its step needs
function printed(value, step) {
  if (Math.abs(value) < 1e-9 * step) return "0";
  const size = Math.max(Math.abs(value), step);
  if (size >= 1e6 || size < 1e-4) {
    return value
      .toExponential(
        Math.max(0, Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(step))),
      )
      .replace("-", "−");
  }
  return value.toFixed(Math.max(0, -Math.floor(Math.log10(step * 1.001)))).replace("-", "−");
}

// a reading: five digits; what is nothing beside the largest one is 0
function reading(value, largest = 0) {
  if (!isFinite(value)) return "–";
  if (value === 0 || Math.abs(value) < 1e-9 * largest) return "0";
  const size = Math.abs(value);
  return (
    size >= 1e6 || size < 1e-4 ? value.toExponential(3) : String(+value.toPrecision(5))
  ).replace("-", "−");
}

// a colour from dark to bright for a share from 0 to 1
function shade(share, ramp = RAMP) {
  const place = Math.min(Math.max(share, 0), 1) * (ramp.length - 1),
    i = Math.min(Math.floor(place), ramp.length - 2);
  return ramp[i].map((c, k) => Math.round(c + (place - i) * (ramp[i + 1][k] - c)));
}

const css = ([r, g, b]) => `rgb(${r},${g},${b})`;
