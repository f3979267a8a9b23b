// The view of response curves.

function responseView(panel) {
  const has = (name) => main.series.some((series) => series.values[name]);
  // What it opens with comes first; of a train with a drawing the rms of the paper, which no standard knows, comes last.
  const rank = (name) => (name === main.first ? -1 : name === "rms" ? 1 : 0);
  const names = Object.keys(data.quantities)
    .filter(has)
    .sort((one, other) => rank(one) - rank(other));
  if (!has(state.quantity)) state.quantity = names[0];
  const [quantityLabel] = choice(
    "quantity",
    names.map((name) => [name, quantityWords(name)]),
    state.quantity,
    (name) => {
      const along = data.quantities[state.quantity].along;
      state.quantity = name;
      if (data.quantities[name].along !== along) state.part = "all";
      fillParts();
      draw(true);
    },
  );
  const [partLabel, parts] = choice("of", [], "all", (part) => {
    state.part = part;
    if (part !== "all" && data.quantities[state.quantity].along === "mesh") state.mesh = Number(part);
    draw(true);
  });
  function fillParts() {
    const along = data.quantities[state.quantity].along;
    parts.replaceChildren(
      make("option", { value: "all" }, `all ${data.along[along]}`),
      ...partsOf(main).map((name, place) => make("option", { value: place }, name)),
    );
    parts.value = state.part;
  }
  fillParts();
  const there = new Set(files.flatMap((file) => file.series.map((series) => series.kind)));
  const switches = [
    ...Object.entries(KINDS).filter(([kind]) => there.has(kind)),
    ...(main.series.some((s) => s.kind === "response" && s.jumps.length) ? [["jumps", "jumps"]] : []),
    ...(main.series.some((s) => s.specials.length) ? [["specials", "special points"]] : []),
    ...(main.series.some((s) => s.ranges.length || s.bands.length) ? [["ranges", "ranges"]] : []),
    ...(files.length > 1 ? [["compare", `compared: ${files[1].name || files[1].title || "second file"}`]] : []),
  ];
  const boxes = switches.map(([what, words]) => {
    const box = make("input", {
      type: "checkbox",
      id: `show-${what}`,
      checked: true,
      onchange: () => {
        state.off[box.checked ? "delete" : "add"](what);
        draw(true);
      },
    });
    return make("label", {}, box, words);
  });
  const plot = make("div", {
    id: "curve",
    class: "plot",
    tabindex: 0,
    role: "application",
    "aria-describedby": "keys",
    "aria-label": "Response curves. Arrow keys left and right go along the branch, up and down to the next one.",
  });
  const key = make("ul", { class: "key", id: "key", "aria-label": "Key" });
  const [facts, histories, planes] = pointPanels();
  const curves = make(
    "div",
    { class: "curves" },
    key,
    plot,
    make("p", { class: "note", id: "beyond", hidden: true }),
    make(
      "p",
      { class: "note", id: "keys" },
      "Click a point, or give the picture the focus: left and right arrow go along the " +
        "branch (with Shift by ten points), Home and End to its ends, up and down to the next branch.",
    ),
  );
  panel.append(
    make("div", { class: "controls" }, unitChoice("response"), quantityLabel, partLabel),
    make("div", { class: "controls" }, make("fieldset", {}, make("legend", {}, "show"), ...boxes)),
    make(
      "div",
      { class: "columns" },
      make("div", { class: "column" }, curves, histories),
      make("div", { class: "column" }, facts, planes),
    ),
  );
  plot.addEventListener("keydown", moveKeys);
  let drawn = false;
  function draw(again) {
    if (drawn && !again && drawn === state.unit) {
      Plotly.Plots.resize(plot);
      return;
    }
    drawn = state.unit;
    drawCurves(plot, key);
    const first = main.series.find((series) => series.count);
    if (!state.chosen && first) choose(first, ...largest(first));
    else drawPoint();
  }
  return draw;
}

/** The point and the column of the largest value of a stable motion that repeats after one period, with which the page begins. */
function largest(series) {
  const values = series.values[state.quantity] || series.values.rms,
    width = values.shape[1];
  let best = -1;
  for (const settled of [true, false]) {
    for (let i = 0; i < values.length; i++) {
      const counts = !settled || isSettled(series, Math.floor(i / width));
      if (counts && Number.isFinite(values[i]) && (best < 0 || values[i] > values[best])) best = i;
    }
    if (best >= 0) break;
  }
  best = Math.max(best, 0);
  return [Math.floor(best / width), best % width];
}

