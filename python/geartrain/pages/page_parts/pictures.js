// The pictures of the chosen motion, computed from its Fourier coefficients.

/** Periods of the fundamental that the coefficients of a motion stand for: its period, or its window, or 16. */
const lengthOf = (series, point) => series.period[point] || series.window?.[point] || 16;

/**
 * Displacement, velocity (by the phase of the fundamental) and force over phases of the fundamental, of each mesh; `row` is that of
 * the coefficients, which a large page has of every so many points only.
 */
function waveform(series, row, phases) {
  const file = files[series.file],
    all = series.coefficients,
    [, meshes, width] = all.shape,
    point = row * series.every,
    period = lengthOf(series, point);
  const base = row * meshes * width,
    orders = series.orders,
    found = [];
  for (let mesh = 0; mesh < meshes; mesh++) {
    const p = new Float64Array(phases.length).fill(all[base + mesh * width]),
      v = new Float64Array(phases.length);
    for (let h = 0; h < orders.length; h++) {
      const a = all[base + mesh * width + 1 + 2 * h],
        b = all[base + mesh * width + 2 + 2 * h];
      if (!(Math.abs(a) + Math.abs(b) > 0)) continue; // not there, NaN
      const order = orders[h] / period;
      for (let i = 0; i < phases.length; i++) {
        const c = Math.cos(order * phases[i]),
          s = Math.sin(order * phases[i]);
        p[i] += a * c + b * s;
        v[i] += order * (b * c - a * s);
      }
    }
    const law = file.laws[mesh];
    found.push({ p, v, force: law ? forces(law, series.lambda[point], phases, p, v) : null });
  }
  return found;
}

/** The force law: of the region of the displacement its stiffness and offset over the phase, and its damping. */
function forces(law, lambda, phases, p, v) {
  const series = (terms, phase) =>
    terms.reduce((sum, [order, c, s]) => sum + c * Math.cos(order * phase) + s * Math.sin(order * phase), 0);
  return Float64Array.from(phases, (phase, i) => {
    const region = law.corners.filter((corner) => p[i] > corner).length;
    return (
      series(law.stiffness[region], phase) * p[i] +
      series(law.offset[region], phase) +
      law.damping[region] * lambda * v[i]
    );
  });
}
const evenly = (count, end) => Float64Array.from({ length: count }, (_, i) => (end * i) / (count - 1));

/** Most points of a picture. */
const MOST = 12000;
const STILL = { displayModeBar: false, responsive: true };
const smallLayout = (x, y, more = {}) => ({
  ...baseLayout(x, y),
  margin: { l: 58, r: 8, t: 8, b: 46 },
  hovermode: "closest",
  ...more,
});

/** What the pictures of the chosen motion share. */
function pictured() {
  const { series } = state.chosen,
    file = files[series.file],
    all = series.coefficients;
  const row = Math.min(Math.round(state.chosen.point / series.every), Math.floor((series.count - 1) / series.every));
  const point = row * series.every,
    lambda = series.lambda[point];
  const there = all && Number.isFinite(all[row * all.shape[1] * all.shape[2]]);
  const period = lengthOf(series, point),
    columns = range(file.parts.mesh.length);
  const shownMeshes = data.quantities[state.quantity].along === "mesh" ? columnsShown(file) : columns;
  const highest = Math.max(1, ...series.orders) / period;
  // A few periods of the slowest excitation, where the period of the train has many, as with hunting teeth.
  const turns = Math.min(period, Math.max(4, period) / file.slowest, MOST / (16 * highest));
  return { series, row, point, file, lambda, there, period, highest, turns, meshes: shownMeshes, all };
}

/** Time histories: what is `p` or `force` of the waveforms. */
function histories({ series, row, file, lambda, there, highest, turns, meshes }, what) {
  const phases = evenly(Math.max(400, Math.ceil(16 * highest * turns)), 2 * Math.PI * turns);
  const waves = there ? waveform(series, row, phases) : null;
  const inTime = state.unit !== "Lambda" && file.perLambda.Hz;
  const scale = inTime ? 1e3 / (file.perLambda.Hz * lambda) : 1;
  const time = Array.from(phases, (phase) => (scale * phase) / (2 * Math.PI));
  const timeTitle = inTime ? "time  [ms]" : "time, periods of the fundamental";
  const lines = waves
    ? meshes
        .filter((mesh) => waves[mesh][what])
        .map((mesh, place) => ({
          type: "scatter",
          mode: "lines",
          x: time,
          y: Array.from(waves[mesh][what]),
          name: safe(file.parts.mesh[mesh]),
          line: { color: COLORS[mesh % COLORS.length], width: 1.8, dash: DASHES[place % DASHES.length], simplify: false },
          hovertemplate: `${safe(file.parts.mesh[mesh])}<br>%{x:.4g}: %{y:.5g}<extra></extra>`,
        }))
    : [];
  return [lines, timeTitle];
}

