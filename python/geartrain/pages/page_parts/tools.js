// The page of results of geartrain: draws what the block "data" holds. Lambda is the frequency of the fundamental over the train's
// characteristic frequency; a point is a periodic motion of a branch, or a motion that time integration found.
"use strict";

// Colours of Okabe and Ito, which the colour-blind tell apart, as in the other pictures of geartrain.
const COLORS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000"];
const DASHES = ["solid", "dash", "dashdot", "dot"];
const UNSTABLE = "5px,3px";
const KINDS = {
  response: "response",
  cascade: "period doublings",
  branch: "from branch points",
  island: "islands",
  integration: "time integration",
  attractors: "attractors",
};
const SPECIALS = { fold: "circle", "period doubling": "diamond", "neimark-sacker": "square", "branch point": "x",
  "stability change": "star" };
const SPECIAL_WORDS = {
  fold: "fold: a sweep in speed jumps",
  "period doubling": "period doubling: half the frequency appears",
  "neimark-sacker": "Neimark-Sacker point: modulation begins",
  "branch point": "branch point: a second motion begins",
  "stability change": "stability change",
};
const LENGTHS = new Set(["rms", "true_ac_rms", "peak_to_peak", "mean", "minimum", "maximum"]);
/** Quantities whose axis does not begin at zero. */
const POSITIONS = new Set(["mean", "minimum", "maximum"]);
/** The buttons of plotly lie over the names on a narrow screen, where two fingers do what they do. */
const config = () => ({
  responsive: true,
  displaylogo: false,
  displayModeBar: window.innerWidth < 700 ? false : true,
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
});
const INK = "#1b1f24";
const AROUND_ONE = [
  [0, "#053061"],
  [0.25, "#4393c3"],
  [0.5, "#f7f7f7"],
  [0.75, "#d6604d"],
  [1, "#67001f"],
];

// ------------------------------------------------------------------------------------------------- unpacking

/** The JSON of a block of the page, with a function that gives its arrays. */
async function unpack(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const whole = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(whole.buffer).getUint32(0, true);
  const told = JSON.parse(new TextDecoder().decode(whole.subarray(4, 4 + length)));
  return [told, (place) => arrayAt(whole, 4 + length, place)];
}

/** An array of a block: its bytes are sorted by their place in the numbers. */
function arrayAt(whole, begin, place) {
  if (!place) return null;
  const Type = { f4: Float32Array, f8: Float64Array, i4: Int32Array, u1: Uint8Array }[place.kind];
  const count = place.shape.reduce((product, extent) => product * extent, 1),
    size = Type.BYTES_PER_ELEMENT;
  const bytes = new Uint8Array(count * size);
  for (let part = 0; part < size; part++) {
    const from = begin + place.at + part * count;
    for (let i = 0; i < count; i++) bytes[i * size + part] = whole[from + i];
  }
  const values = new Type(bytes.buffer);
  values.shape = place.shape;
  return values;
}

/** Unpacks all arrays within an object, in place. */
function unpackAll(object, get) {
  for (const [name, value] of Object.entries(object)) {
    if (!value || typeof value !== "object") continue;
    if ("at" in value && "kind" in value && "shape" in value) object[name] = get(value);
    else unpackAll(value, get);
  }
}

// ------------------------------------------------------------------------------------------------- small tools

/** An element with attributes and children; texts become text, never HTML. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "onclick" || name === "onchange" || name === "onkeydown") element[name] = value;
    else if (value !== false && value != null) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}
const show = (number, digits = 6) =>
  number == null || !Number.isFinite(number) ? "" : String(Number(number.toPrecision(digits)));
/** Names for plotly, which takes some tags for its own. */
const safe = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
const range = (count) => Array.from({ length: count }, (_, i) => i);
const byId = (id) => document.getElementById(id);

// ------------------------------------------------------------------------------------------------- units and labels

/** All that the page holds; the files that are shown, the first and one to compare; what the reader has chosen. */
let data,
  files = [],
  main;
const state = {
  unit: null,
  quantity: null,
  axes: [],
  part: "all",
  mesh: 0,
  spectrum: "p",
  off: new Set(),
  chosen: null,
  mapWhat: "spectral_radius",
  tab: null,
  study: null,
};
const per = (file) => file.perLambda[state.unit];
const unitSuffix = () => ({ Lambda: "", rpm: " rpm", Hz: " Hz" })[state.unit];
const frequencyTitle = () =>
  ({
    Lambda: "fundamental frequency  Λ",
    rpm: `speed of ${safe(main.speedOf)}  [rpm]`,
    Hz: "fundamental frequency  [Hz]",
  })[state.unit];