/** Whether a motion is stable and repeats after one period of the fundamental, or has settled without one. */
function isSettled(series, point) {
  if (!isBranch(series) && series.kinds[point] === "stationary") return true;
  return series.period[point] === 1 && (!series.stable || series.stable[point] !== 0);
}

/** Pieces of one stability, each up to the first point of the next piece of the same segment. */
function pieces(series) {
  const found = [];
  let first = 0;
  for (let i = 1; i <= series.count; i++) {
    const torn = i === series.count || (series.segment && series.segment[i] !== series.segment[i - 1]);
    if (torn || (series.stable && series.stable[i] !== series.stable[i - 1])) {
      found.push([first, torn ? i : i + 1, !series.stable || series.stable[first] === 1]);
      first = i;
    }
  }
  return found;
}

const code = (series, point) => series.place * 1e7 + point;
const decode = (file, number) => [files[file].series[Math.floor(number / 1e7)], number % 1e7];

/** Places at which a step of a branch is drawn. */
const PLACES = 8;

/** A column of values with places between the points `from` to `to`, on cubics along the branch; each with the nearest point. */
function between(series, values, width, column, from, to) {
  const { along } = series,
    at = (i) => values[i * width + column],
    chosen = state.quantity === "rms" ? 1 : state.quantity === "true_ac_rms" ? Math.SQRT1_2 : 0,
    known = chosen && series.rmsSlope ? (i) => chosen * series.rmsSlope[i * width + column] : null;
  const found = [];
  for (let i = from; i < to; i++) {
    found.push({ point: i, across: series.across[i], value: at(i) });
    const length = along && i + 1 < to ? along[i + 1] - along[i] : 0;
    if (!(length > 0)) continue;
    const ends = known ? [known(i), known(i + 1)] : [slopeAt(along, at, i, from, to), slopeAt(along, at, i + 1, from, to)];
    for (let place = 1; place < PLACES; place++) {
      const t = place / PLACES,
        cubic = (a, b, slopeA, slopeB) =>
          (1 - t) ** 2 * ((1 + 2 * t) * a + t * length * slopeA) + t ** 2 * ((3 - 2 * t) * b - (1 - t) * length * slopeB);
      found.push({
        point: i + Math.round(t),
        across: cubic(series.across[i], series.across[i + 1], series.acrossSlope[i], series.acrossSlope[i + 1]),
        value: cubic(at(i), at(i + 1), ...ends),
      });
    }
  }
  return found;
}

/** Derivative at a point of a cubic that rises and falls with the values (F. N. Fritsch, J. Butland, 1984), as in _curve.py. */
function slopeAt(along, at, i, from, to) {
  const chord = (k) => (at(k + 1) - at(k)) / (along[k + 1] - along[k]);
  if (i === from || i === to - 1) return chord(i === from ? i : i - 1);
  const [before, after] = [chord(i - 1), chord(i)],
    [first, last] = [along[i] - along[i - 1], along[i + 1] - along[i]];
  if (!(before * after > 0)) return 0;
  return (3 * (first + last)) / ((first + 2 * last) / before + (2 * first + last) / after);
}