function drawHistories(picture) {
  const [lines, time] = histories(picture, "p"),
    several = picture.meshes.length > 1;
  Plotly.react(
    "wave",
    lines,
    smallLayout(time, `displacement ${lengthUnit(picture.file)}`, {
      showlegend: several,
      legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom" },
      margin: { l: 58, r: 8, t: several ? 30 : 8, b: 46 },
    }),
    STILL,
  );
}

function drawForces(picture) {
  const [lines, time] = histories(picture, "force"),
    layout = smallLayout(time, `${picture.file.forceWords}  [${picture.file.forceUnit}]`);
  byId("force").hidden = !lines.length;
  const notes = [
    picture.file.forces,
    !picture.there && "The motion has no waveform in the file.",
    picture.there &&
      !picture.series.period[picture.point] &&
      `No period was found: shown are ${duration(picture.file, picture.lambda, picture.turns)} by their Fourier coefficients.`,
    picture.point !== state.chosen.point &&
      `The pictures are those of point ${picture.point + 1}, the nearest that this page has them of.`,
  ].filter(Boolean);
  byId("force-note").textContent = notes.join(" ");
  byId("force-note").hidden = !notes.length;
  if (!lines.length) return;
  layout.yaxis.exponentformat = "none";
  Plotly.react("force", lines, layout, STILL);
}

/** Amplitudes of the force of each mesh at the orders of the motion, by a fast Fourier transform; null without a law. */
function forceLines(series, row, period) {
  const size = 2 ** Math.ceil(Math.log2(Math.max(1024, 8 * Math.max(...series.orders))));
  const phases = Float64Array.from({ length: size }, (_, i) => (2 * Math.PI * period * i) / size);
  return waveform(series, row, phases).map(({ force }) => {
    if (!force) return null;
    const [re, im] = transform(force);
    return Array.from(series.orders, (order) => (2 / size) * Math.hypot(re[order], im[order]));
  });
}

/** The discrete Fourier transform of as many values as a power of 2. */
function transform(values) {
  const size = values.length,
    re = new Float64Array(size),
    im = new Float64Array(size);
  for (let i = 0, reversed = 0; i < size; i++) {
    re[reversed] = values[i];
    let bit = size >> 1;
    for (; bit && reversed & bit; bit >>= 1) reversed ^= bit;
    reversed |= bit;
  }
  for (let half = 1; half < size; half *= 2) {
    for (let k = 0; k < half; k++) {
      const c = Math.cos((Math.PI * k) / half),
        s = -Math.sin((Math.PI * k) / half);
      for (let i = k; i < size; i += 2 * half) {
        const j = i + half,
          a = c * re[j] - s * im[j],
          b = c * im[j] + s * re[j];
        re[j] = re[i] - a;
        im[j] = im[i] - b;
        re[i] += a;
        im[i] += b;
      }
    }
  }
  return [re, im];
}

function drawSpectrum({ series, row, file, lambda, meshes, there, period, all }) {
  const traces = [],
    names = new Map(file.orderNames);
  const factor =
    state.unit === "Hz" && file.perLambda.Hz
      ? file.perLambda.Hz * lambda
      : state.unit === "rpm"
        ? file.perLambda.Hz / (file.perLambda.rpm / 60)
        : 1;
  if (there) {
    const [, count, width] = all.shape;
    const forced = state.spectrum === "force" ? forceLines(series, row, period) : null;
    if (forced) meshes = meshes.filter((mesh) => forced[mesh]);
    const heights = meshes.map((mesh) =>
      series.orders.map((_, h) => {
        if (forced) return forced[mesh][h];
        const base = (row * count + mesh) * width + 1 + 2 * h;
        return Math.hypot(all[base] || 0, all[base + 1] || 0);
      }),
    );
    const largest = Math.max(...heights.flat());
    const seen = range(series.orders.length).filter((h) => heights.some((own) => own[h] > 3e-3 * largest));
    meshes.forEach((mesh, place) => {
      // Side by side, so that no mesh hides another.
      const gap = seen.length > 1 ? Math.min(...seen.slice(1).map((h, i) => series.orders[h] - series.orders[seen[i]])) : 1;
      const x = [],
        y = [],
        told = [];
      for (const h of seen) {
        const order = series.orders[h] / period,
          name = names.get(order);
        const words = `order ${show(order, 6)}${name ? `: ${safe(name)}` : ""}`;
        told.push(words, words, "");
        const at = (factor * (series.orders[h] + gap * 0.16 * (place - (meshes.length - 1) / 2))) / period;
        x.push(at, at, null);
        y.push(0, heights[place][h], null);
      }
      traces.push({
        type: "scatter",
        mode: "lines+markers",
        x,
        y,
        line: { color: COLORS[mesh % COLORS.length], width: 2.5 },
        marker: {
          size: range(x.length).map((i) => (i % 3 === 1 ? 6 : 0)),
          opacity: 1,
          symbol: ["circle", "square", "triangle-up", "diamond"][place % 4],
        },
        text: told,
        hovertemplate: `${safe(file.parts.mesh[mesh])}<br>%{text}<br>%{y:.4g}<extra></extra>`,
      });
    });
  }
  const title = {
    Lambda: "order, multiples of Λ",
    rpm: `orders of ${safe(file.speedOf)}`,
    Hz: "frequency  [Hz]",
  }[state.unit];
  const made = smallLayout(
    title,
    state.spectrum === "force" ? `amplitude of the force  [${file.forceUnit}]` : `amplitude ${lengthUnit(file)}`,
  );
  made.yaxis.rangemode = "tozero";
  made.xaxis.rangemode = "tozero";
  Plotly.react("spectrum", traces, made, STILL);
}

