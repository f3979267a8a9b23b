// The motion that is chosen: where it is on the curves, its facts and its pictures.

/** A line at the chosen speed, and a ring at each of its values; always as many, so that they can be moved alone. */
function selectionShapes() {
  const file = state.chosen ? files[state.chosen.series.file] : main;
  const rings = Math.max(...files.map((other) => columnsShown(other).length));
  const x = state.chosen ? state.chosen.series.across[state.chosen.point] * acrossFactor(file) : 0;
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
      yref: column === undefined ? "y" : axisOf(column),
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
    const at = series.across[point] * acrossFactor(files[series.file]),
      factor = acrossFactor(files[other.file]);
    let best = 0;
    for (let i = 1; i < other.count; i++) {
      if (Math.abs(other.across[i] * factor - at) < Math.abs(other.across[best] * factor - at)) best = i;
    }
    choose(other, best);
  }
}

function setMesh(mesh) {
  state.mesh = mesh;
  const select = byId("plane-mesh");
  if (select) select.value = String(mesh);
}

/** What the page has of the chosen motion, below one another on a narrow screen: its facts; time histories; the other pictures. */
function pointPanels() {
  const [meshLabel, select] = choice(
    "phase plane of",
    main.parts.mesh.map((name, place) => [String(place), name]),
    "0",
    (mesh) => {
      state.mesh = Number(mesh);
      drawPoint();
    },
  );
  select.id = "plane-mesh";
  const [ofLabel, ofSelect] = choice(
    "spectrum of",
    [
      ["p", "displacement"],
      ["force", "force"],
    ],
    "p",
    (what) => {
      state.spectrum = what;
      drawPoint();
    },
  );
  ofSelect.id = "spectrum-of";
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
      { "aria-label": "Time histories of the chosen motion", class: "histories" },
      small("wave", "Displacement of the meshes over time"),
      small("force", "Force of the meshes over time"),
      make("p", { class: "note", id: "force-note", hidden: true }),
    ),
    make(
      "section",
      { class: "planes", "aria-label": "Phase plane, spectrum and multipliers of the chosen motion" },
      make(
        "div",
        { class: "pair" },
        make("div", {}, small("spectrum", "Spectrum of the displacement or the force")),
        make("div", {}, small("plane", "Phase plane: velocity over displacement")),
      ),
      make("div", { class: "controls" }, ofLabel, meshLabel, make("span", { class: "note", id: "gap", hidden: true })),
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
  if (series.stable[point] === 2) return "stability not known";
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
  if (file.perLambda.rpm) speeds.push(`${show(lambda * file.perLambda.rpm, 5)} rpm of ${file.speedOf}`);
  if (file.perLambda.Hz) speeds.push(`${show(lambda * file.perLambda.Hz, 5)} Hz`);
  if (file.over) facts.push([file.over.replace(/_/g, " "), show(series.across[point], 7) + acrossSuffix()]);
  if (!(file.perLambda.rpm && Math.abs(file.perLambda.rpm - 1) < 1e-9)) speeds.unshift(`Λ = ${show(lambda, 7)}`);
  facts.push([
    "motion",
    `${files.length > 1 ? `${file.name || file.title}, ` : ""}${series.name}, point ${point + 1} of ${series.count}` +
      (series.directions?.[point] ? `, ${series.directions[point] === "up" ? "rising" : "falling"} speed` : ""),
  ]);
  facts.push(["speed", speeds.join(", ")]);
  facts.push(["verdict", verdict(series, point)]);
  const repeats = series.period[point] === 1 ? "one period" : `${series.period[point]} periods`,
    span = series.window?.[point] > 0 ? `not found; the figures are those of ${duration(file, lambda, series.window[point])}` : "not found";
  facts.push(["repeats", series.period[point] ? `after ${repeats} of the fundamental` : span]);
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
    "mesh_force_maximum",
    "dynamic_factor",
    "mean",
    "minimum",
    "maximum",
    "peak_to_peak",
    file.drawn ? "true_ac_rms" : "rms",
    "separation_fraction",
    "back_contact_fraction",
  ].filter((name) => series.values[name]);
  // The unit stands once in the heading, so that three columns have room on a telephone.
  const heading = (name) => {
    const unit = LENGTHS.has(name) ? lengthText(file) : { N: "N" }[data.quantities[name].unit];
    const words = { rms: "rms of the paper", dynamic_factor: "dynamic factor" }[name] || quantityWords(name);
    return words.replace("mesh displacement, ", "displacement, ") + (unit ? `, ${unit}` : "");
  };
  const head = make(
    "tr",
    {},
    make("th", { scope: "col" }, ""),
    ...file.parts.mesh.map((name) => make("th", { scope: "col" }, name)),
  );
  const body = names.map((name) =>
    make(
      "tr",
      {},
      make("th", { scope: "row" }, heading(name)),
      ...file.parts.mesh.map((_, mesh) => {
        const value = valueAt(series, name, point, mesh);
        return make("td", {}, Number.isFinite(value) ? show(value, 4) : "");
      }),
    ),
  );
  const others = Object.keys(file.parts).filter((along) => along !== "mesh");
  const tables = others.map((along) => partTable(file, series, point, along)).filter((table) => table);
  byId("facts").replaceChildren(
    list,
    make("div", { class: "scroll" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))),
    ...tables.map((table) => make("div", { class: "scroll" }, table)),
  );
}

/** A number of periods of the fundamental, in seconds where they are known. */
function duration(file, lambda, periods) {
  const seconds = file.perLambda.Hz ? periods / (file.perLambda.Hz * lambda) : 0;
  return seconds ? (seconds < 1 ? `${show(1e3 * seconds, 3)} ms` : `${show(seconds, 3)} s`) : `${show(periods, 3)} periods`;
}

/** What the chosen motion has of all shafts, held bodies or planets, a row for each; null where that is nothing. */
function partTable(file, series, point, along) {
  const names = Object.keys(data.quantities).filter((name) => data.quantities[name].along === along && series.values[name]);
  if (!names.length || !file.parts[along].length) return null;
  const words = (name) => `${quantityWords(name)}${data.quantities[name].unit === "1" ? "" : `, ${data.quantities[name].unit}`}`;
  const head = make("tr", {}, ...["", ...names.map(words)].map((text) => make("th", { scope: "col" }, text)));
  const rows = file.parts[along].map((label, column) =>
    make(
      "tr",
      {},
      make("th", { scope: "row" }, label),
      ...names.map((name) => {
        const value = valueAt(series, name, point, column);
        return make("td", {}, Number.isFinite(value) ? show(value, 4) : "");
      }),
    ),
  );
  return make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows));
}