function curveTraces() {
  const traces = [];
  for (const number of files.length > 1 && isOn("compare") ? [1, 0] : [0]) {
    const file = files[number],
      pale = number === 1;
    for (const kind of Object.keys(KINDS)) {
      const members = file.series.filter((series) => series.kind === kind && isOn(kind) && series.values[state.quantity]);
      if (!members.length) continue;
      for (const column of columnsShown(file)) {
        const color = COLORS[column % COLORS.length],
          name = safe(partsOf(file)[column]);
        const told = `${pale ? `${safe(file.name || file.title)}, ` : ""}${name}`;
        if (isBranch(members[0])) {
          for (const stable of [true, false]) {
            const x = [],
              y = [],
              own = [];
            for (const series of members) {
              const values = series.values[state.quantity],
                width = values.shape[1];
              for (const [from, to, verdict] of pieces(series)) {
                if (verdict !== stable) continue;
                for (const { point, across, value } of between(series, values, width, column, from, to)) {
                  x.push(across * acrossFactor(file));
                  y.push(value);
                  own.push(code(series, point));
                }
                x.push(null);
                y.push(null);
                own.push(null);
              }
            }
            if (!x.length) continue;
            const words = members[0].stable ? (stable ? "stable" : "unstable") : "";
            traces.push({
              type: "scatter",
              mode: "lines",
              x,
              y,
              customdata: own,
              yaxis: axisOf(column),
              meta: { file: number, column, kind, stable },
              line: { color, dash: stable ? "solid" : UNSTABLE, width: (kind === "response" ? 2.2 : 1.3) + (pale ? 5 : 0) },
              opacity: pale ? 0.3 : 1,
              connectgaps: false,
              hovertemplate:
                `${told}, ${KINDS[kind]}${words && `, ${words}`}<br>` + `%{x:.6g}${acrossSuffix()}: %{y:.5g}<extra></extra>`,
            });
          }
        } else {
          for (const series of members) {
            const values = series.values[state.quantity],
              width = values.shape[1],
              ways = series.directions;
            traces.push({
              type: "scatter",
              mode: "markers",
              x: Array.from(series.across, (l) => l * acrossFactor(file)),
              y: range(series.count).map((i) => values[i * width + column]),
              customdata: range(series.count).map((i) => code(series, i)),
              yaxis: axisOf(column),
              meta: { file: number, column, kind, stable: true },
              opacity: pale ? 0.4 : 1,
              marker: {
                color,
                size: kind === "attractors" ? 10 : 7,
                line: { color, width: 1.2 },
                symbol:
                  kind === "attractors"
                    ? "star"
                    : range(series.count).map((i) => (ways[i] === "down" ? "triangle-down-open" : "triangle-up")),
              },
              hovertemplate: `${told}, ${KINDS[kind]}<br>%{x:.6g}${acrossSuffix()}: %{y:.5g}<extra></extra>`,
            });
          }
        }
      }
    }
  }
  if (isOn("specials")) traces.push(...specialTraces());
  return traces;
}

/** Marks of special points on the curves. */
function specialTraces() {
  const marks = {};
  for (const series of main.series.filter((s) => isOn(s.kind) && s.values[state.quantity])) {
    for (const special of series.specials) {
      for (const column of columnsShown(main)) {
        const name = `${special.kind} ${axisOf(column)}`,
          mark = (marks[name] ??= { kind: special.kind, axis: axisOf(column), x: [], y: [], own: [] });
        mark.x.push(special.at * acrossFactor(main));
        mark.y.push(special.values[state.quantity]?.[column] ?? valueAt(series, state.quantity, special.point, column));
        mark.own.push(code(series, special.point));
      }
    }
  }
  return Object.values(marks).map(({ kind, axis, x, y, own }) => ({
    type: "scatter",
    mode: "markers",
    x,
    y,
    yaxis: axis,
    customdata: own,
    meta: { file: 0, column: null, kind: "specials" },
    marker: { symbol: SPECIALS[kind] || "star", size: 8, color: "#fff", line: { color: INK, width: 1.6 } },
    hovertemplate: `${SPECIAL_WORDS[kind] || kind}<br>%{x:.6g}${acrossSuffix()}: %{y:.5g}<extra></extra>`,
  }));
}

/** The axis of a column: of unequal parts each has a panel of its own. */
const axisOf = (column) => state.axes[column] || "y";

/** Of a column smallest and largest value of the motions that the picture is scaled to; of all motions where none is such. */
function spanOfColumn(column, every = false) {
  const values = [];
  for (const series of shown()) {
    const all = series.values[state.quantity];
    if (!all || column >= all.shape[1]) continue;
    for (let i = 0; i < series.count; i++) if (every || isSettled(series, i)) values.push(all[i * all.shape[1] + column]);
  }
  return spanOf(values) || (every ? null : spanOfColumn(column, true));
}