function drawPlane({ series, row, file, there, period, highest, lambda }) {
  const mesh = Math.min(state.mesh, file.parts.mesh.length - 1);
  const part = Math.min(1, MOST / (24 * highest * period));
  const phases = evenly(Math.max(600, Math.ceil(24 * highest * period * part)), 2 * Math.PI * period * part);
  const wave = there ? waveform(series, row, phases)[mesh] : null;
  const made = smallLayout(
    `displacement ${lengthUnit(file)}`,
    `velocity ${inMicrometres(file) ? `[${file.velocityUnit}]` : file.lengthUnit ? "[m/s]" : "/ b<sub>c</sub> ω<sub>c</sub>"}`,
  );
  const half = file.laws[mesh]?.half || 0;
  let inGap = false;
  if (wave && half) {
    const low = Math.min(...wave.p),
      high = Math.max(...wave.p),
      room = 0.06 * (high - low);
    made.xaxis.range = [low - room, high + room];
    made.shapes = [
      {
        type: "rect",
        xref: "x",
        yref: "paper",
        x0: -half,
        x1: half,
        y0: 0,
        y1: 1,
        fillcolor: "#999",
        opacity: 0.18,
        line: { width: 0 },
        layer: "below",
      },
    ];
    inGap = half > low && -half < high;
  }
  const told = [inGap && "grey: the gap", part < 1 && `the first ${show(100 * part, 2)} % of the period`].filter(Boolean);
  byId("gap").textContent = told.join("; ");
  byId("gap").hidden = !told.length;
  // By the phase of the fundamental; over time it is Lambda times that, over 1/characteristic frequency.
  const omega = 2 * Math.PI * file.perLambda.Hz;
  const factor = lambda * (inMicrometres(file) ? 1e-3 * omega : file.lengthUnit ? omega : 1);
  Plotly.react(
    "plane",
    wave
      ? [
          {
            type: "scatter",
            mode: "lines",
            x: Array.from(wave.p),
            y: Array.from(wave.v, (v) => v * factor),
            line: { color: COLORS[mesh % COLORS.length], width: highest * period > 100 ? 0.6 : 1.6, simplify: false },
            hovertemplate: "%{x:.4g}, %{y:.4g}<extra></extra>",
          },
        ]
      : [],
    made,
    STILL,
  );
}

function drawMultipliers({ series, row }) {
  const note = byId("multipliers-note"),
    all = series.multipliers;
  const values = all
    ? range(all.shape[1])
        .map((i) => [0, 1].map((part) => all[(row * all.shape[1] + i) * 2 + part]))
        .filter((z) => Number.isFinite(z[0]))
    : [];
  byId("multipliers").hidden = !values.length;
  note.hidden = false;
  if (!values.length) {
    note.textContent = "Multipliers: not in the file for this motion.";
    return;
  }
  const sizes = values.map((z) => Math.hypot(...z)),
    largest = Math.max(...sizes);
  const outside = sizes.filter((size) => size > 1).length;
  note.textContent = `Largest magnitude of a multiplier ${show(largest, 6)}; outside the unit circle: ${outside || "none"}.`;
  const traces = [false, true].map((out) => {
    const own = values.filter((_, i) => sizes[i] > 1 === out);
    return {
      type: "scatter",
      mode: "markers",
      x: own.map((z) => z[0]),
      y: own.map((z) => z[1]),
      marker: {
        size: 9,
        color: out ? "#D55E00" : "#0072B2",
        symbol: out ? "diamond" : "circle",
        line: { color: "#fff", width: 1 },
      },
      hovertemplate: `%{x:.5g}, %{y:.5g} i<extra>${out ? "outside" : "inside"}</extra>`,
    };
  });
  const reach = 1.15 * Math.max(1, largest);
  const made = smallLayout("real part", "imaginary part", {
    shapes: [{ type: "circle", x0: -1, x1: 1, y0: -1, y1: 1, line: { color: INK, width: 1.3 } }],
  });
  made.yaxis.scaleanchor = "x";
  made.yaxis.range = [-reach, reach];
  made.xaxis.range = [-reach, reach];
  Plotly.react("multipliers", traces, made, STILL);
}
