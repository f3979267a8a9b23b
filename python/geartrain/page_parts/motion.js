// The motion that is chosen: where it is on the curves, its facts and its pictures.

/** A line at the chosen speed, and a ring at each of its values; always as many, so that they can be moved alone. */
function selectionShapes() {
  const file = state.chosen ? files[state.chosen.series.file] : main;
  const rings = Math.max(...files.map((other) => columnsShown(other).length));
  const x = state.chosen ? state.chosen.series.lambda[state.chosen.point] * per(file) : 0;
  const there = Boolean(state.chosen);
  const shapes = [
    {
      type: "line",
      xref: "x",
      yref: "paper",
      x0: x,
      x1: x,
      y0: 0,
      y1: 1,
      line: { color: INK, width: 1 },
      opacity: 0.45,
      visible: there,
    },
  ];
  for (let ring = 0; ring < rings; ring++) {
    const column = columnsShown(file)[ring];
    const y = there && column !== undefined ? valueAt(state.chosen.series, state.quantity, state.chosen.point, column) : NaN;
    shapes.push({
      type: "circle",
      xref: "x",
      yref: "y",
      xsizemode: "pixel",
      ysizemode: "pixel",
      xanchor: x,
      yanchor: Number.isFinite(y) ? y : 0,
      x0: -7,
      x1: 7,
      y0: -7,
      y1: 7,
      line: { color: INK, width: 2.5 },
      visible: Number.isFinite(y),
    });
  }
  return shapes;
}

function choose(series, point, column) {
  state.chosen = { series, point };
  if (data.quantities[state.quantity].along === "mesh" && column != null) setMesh(column);
  const plot = byId("curve"),
    changes = {};
  if (plot.layout) {
    selectionShapes().forEach((shape, place) => {
      for (const name of ["x0", "x1", "xanchor", "yanchor", "visible"]) {
        if (name in shape && (place === 0 || (name !== "x0" && name !== "x1")))
          changes[`shapes[${place}].${name}`] = shape[name];
      }
    });
    Plotly.relayout(plot, changes);
  }
  drawPoint();
}

function moveKeys(event) {
  if (!state.chosen || event.ctrlKey || event.altKey || event.metaKey) return;
  const { series, point } = state.chosen,
    step = event.shiftKey ? 10 : 1,
    last = series.count - 1;
  const next = { ArrowRight: point + step, ArrowLeft: point - step, Home: 0, End: last }[event.key];
  if (next !== undefined) {
    event.preventDefault();
    choose(series, Math.min(Math.max(next, 0), last));
  } else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
    event.preventDefault();
    const all = shown().filter((one) => one.count);
    if (!all.length) return;
    const place = all.indexOf(series) + (event.key === "ArrowDown" ? 1 : -1);
    const other = all[(place + all.length) % all.length];
    // The point of the other branch that is nearest in speed.
    const at = series.lambda[point] * per(files[series.file]),
      factor = per(files[other.file]);
    let best = 0;
    for (let i = 1; i < other.count; i++) {
      if (Math.abs(other.lambda[i] * factor - at) < Math.abs(other.lambda[best] * factor - at)) best = i;
    }
    choose(other, best);
  }
}

function setMesh(mesh) {
  state.mesh = mesh;
  const select = byId("plane-mesh");
  if (select) select.value = String(mesh);
}

function pointPanels() {
  const [meshLabel, select] = choice(
    "phase plane of",
    main.meshes.map((name, place) => [String(place), name]),
    "0",
    (mesh) => {
      state.mesh = Number(mesh);
      drawPoint();
    },
  );
  select.id = "plane-mesh";
  const small = (id, words) => make("div", { id, class: "plot small", role: "img", "aria-label": words });
  return [
    make(
      "section",
      { "aria-label": "The chosen motion", id: "point" },
      make("h2", {}, "The chosen motion"),
      make("div", { id: "facts", "aria-live": "polite" }),
    ),
    make(
      "section",
      { "aria-label": "Time histories of the chosen motion" },
      small("wave", "Displacement of the meshes over time"),
      small("force", "Force of the meshes over time"),
      make("p", { class: "note", id: "force-note", hidden: true }),
    ),
    make(
      "section",
      { "aria-label": "Phase plane, spectrum and multipliers of the chosen motion" },
      make(
        "div",
        { class: "pair" },
        make("div", {}, small("spectrum", "Spectrum of the displacement")),
        make(
          "div",
          {},
          small("plane", "Phase plane: velocity over displacement"),
          make("div", { class: "controls" }, meshLabel),
        ),
      ),
      small("multipliers", "Floquet multipliers and the unit circle"),
      make("p", { class: "note", id: "multipliers-note", hidden: true }),
    ),
  ];
}