/** The panels of the picture, with the range of each: scaled to the stable motions that repeat after one period. */
function curvePanels(top) {
  const columns = columnsShown(main),
    { along, unit } = data.quantities[state.quantity],
    spans = columns.map((column) => spanOfColumn(column)),
    isShare = unit === "1" && !LENGTHS.has(state.quantity),
    split = !isShare && areUnequal(spans, along !== "mesh"),
    groups = split ? columns.map((column) => [column]) : [columns],
    fromZero = along === "mesh" && !POSITIONS.has(state.quantity);
  const panels = panelsBelow(groups.length, top).map((panel, place) => {
    const span = spanOf(groups[place].flatMap((column) => spans[columns.indexOf(column)] || []));
    return { ...panel, columns: groups[place], range: span && rangeFor(span, fromZero) };
  });
  state.axes = [];
  for (const { axis, columns: own } of panels) for (const column of own) state.axes[column] = axis;
  return panels;
}

/** What lies beyond the scale, where it is not nothing. */
function tellBeyond(panels) {
  let stable = null,
    unstable = false;
  for (const { columns, range: ends } of panels) {
    for (const series of ends ? shown() : []) {
      const all = series.values[state.quantity];
      for (const column of all ? columns.filter((own) => own < all.shape[1]) : []) {
        for (let i = 0; i < series.count; i++) {
          const value = all[i * all.shape[1] + column];
          if (!(value > ends[1] || value < ends[0])) continue;
          if (series.stable && series.stable[i] === 0) unstable = true;
          else if (!stable || Math.abs(value) > Math.abs(stable.value)) stable = { value, series, point: i };
        }
      }
    }
  }
  const told = [];
  if (stable) {
    const { value, series, point } = stable,
      period = series.period[point],
      at = show(series.across[point] * acrossFactor(files[series.file]), 4) + acrossSuffix();
    const which = period > 1 ? `a motion that repeats after ${period} periods` : "a motion";
    told.push(`Beyond the scale: ${which}, ${show(value, 4)} at ${state.unit === "Lambda" && !main.over ? "Λ = " : ""}${at}`);
  }
  if (unstable) told.push(stable ? "and unstable motions" : "Beyond the scale: unstable motions");
  byId("beyond").textContent = told.length ? `${told.join(", ")}. A double click on the picture shows all.` : "";
  byId("beyond").hidden = !told.length;
}

/** Strips above the curves, a row for each mesh: light where the teeth separate, dark where the back flanks collide. */
function rangeTraces(rows) {
  const traces = [];
  for (const what of ["apart", "back"]) {
    for (const mesh of rows) {
      const x = [],
        y = [];
      let words = "";
      for (const series of main.series.filter((s) => s.kind === "response")) {
        for (const [own, kind, low, high, told] of series.ranges) {
          if (own !== mesh || kind !== what) continue;
          words = told;
          x.push(low * acrossFactor(main), high * acrossFactor(main), null);
          y.push(rows.indexOf(mesh), rows.indexOf(mesh), null);
        }
      }
      if (x.length) {
        traces.push({
          type: "scatter",
          mode: "lines",
          x,
          y,
          yaxis: "y2",
          meta: { kind: "ranges" },
          opacity: what === "apart" ? 0.4 : 1,
          line: { color: COLORS[mesh % COLORS.length], width: 9 },
          hovertemplate: `${safe(main.parts.mesh[mesh])}: ${words}, to %{x:.6g}${acrossSuffix()}<extra></extra>`,
        });
      }
    }
  }
  return traces;
}

