// The other views: tables, stability map, run-up, train.

function tablesView(panel) {
  panel.append(
    make("p", { class: "note" }, "A click on a heading sorts, a second one the other way. ‘show’ goes to the motion."),
  );
  files.forEach((file, number) => {
    if (files.length > 1) panel.append(make("h2", {}, file.name || file.title || `file ${number + 1}`));
    for (const table of file.tables.filter((one) => !one.branch)) panel.append(sortable(table, number));
    for (const branch of new Set(file.tables.map((one) => one.branch).filter(Boolean))) {
      const own = file.tables.filter((one) => one.branch === branch);
      panel.append(make("details", {}, make("summary", {}, branch), ...own.map((table) => sortable(table, number))));
    }
  });
  return null;
}

function sortable(table, number) {
  const rows = table.rows.map((cells, place) => ({ cells, place }));
  const body = make("tbody");
  const heads = table.headings.map((heading, column) =>
    make("th", { scope: "col" }, make("button", { type: "button", onclick: () => sort(column) }, heading)),
  );
  function fill() {
    body.replaceChildren(
      ...rows.map(({ cells, place }) =>
        make(
          "tr",
          {},
          table.points.length
            ? make(
                "td",
                {},
                make(
                  "button",
                  {
                    type: "button",
                    "aria-label": `show row ${place + 1} of ${table.name}`,
                    onclick: () => {
                      const [series, point] = table.points[place];
                      openTab("response");
                      choose(files[number].series[series], point);
                      byId("curve").focus();
                    },
                  },
                  "show",
                ),
              )
            : null,
          ...cells.map((cell) => make("td", {}, words(cell))),
        ),
      ),
    );
  }
  function sort(column) {
    const down = heads[column].getAttribute("aria-sort") === "ascending",
      sign = down ? -1 : 1;
    heads.forEach((head) => head.removeAttribute("aria-sort"));
    heads[column].setAttribute("aria-sort", down ? "descending" : "ascending");
    const order = (a, b) =>
      a == null
        ? 1
        : b == null
          ? -1
          : sign * (typeof a === "string" || typeof b === "string" ? String(a).localeCompare(String(b)) : a - b) || 0;
    rows.sort((one, other) => order(one.cells[column], other.cells[column]) || one.place - other.place);
    fill();
  }
  const words = (cell) =>
    cell === true ? "yes" : cell === false ? "no" : typeof cell === "number" ? show(cell, 5) : (cell ?? "");
  fill();
  return make(
    "div",
    { class: "scroll" },
    make(
      "table",
      {},
      make("caption", {}, table.name),
      make("thead", {}, make("tr", {}, table.points.length ? make("td", {}, "") : null, ...heads)),
      body,
    ),
  );
}

// ------------------------------------------------------------------------------------------------- map, run-up, train

const PARAMETERS = { stiffness_variation: "stiffness variation  κ", mesh_damping_ratio: "mesh damping ratio  ζ" };

/** Short names of a map, and the same parameters by the names of a locus. */
const OF_EVERY_MESH = { mesh_damping_ratio: "mesh * damping_ratio", half_backlash: "mesh * half_backlash" };

/** The stability map, and curves of special points: over it where they are over its parameter, else on their own. */
function mapView(panel) {
  const chart = main.map,
    plot = make("div", { id: "chart", class: "plot", role: "img", "aria-label": "Stability over speed and a parameter" });
  plot.style.height = "560px";
  const shows = chart
    ? [
        ["spectral_radius", "largest |multiplier|"],
        ["stable_motions", "stable motions"],
        ["motions", "motions"],
      ]
    : [];
  const over = chart && (OF_EVERY_MESH[chart.parameter] || chart.parameter);
  const apart = [...new Set(main.loci.map((locus) => locus.parameter))].filter((name) => name !== over);
  shows.push(...apart.map((name) => [name, `curves over ${name.replace(/_/g, " ")}`]));
  if (!shows.some(([what]) => what === state.mapWhat)) state.mapWhat = shows[0][0];
  const [what] = choice("show", shows, state.mapWhat, (value) => {
    state.mapWhat = value;
    draw();
  });
  const notes = main.loci.map((locus) => `Thick line: ${locus.kind}; it ended by ${locus.ended}.`);
  if (chart) notes.unshift(`${chart.words[0].toUpperCase()}${chart.words.slice(1)}.`);
  if (chart) notes.unshift(`${chart.linear ? "Of the train without backlash. " : ""}${chart.ended}.`);
  panel.append(
    make("div", { class: "controls" }, unitChoice("map"), what),
    plot,
    make("p", { class: "note", id: "cell", "aria-live": "polite" }, chart ? "Click a cell: its numbers stand here." : ""),
    ...notes.map((note) => make("p", { class: "note" }, note)),
  );
  function draw() {
    const own = chart && !apart.includes(state.mapWhat),
      parameter = own ? chart.parameter : state.mapWhat;
    const loci = main.loci.filter((locus) => locus.parameter === (own ? over : parameter));
    const unit = own && chart.unit && chart.unit !== "1" ? `  [${chart.unit}]` : "";
    const title = (PARAMETERS[parameter] || safe(parameter.replace(/_/g, " "))) + unit;
    const layout = {
      ...baseLayout(frequencyTitle(), title),
      margin: { l: 68, r: 10, t: 36, b: 48 },
      hovermode: "closest",
      uirevision: `${state.unit} ${parameter}`,
    };
    Plotly.react(plot, [...(own ? mapTraces(chart) : []), ...loci.flatMap(locusTraces)], layout, config());
    if (plot.hasClick) return;
    plot.hasClick = true;
    plot.on("plotly_click", (event) => tellCell(chart, event.points[0]));
  }
  return draw;
}