const PICTURES = [drawHistories, drawForces, drawSpectrum, drawPlane, drawMultipliers];
let left = 0,
  next = 0;
/** Facts at once; the pictures one a frame, by turns, so that a held key does not wait for them. */
function drawPoint() {
  if (!state.chosen) return;
  drawFacts();
  if (!left) requestAnimationFrame(drawNext);
  left = PICTURES.length;
}

function drawNext() {
  if (state.tab === "response") PICTURES[next](pictured());
  next = (next + 1) % PICTURES.length;
  left -= 1;
  if (left) requestAnimationFrame(drawNext);
  byId("point").dataset.drawn = left ? "no" : "yes";
}

function verdict(series, point) {
  if (!isBranch(series) && series.kinds[point] !== "periodic") return series.kinds[point];
  if (!series.stable) return "stability not asked for";
  if (series.multipliers && Number.isNaN(series.multipliers[point * series.multipliers.shape[1] * 2]))
    return "stability not known";
  const words = series.stable[point] ? "stable" : "unstable";
  return series.undecided?.[point]
    ? `${words}, but undecided: the largest multiplier is as near to the unit circle as it is uncertain`
    : words;
}

function drawFacts() {
  const { series, point } = state.chosen,
    file = files[series.file],
    facts = [];
  const fact = (name) => series.facts[name]?.[point];
  const lambda = series.lambda[point],
    speeds = [];
  if (file.perLambda.rpm) speeds.push(`${show(lambda * file.perLambda.rpm)} rpm of ${file.speedOf}`);
  if (file.perLambda.Hz) speeds.push(`${show(lambda * file.perLambda.Hz)} Hz`);
  if (!(file.perLambda.rpm && Math.abs(file.perLambda.rpm - 1) < 1e-9)) speeds.unshift(`Λ = ${show(lambda, 7)}`);
  facts.push([
    "motion",
    `${files.length > 1 ? `${file.name || file.title}, ` : ""}${series.name}, point ${point + 1} of ${series.count}` +
      (series.directions?.[point] ? `, ${series.directions[point] === "up" ? "rising" : "falling"} speed` : ""),
  ]);
  facts.push(["speed", speeds.join(", ")]);
  facts.push(["verdict", verdict(series, point)]);
  facts.push(["period", series.period[point] ? `${series.period[point]} of the fundamental` : "none found"]);
  if (Number.isFinite(fact("error_estimate"))) {
    facts.push([
      "error",
      `${show(fact("error_estimate"), 2)} of the waveform, estimated${fact("estimate_doubtful") ? ", doubtful" : ""}`,
    ]);
  }
  if (Number.isFinite(fact("correction"))) facts.push(["refined", `by shooting; it moved by ${show(fact("correction"), 2)}`]);
  if (fact("harmonics")) facts.push(["harmonics", show(fact("harmonics"))]);
  if (Number.isFinite(fact("share"))) facts.push(["share of starts", `${show(100 * fact("share"), 3)} %`]);
  if (Number.isFinite(fact("lyapunov_exponent"))) {
    facts.push([
      "Lyapunov exponent",
      `${show(fact("lyapunov_exponent"), 3)} ± ${show(fact("lyapunov_error"), 2) || 0} (1/characteristic frequency)`,
    ]);
  }
  if (fact("floating")) facts.push(["floating", "no mean torque holds a mesh in its gap: its mean position is not unique"]);
  const list = make("dl", {}, ...facts.flatMap(([name, words]) => [make("dt", {}, name), make("dd", {}, words)]));
  const names = [
    "rms",
    "mean",
    "minimum",
    "maximum",
    "mesh_force_maximum",
    "dynamic_factor",
    "separation_fraction",
    "back_contact_fraction",
  ].filter((name) => series.values[name]);
  const unit = (name) => (LENGTHS.has(name) ? lengthText(file) : { N: " N" }[data.quantities[name].unit] || "");
  const head = make(
    "tr",
    {},
    make("th", { scope: "col" }, ""),
    ...file.meshes.map((name) => make("th", { scope: "col" }, name)),
  );
  const body = names.map((name) =>
    make(
      "tr",
      {},
      make("th", { scope: "row" }, name.replace(/_/g, " ").replace("mesh force maximum", "largest force")),
      ...file.meshes.map((_, mesh) => {
        const value = valueAt(series, name, point, mesh);
        return make("td", {}, Number.isFinite(value) ? show(value, 5) + unit(name) : "");
      }),
    ),
  );
  byId("facts").replaceChildren(
    list,
    make("div", { class: "scroll" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))),
  );
}