function drawCurves(plot, key) {
  const rows =
    !isOn("ranges") || !isOn("response")
      ? []
      : range(main.parts.mesh.length).filter((mesh) =>
          main.series.some((s) => s.kind === "response" && s.ranges.some((row) => row[0] === mesh)),
        );
  const top = 1 - Math.min(0.35, 0.035 * rows.length + (rows.length ? 0.02 : 0));
  const panels = curvePanels(top);
  const traces = [...curveTraces(), ...rangeTraces(rows)];
  const shapes = selectionShapes();
  const annotations = [];
  if (isOn("ranges") && isOn("response")) {
    for (const series of main.series.filter((s) => s.kind === "response")) {
      for (const [low, high] of series.bands) {
        shapes.push({
          type: "rect",
          xref: "x",
          yref: "paper",
          x0: low * acrossFactor(main),
          x1: high * acrossFactor(main),
          y0: 0,
          y1: top,
          fillcolor: "#999",
          opacity: 0.15,
          line: { width: 0 },
          layer: "below",
        });
      }
    }
  }
  if (isOn("jumps")) {
    for (const series of main.series.filter((s) => s.kind === "response" && isOn(s.kind))) {
      for (const jump of series.jumps) {
        const x = jump.at * acrossFactor(main),
          before = jump.before[state.quantity],
          after = jump.after[state.quantity];
        let drawn = 0;
        for (const column of before && after ? columnsShown(main) : []) {
          if (after[column] == null) continue;
          drawn++;
          annotations.push({
            x,
            y: after[column],
            ax: x,
            ay: before[column],
            axref: "x",
            ayref: axisOf(column),
            xref: "x",
            yref: axisOf(column),
            showarrow: true,
            arrowhead: 2,
            arrowsize: 1,
            arrowwidth: 1.3,
            arrowcolor: "#4a525c",
            text: "",
          });
        }
        if (!drawn) {
          shapes.push({
            type: "line",
            xref: "x",
            yref: "paper",
            x0: x,
            x1: x,
            y0: 0,
            y1: top,
            line: { color: "#4a525c", width: 1, dash: "dot" },
          });
        }
      }
    }
  }
  const layout = {
    ...baseLayout(acrossTitle(), quantityTitle(state.quantity)),
    margin: { l: 68, r: 14, t: 32, b: 48 },
    shapes,
    annotations,
    hovermode: "closest",
    dragmode: "zoom",
    uirevision: `${state.unit} ${state.quantity}`,
    hoverdistance: 30,
  };
  if (main.over && Math.max(...main.series.flatMap((s) => spanOf(s.across) || [0]).map(Math.abs)) < 1e-3)
    layout.xaxis.exponentformat = "power";
  putPanels(plot, layout, panels, partsOf(main), quantityTitle(state.quantity));
  if (rows.length) {
    layout.yaxis2 = {
      domain: [top + 0.015, 1],
      range: [-0.6, rows.length - 0.4],
      tickvals: range(rows.length),
      fixedrange: true,
      ticktext: rows.map((mesh) => main.elements[mesh]),
      showgrid: false,
      zeroline: false,
      tickfont: { size: 11 },
    };
  }
  drawPanels(plot, traces, layout);
  tellBeyond(panels);
  if (!plot.hasClick) {
    plot.hasClick = true;
    plot.on("plotly_click", (event) => {
      const { customdata, data: trace } = event.points[0];
      if (customdata == null || trace.meta?.kind === "ranges") return;
      const [series, point] = decode(trace.meta.file, customdata);
      choose(series, point, trace.meta.column ?? state.mesh);
      plot.focus({ preventScroll: true });
    });
  }
  drawKey(key, traces);
}

/** Gives a layout an axis for each panel; of several each has its name, and beside it the unit alone. */
function putPanels(plot, layout, panels, names, title) {
  const several = panels.length > 1,
    words = several ? title.slice(title.lastIndexOf("  ")).trim() : title;
  plot.style.height = several ? `${Math.max(520, 90 + 140 * panels.length)}px` : plot.dataset.height || "";
  const { title: one, ...axis } = layout.yaxis;
  panels.forEach((panel) => {
    const own = { ...axis, domain: panel.domain, title: { ...one, text: words, standoff: 8 } };
    if (several) own.nticks = 5;
    if (panel.range) own.range = panel.range;
    layout[layoutName(panel.axis)] = own;
    if (several) (layout.annotations ??= []).push(panelName(names[panel.columns[0]], panel.axis));
  });
}

/** Draws panels; plotly does not see by itself that their number has changed the height of the picture. */
function drawPanels(plot, traces, layout) {
  Plotly.react(plot, traces, layout, config());
  if (plot.dataset.tall !== plot.style.height) Plotly.Plots.resize(plot);
  plot.dataset.tall = plot.style.height;
}