/** A map in colours, with the boundary of stability. */
function mapTraces(chart) {
  const rows = chart.values.length,
    columns = chart.lambda.length,
    values = chart[state.mapWhat];
  const x = Array.from(chart.lambda, (l) => l * per(main)),
    y = Array.from(chart.values);
  const z = range(rows).map((row) =>
    range(columns).map((column) => {
      const value = values[row * columns + column];
      return Number.isFinite(value) && value >= 0 ? value : null;
    }),
  );
  const radius = state.mapWhat === "spectral_radius",
    found = z.flat().filter((v) => v != null),
    most = Math.max(1, ...found),
    // White is 1. Where all multipliers are near 1, fewer colours would leave a white picture.
    half = Math.min(0.5, Math.max(...found.map((v) => Math.abs(v - 1)))) || 0.5;
  const colors = ["#440154", "#31688e", "#35b779", "#fde725", "#ffffff", "#bbbbbb"];
  const steps = range(most + 1).flatMap((k) => [k, k + 1].map((edge) => [edge / (most + 1), colors[Math.min(k, 5)]]));
  const traces = [
    {
      type: "heatmap",
      x,
      y,
      z,
      hoverongaps: false,
      ...(radius ? { colorscale: AROUND_ONE, zmin: 1 - half, zmax: 1 + half } : { colorscale: steps, zmin: -0.5, zmax: most + 0.5 }),
      colorbar: {
        title: { text: radius ? "largest |multiplier|" : state.mapWhat.replace("_", " "), side: "right" },
        thickness: 14,
        ...(radius ? {} : { tickvals: range(most + 1) }),
      },
      hovertemplate: `%{x:.6g}${unitSuffix()}, %{y:.5g}: %{z:.4g}<extra></extra>`,
    },
  ];
  if (radius && rows > 1 && columns > 1) {
    traces.push({
      type: "contour",
      x,
      y,
      z,
      contours: { start: 1, end: 1, size: 1, coloring: "none" },
      line: { color: INK, width: 1.4 },
      showscale: false,
      hoverinfo: "skip",
      ncontours: 1,
    });
  }
  return traces;
}

/** The curve of a special point, and the points on it at which two conditions meet. */
function locusTraces(locus) {
  const words = safe(locus.kind);
  return [
    {
      type: "scatter",
      mode: "lines",
      showlegend: false,
      x: Array.from(locus.lambda, (l) => l * per(main)),
      y: Array.from(locus.values),
      line: { color: COLORS[2], width: 3.5, dash: locus.kind === "fold" ? "solid" : "dash" },
      hovertemplate: `${words}<br>%{x:.6g}${unitSuffix()}, %{y:.6g}<extra></extra>`,
    },
    {
      type: "scatter",
      mode: "markers+text",
      showlegend: false,
      x: locus.specials.map((special) => special.at * per(main)),
      y: locus.specials.map((special) => special.value),
      text: locus.specials.map((special) => safe(special.kind)),
      // Two at one place have their names on different sides.
      textposition: locus.specials.map((_, i) => ["top right", "bottom left", "bottom right", "top left"][i % 4]),
      marker: { size: 9, color: "#fff", line: { color: INK, width: 2 } },
      hovertemplate: "%{text}<br>%{x:.6g}, %{y:.6g}<extra></extra>",
    },
  ];
}