/** Displacement, velocity (by the phase of the fundamental) and force over phases of the fundamental, of each mesh. */
function waveform(series, point, phases) {
  const file = files[series.file],
    all = series.coefficients,
    [, meshes, width] = all.shape,
    period = series.period[point] || 16;
  const base = point * meshes * width,
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

/** The force law: stiffness over the phase times the displacement beyond the gap, and the damping. */
function forces(law, lambda, phases, p, v) {
  const flank = (terms, phase) =>
    terms.reduce((sum, [order, c, s]) => sum + c * Math.cos(order * phase) + s * Math.sin(order * phase), 0);
  return Float64Array.from(phases, (phase, i) => {
    const region = p[i] > law.half || law.half === 0 ? 2 : p[i] < -law.half ? 0 : 1;
    const elastic =
      region === 2
        ? flank(law.drive, phase) * (p[i] - law.half)
        : region === 0
          ? flank(law.back, phase) * (p[i] + law.half)
          : 0;
    return elastic + law.damping[region] * lambda * v[i];
  });
}
const evenly = (count, end) => Float64Array.from({ length: count }, (_, i) => (end * i) / (count - 1));

const STILL = { displayModeBar: false, responsive: true };
const smallLayout = (x, y, more = {}) => ({
  ...baseLayout(x, y),
  margin: { l: 58, r: 8, t: 8, b: 40 },
  hovermode: "closest",
  ...more,
});

/** What the pictures of the chosen motion share. */
function pictured() {
  const { series, point } = state.chosen,
    file = files[series.file],
    lambda = series.lambda[point];
  const there =
    series.coefficients &&
    Number.isFinite(series.coefficients[point * series.coefficients.shape[1] * series.coefficients.shape[2]]);
  const period = series.period[point] || 16,
    columns = range(file.meshes.length);
  const shownMeshes = data.quantities[state.quantity].along === "mesh" ? columnsShown(file) : columns;
  const highest = Math.max(1, ...series.orders) / period;
  // A few periods of the slowest excitation, where the period of the train has many, as with hunting teeth.
  const turns = Math.min(period, Math.max(4, period) / file.slowest);
  return { series, point, file, lambda, there, period, highest, turns, meshes: shownMeshes, all: series.coefficients };
}

/** Time histories: what is `p` or `force` of the waveforms. */
function histories({ series, point, file, lambda, there, highest, turns, meshes }, what) {
  const phases = evenly(Math.min(8000, Math.max(400, Math.ceil(16 * highest * turns))), 2 * Math.PI * turns);
  const waves = there ? waveform(series, point, phases) : null;
  const inTime = state.unit !== "Lambda" && file.perLambda.Hz;
  const scale = inTime ? 1e3 / (file.perLambda.Hz * lambda) : 1;
  const time = Array.from(phases, (phase) => (scale * phase) / (2 * Math.PI));
  const timeTitle = inTime ? "time  [ms]" : "time, periods of the fundamental";
  const lines = waves
    ? meshes
        .filter((mesh) => waves[mesh][what])
        .map((mesh, row) => ({
          type: "scatter",
          mode: "lines",
          x: time,
          y: Array.from(waves[mesh][what]),
          name: safe(file.meshes[mesh]),
          line: { color: COLORS[mesh % COLORS.length], width: 1.8, dash: DASHES[row % DASHES.length] },
          hovertemplate: `${safe(file.meshes[mesh])}<br>%{x:.4g}: %{y:.5g}<extra></extra>`,
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
      margin: { l: 58, r: 8, t: several ? 30 : 8, b: 40 },
    }),
    STILL,
  );
}

function drawForces(picture) {
  const [lines, time] = histories(picture, "force"),
    layout = smallLayout(time, "mesh force  [N]");
  byId("force").hidden = !lines.length;
  byId("force-note").textContent = picture.file.forces;
  byId("force-note").hidden = !picture.file.forces;
  if (!lines.length) return;
  layout.yaxis.exponentformat = "none";
  Plotly.react("force", lines, layout, STILL);
}

function drawSpectrum({ series, point, file, meshes, there, period, all }) {
  const traces = [],
    names = new Map(file.orderNames);
  const factor =
    state.unit === "Hz" && file.perLambda.Hz
      ? file.perLambda.Hz * series.lambda[point]
      : state.unit === "rpm"
        ? file.perLambda.Hz / (file.perLambda.rpm / 60)
        : 1;
  if (there) {
    const [, count, width] = all.shape;
    const rows = meshes.map((mesh) =>
      series.orders.map((_, h) => {
        const base = (point * count + mesh) * width + 1 + 2 * h;
        return Math.hypot(all[base] || 0, all[base + 1] || 0);
      }),
    );
    const largest = Math.max(...rows.flat());
    const seen = range(series.orders.length).filter((h) => rows.some((row) => row[h] > 3e-3 * largest));
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
        y.push(0, rows[place][h], null);
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
        hovertemplate: `${safe(file.meshes[mesh])}<br>%{text}<br>%{y:.4g}<extra></extra>`,
      });
    });
  }
  const title = {
    Lambda: "order, multiples of Λ",
    rpm: `order, per revolution of ${safe(file.speedOf)}`,
    Hz: "frequency  [Hz]",
  }[state.unit];
  const made = smallLayout(title, `amplitude ${lengthUnit(file)}`);
  made.yaxis.rangemode = "tozero";
  made.xaxis.rangemode = "tozero";
  Plotly.react("spectrum", traces, made, STILL);
}