function baseLayout(x, y) {
  const axis = (text) => ({
    title: { text, font: { size: 14 } },
    gridcolor: "#e6e9ed",
    zeroline: false,
    linecolor: "#5b636d",
    showline: true,
    ticks: "outside",
    ticklen: 4,
    tickcolor: "#5b636d",
    automargin: true,
    exponentformat: "none",
  });
  return {
    separators: ".\u202f",
    xaxis: axis(x),
    yaxis: axis(y),
    showlegend: false,
    paper_bgcolor: "#fff",
    plot_bgcolor: "#fff",
    font: { color: INK, size: 12.5, family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif' },
  };
}

/** What lines and marks mean, below the controls. */
function drawKey(key, traces) {
  const kinds = new Set(traces.map((trace) => trace.meta?.kind)),
    items = [];
  const line = (color, dash = "", width = 2.2, opacity = 1) =>
    `<path d="M1 7H27" stroke="${color}" stroke-width="${width}" stroke-dasharray="${dash}" opacity="${opacity}"/>`;
  const mark = (path, fill = "#fff") => `<path d="${path}" fill="${fill}" stroke="${INK}" stroke-width="1.4"/>`;
  for (const column of columnsShown(main)) items.push([line(COLORS[column % COLORS.length]), partsOf(main)[column]]);
  if (traces.some((trace) => trace.meta?.stable === false)) items.push([line("#4a525c", "5,3"), "unstable"]);
  if (["cascade", "branch", "island"].some((kind) => kinds.has(kind)))
    items.push([line("#4a525c", "", 1.2), "further branches"]);
  if (kinds.has("integration")) {
    items.push([mark("M9 12L14 3L19 12Z", "#4a525c"), "integration, rising speed"]);
    if (files.some((file) => file.series.some((s) => s.directions?.includes("down")))) {
      items.push([mark("M9 3L14 12L19 3Z"), "integration, falling speed"]);
    }
  }
  if (kinds.has("attractors"))
    items.push([mark("M14 1l2 4 4 .5-3 3 .8 4.3-3.8-2-3.8 2 .8-4.3-3-3 4-.5z", "#4a525c"), "attractors"]);
  if (isOn("jumps") && main.series.some((s) => s.kind === "response" && isOn(s.kind) && s.jumps.length)) {
    items.push([mark("M14 12V4M11 6.5L14 3L17 6.5", "none"), "jump (dotted: it switches to another vibration)"]);
  }
  const circle = `<circle cx="14" cy="7" r="4" fill="#fff" stroke="${INK}" stroke-width="1.4"/>`;
  const signs = {
    fold: circle,
    "period doubling": mark("M14 2L19 7L14 12L9 7Z"),
    "neimark-sacker": mark("M10 3H18V11H10Z"),
    "branch point": mark("M10 3L18 11M18 3L10 11", "none"),
    "stability change": mark("M14 1l2 4 4 .5-3 3 .8 4.3-3.8-2-3.8 2 .8-4.3-3-3 4-.5z"),
  };
  for (const kind of kinds.has("specials") ? Object.keys(SPECIALS) : []) {
    if (main.series.some((s) => isOn(s.kind) && s.specials.some((special) => special.kind === kind)))
      items.push([signs[kind], SPECIAL_WORDS[kind]]);
  }
  if (kinds.has("ranges")) {
    const words = main.series.some((s) => s.ofStable) ? " (stable motions)" : "";
    const rows = main.series.flatMap((s) => s.ranges);
    for (const [what, opacity] of [["apart", 0.4], ["back", 1]]) {
      const told = [...new Set(rows.filter((row) => row[1] === what).map((row) => row[4]))];
      if (told.length) items.push([line("#4a525c", "", 8, opacity), told.join(", ") + words]);
    }
  }
  if (isOn("ranges") && main.series.some((s) => s.kind === "response" && s.bands.length)) {
    items.push(['<rect x="1" y="1" width="26" height="12" fill="#999" opacity=".3"/>', "no stable motion here that repeats after one period"]);
  }
  if (files.length > 1 && isOn("compare"))
    items.push([line("#4a525c", "", 7, 0.3), `compared: ${files[1].name || files[1].title}`]);
  key.replaceChildren(
    ...items.map(([drawing, words]) => {
      const item = make("li");
      item.innerHTML = `<svg width="28" height="14" aria-hidden="true">${drawing}</svg>`;
      item.append(words);
      return item;
    }),
  );
}