/** The numbers of a cell that is clicked. */
function tellCell(chart, point) {
  if (!chart || point.data.type !== "heatmap") return;
  const columns = chart.lambda.length;
  const nearest = (list, value) =>
    list.reduce((best, one, i) => (Math.abs(one - value) < Math.abs(list[best] - value) ? i : best), 0);
  const places = Array.from(chart.lambda, (l) => l * per(main));
  const row = nearest(chart.values, point.y),
    column = nearest(places, point.x);
  const cell = row * columns + column,
    at = [0, 1].map((part) => chart.multiplier[2 * cell + part]);
  byId("cell").textContent =
    `${chart.parameter.replace(/_/g, " ")} = ${show(chart.values[row])}, ` +
    `${state.unit === "Lambda" ? "Λ = " : ""}${show(places[column])}${unitSuffix()}: ` +
    `${chart.motions[cell]} motions, ${chart.stable_motions[cell]} of them stable` +
    (Number.isFinite(at[0])
      ? `; largest multiplier of the most stable one ${show(at[0], 5)}${at[1] < 0 ? " - " : " + "}` +
        `${show(Math.abs(at[1]), 5)} i, magnitude ${show(Math.hypot(...at), 5)}.`
      : ".");
}

function runUpView(panel) {
  const plot = make("div", { id: "ramp", class: "plot", role: "img", "aria-label": "Forces and torques of the run-up" });
  plot.dataset.height = "460px";
  let along = "mesh";
  const [what] = choice(
    "show",
    [
      ["mesh", "mesh forces"],
      ["shaft", "shaft torques"],
    ],
    along,
    (value) => {
      along = value;
      draw();
    },
  );
  panel.append(
    make("div", { class: "controls" }, unitChoice("run-up"), main.parts.shaft.length ? what : null),
    plot,
    make("p", { class: "note" }, `Smallest to largest value in each cycle of the slowest mesh. ${main.runUp.ended}.`),
  );
  function draw() {
    const { low, high } = main.runUp[along],
      [names, unit, title] = { mesh: [main.parts.mesh, main.forceUnit, main.forceWords], shaft: [main.parts.shaft, "N m", "shaft torque"] }[along],
      width = low.shape[1],
      x = Array.from(main.runUp.lambda, (l) => l * per(main));
    const column = (values, part) => x.map((_, i) => values[i * width + part]),
      parts = range(width).filter((part) => column(low, part).some(Number.isFinite)),
      spans = parts.map((part) => spanOf([...column(low, part), ...column(high, part)])),
      split = areUnequal(spans, true),
      panels = panelsBelow(split ? parts.length : 1, 1).map((panel, place) => ({
        ...panel,
        columns: split ? [parts[place]] : parts,
        range: split ? rangeFor(spans[place], false) : null,
      }));
    const traces = panels.flatMap(({ axis, columns }) =>
      columns.flatMap((part) =>
        [low, high].map((values, place) => ({
          type: "scatter",
          mode: "lines",
          x,
          y: column(values, part),
          yaxis: axis,
          line: { color: COLORS[part % COLORS.length], width: 1 },
          fill: place ? "tonexty" : "none",
          name: safe(names[part]),
          showlegend: place === 1 && !split,
          hovertemplate: `${safe(names[part])}<br>%{x:.6g}${unitSuffix()}: %{y:.5g} ${unit}<extra></extra>`,
        })),
      ),
    );
    const layout = {
      ...baseLayout(frequencyTitle(), ""),
      margin: { l: 68, r: 10, t: 40, b: 48 },
      hovermode: "closest",
      showlegend: true,
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", traceorder: "normal" },
    };
    putPanels(plot, layout, panels, names, `${title}  [${unit}]`);
    drawPanels(plot, traces, layout);
  }
  return draw;
}

function trainView(panel) {
  for (const file of files) {
    if (files.length > 1) panel.append(make("h2", {}, file.name || file.title));
    const drawing = (svg, label, alt) => {
      const source = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" })),
        image = make("img", { class: "schematic", src: source, alt });
      panel.append(make("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": label }, image));
    };
    drawing(
      file.schematic,
      "Drawing of the train",
      `The train: meshes ${file.parts.mesh.join(", ")}; shafts ${file.parts.shaft.join(", ") || "none"}.`,
    );
    for (const { name, svg } of file.stages)
      drawing(svg, `Drawing of ${name}`, `${name}: front view with the planets, and lever diagram of the speeds.`);
    for (const warning of file.warnings) panel.append(make("p", {}, warning));
    panel.append(
      make(
        "details",
        { open: files.length === 1 },
        make("summary", {}, "Every number of the train"),
        make("pre", { tabindex: 0 }, file.explanation),
      ),
    );
  }
  return null;
}