function drawPlane({ series, point, file, there, period, highest, lambda }) {
  const mesh = Math.min(state.mesh, file.meshes.length - 1);
  const phases = evenly(Math.min(8000, Math.max(600, Math.ceil(24 * highest * period))), 2 * Math.PI * period);
  const wave = there ? waveform(series, point, phases)[mesh] : null;
  const made = smallLayout(
    `displacement ${lengthUnit(file)}`,
    `velocity ${file.lengthUnit === "um" ? "[mm/s]" : file.lengthUnit ? "[m/s]" : "/ b<sub>c</sub> ω<sub>c</sub>"}`,
  );
  const half = file.laws[mesh]?.half || 0;
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
    if (half > low && -half < high) {
      made.annotations = [
        {
          x: 0.98,
          y: 0.98,
          xref: "paper",
          yref: "paper",
          xanchor: "right",
          yanchor: "top",
          text: "grey: gap",
          showarrow: false,
          font: { size: 11 },
        },
      ];
    }
  }
  // By the phase of the fundamental; over time it is Lambda times that, over 1/characteristic frequency.
  const omega = 2 * Math.PI * file.perLambda.Hz;
  const factor = lambda * (file.lengthUnit === "um" ? 1e-3 * omega : file.lengthUnit ? omega : 1);
  Plotly.react(
    "plane",
    wave
      ? [
          {
            type: "scatter",
            mode: "lines",
            x: Array.from(wave.p),
            y: Array.from(wave.v, (v) => v * factor),
            line: { color: COLORS[mesh % COLORS.length], width: highest * period > 100 ? 0.6 : 1.6 },
            hovertemplate: "%{x:.4g}, %{y:.4g}<extra></extra>",
          },
        ]
      : [],
    made,
    STILL,
  );
}

function drawMultipliers({ series, point }) {
  const note = byId("multipliers-note"),
    all = series.multipliers;
  const values = all
    ? range(all.shape[1])
        .map((i) => [0, 1].map((part) => all[(point * all.shape[1] + i) * 2 + part]))
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