/** What the curves go over: the speed, or a parameter of the train; its factor, unit and title. */
const acrossFactor = (file) => (main.over ? 1 : per(file));
const acrossSuffix = () =>
  main.over ? (main.overUnit && main.overUnit !== "1" ? ` ${safe(main.overUnit)}` : "") : unitSuffix();
const acrossTitle = () =>
  main.over
    ? safe(main.over.replace(/_/g, " ")) + (main.overUnit && main.overUnit !== "1" ? `  [${safe(main.overUnit)}]` : "")
    : frequencyTitle();
const lengthText = (file) => (file.lengthUnit ? file.lengthUnit.replace("um", "µm") : "b_c");
const lengthUnit = (file) => (file.lengthUnit ? `[${lengthText(file)}]` : "/ b<sub>c</sub>");
/** Whether lengths are drawn in a thousandth of mm, and twists of couplings in mrad. */
const inMicrometres = (file) => /um|mrad/.test(file.lengthUnit);
const quantityWords = (name) => data.quantities[name].words;
function quantityTitle(name) {
  const { unit } = data.quantities[name],
    words = quantityWords(name);
  // A long title takes two lines, or it is cut off on a low plot.
  if (LENGTHS.has(name)) return `${words.replace(" (", "<br>(")}  ${lengthUnit(main)}`;
  return unit === "1" ? words.replace(", ", "<br>") : `${words}  [${unit}]`;
}
const partsOf = (file, name = state.quantity) => file.parts[data.quantities[name].along];
const columnsShown = (file) => (state.part === "all" ? range(partsOf(file).length) : [Number(state.part)]);
const valueAt = (series, name, point, column) => {
  const values = series.values[name];
  return values ? values[point * values.shape[1] + column] : NaN;
};
const isOn = (what) => !state.off.has(what);
const shown = () =>
  files.flatMap((file, number) => (number && !isOn("compare") ? [] : file.series.filter((s) => isOn(s.kind))));
/** Smallest and largest of the numbers that are there; null without any. */
function spanOf(values) {
  let low = Infinity,
    high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : null;
}
/** Whether parts, each with its smallest and largest value, are too unequal for one picture; as in _panels.py. */
function areUnequal(spans, ranges) {
  const there = spans.filter(Boolean);
  if (there.length < 2) return false;
  const sizes = there.map(([low, high]) => (ranges ? high - low : Math.max(Math.abs(low), Math.abs(high))));
  const whole = ranges
    ? Math.max(...there.map(([, high]) => high)) - Math.min(...there.map(([low]) => low))
    : Math.max(...sizes);
  return Math.min(...sizes) < (ranges ? 0.1 : 0.05) * whole;
}
/** The range of an axis for values: a curve that is constant but for some thousandths looks constant. */
function rangeFor([low, high], fromZero) {
  if (fromZero && low >= 0) low = 0;
  const height = Math.max(high - low, 0.05 * Math.max(Math.abs(low), Math.abs(high))) || 1,
    middle = (low + high) / 2;
  return [fromZero && low === 0 ? 0 : middle - 0.56 * height, middle + 0.56 * height];
}
/**
 * Domains of panels one below another between 0 and `top`, the first uppermost, and the names of their axes, the lowest `y`. Above
 * each of several there is room for its name.
 */
function panelsBelow(count, top) {
  const gap = count > 1 ? 0.055 : 0,
    tall = top / count - gap;
  return range(count).map((place) => {
    const low = (count - 1 - place) * (tall + gap);
    return { axis: place === count - 1 ? "y" : `y${place + 3}`, domain: [low, low + tall] };
  });
}
/** The name of a panel, above its upper left corner. */
const panelName = (words, axis) => ({
  text: safe(words),
  xref: "paper",
  yref: `${axis} domain`,
  x: 0,
  y: 1,
  xanchor: "left",
  yanchor: "bottom",
  showarrow: false,
});
const layoutName = (axis) => axis.replace("y", "yaxis");
const isBranch = (series) => series.kind !== "integration" && series.kind !== "attractors";
