// The page of results of geartrain: draws what the block "data" holds. Lambda is the frequency of the fundamental over the train's
// characteristic frequency; a point is a periodic motion of a branch, or a motion that time integration found.
"use strict";

(async () => {
  // Colours of Okabe and Ito, which the colour-blind tell apart, as in the other pictures of geartrain.
  const COLORS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000"];
  const DASHES = ["solid", "dash", "dashdot", "dot"];
  const UNSTABLE = "5px,3px";
  const KINDS = {
    response: "response", cascade: "period doublings", branch: "from branch points", island: "islands",
    integration: "time integration", attractors: "attractors",
  };
  const SPECIALS = { "fold": "circle", "period doubling": "diamond", "neimark-sacker": "square", "branch point": "x" };
  const LENGTHS = new Set(["rms", "true_ac_rms", "mean", "minimum", "maximum"]);
  const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const INK = "#1b1f24";
  const AROUND_ONE = [[0, "#053061"], [0.25, "#4393c3"], [0.5, "#f7f7f7"], [0.75, "#d6604d"], [1, "#67001f"]];

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
    const count = place.shape.reduce((product, extent) => product * extent, 1), size = Type.BYTES_PER_ELEMENT;
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
  const show = (number, digits = 6) => number == null || !Number.isFinite(number) ? "" : String(Number(number.toPrecision(digits)));
  /** Names for plotly, which takes some tags for its own. */
  const safe = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
  const range = (count) => Array.from({ length: count }, (_, i) => i);
  const byId = (id) => document.getElementById(id);

  const problem = (text) => { const place = byId("problem"); place.textContent = text; place.hidden = false; };
  if (!("DecompressionStream" in window)) {
    problem("This browser is too old to unpack the page: it takes Chrome or Edge 80, Safari 16.4, Firefox 113, or later.");
    return;
  }
  const [library] = await unpack("plotly");
  const script = document.createElement("script");
  script.textContent = library;
  document.head.append(script);
  const [data, get] = await unpack("data");
  unpackAll(data, get);
  const files = data.files, main = files[0];
  files.forEach((file, number) => file.series.forEach((series, place) => Object.assign(series, { file: number, place })));

  // ------------------------------------------------------------------------------------------------- units and labels

  const state = {
    unit: files.every((file) => file.perLambda[main.unit]) ? main.unit : "Lambda",
    quantity: "rms", part: "all", mesh: 0, off: new Set(), chosen: null, mapWhat: "spectral_radius",
  };
  const per = (file) => file.perLambda[state.unit];
  const unitSuffix = () => ({ Lambda: "", rpm: " rpm", Hz: " Hz" })[state.unit];
  const frequencyTitle = () => ({
    Lambda: "fundamental frequency  Λ", rpm: `speed of ${safe(main.speedOf)}  [rpm]`, Hz: "fundamental frequency  [Hz]",
  })[state.unit];
  const lengthUnit = (file) => file.lengthUnit === "um" ? "[µm]" : file.lengthUnit ? `[${file.lengthUnit}]` : "/ b<sub>c</sub>";
  const lengthText = (file) => ({ um: " µm", m: " m" })[file.lengthUnit] || " b_c";
  function quantityTitle(name) {
    const { unit } = data.quantities[name], words = name.replace("mesh_force_maximum", "largest_mesh_force").replace(/_/g, " ");
    if (LENGTHS.has(name)) return `mesh displacement, ${words}  ${lengthUnit(main)}`;
    return unit === "1" ? words : `${words}  [${unit}]`;
  }
  const partsOf = (file, name = state.quantity) => data.quantities[name].along === "mesh" ? file.meshes : file.shafts;
  const columnsShown = (file) => state.part === "all" ? range(partsOf(file).length) : [Number(state.part)];
  const valueAt = (series, name, point, column) => {
    const values = series.values[name];
    return values ? values[point * values.shape[1] + column] : NaN;
  };
  const isOn = (what) => !state.off.has(what);
  const shown = () => files.flatMap((file, number) => number && !isOn("compare") ? [] : file.series.filter((s) => isOn(s.kind)));
  const isBranch = (series) => series.kind !== "integration" && series.kind !== "attractors";

  // ------------------------------------------------------------------------------------------------- layout of the page

  byId("title").textContent = main.title || "Gear train";
  byId("about").textContent = [
    ...files.map((file, number) => `${files.length > 1 ? (number ? "pale: " : "dark: ") + (file.name || file.title) + ", " : ""}` +
      Object.entries(KINDS).map(([kind, words]) => {
        const own = file.series.filter((s) => s.kind === kind), points = own.reduce((sum, s) => sum + s.count, 0);
        const branches = own.length > 1 ? `${own.length} branches, ` : "";
        return own.length && `${words} (${branches}${points} ${isBranch(own[0]) ? "points" : "motions"}${kind === "response" ? `; ${own[0].ended}` : ""})`;
      }).filter(Boolean).join(", ")),
    ...files.map((file) => file.ended).filter(Boolean),
  ].join(". ") + ".";
  byId("footer").textContent = `Made by geartrain ${data.version}. Drawn with plotly.js. This file needs no network.`;

  const views = [
    ["response", "Response", main.series.length, responseView],
    ["map", "Stability map", main.map, mapView],
    ["tables", "Tables", main.tables.length, tablesView],
    ["run-up", "Run-up", main.runUp, runUpView],
    ["train", "Train", true, trainView],
  ].filter((view) => view[2]);
  const drawers = {};  // what draws a view when it is first shown, and again after a change of units
  for (const [id, words, , build] of views) {
    const tab = make("button", {
      role: "tab", id: `tab-${id}`, "aria-controls": `view-${id}`, type: "button", onclick: () => openTab(id), onkeydown: tabKeys,
    }, words);
    byId("tabs").append(tab);
    const panel = make("section", { role: "tabpanel", id: `view-${id}`, "aria-labelledby": `tab-${id}`, hidden: true });
    byId("views").append(panel);
    drawers[id] = build(panel);
  }

  function openTab(id) {
    for (const [other] of views) {
      const own = other === id, tab = byId(`tab-${other}`);
      tab.setAttribute("aria-selected", own);
      tab.tabIndex = own ? 0 : -1;
      byId(`view-${other}`).hidden = !own;
    }
    state.tab = id;
    drawers[id]?.();
  }

  function tabKeys(event) {
    const place = views.findIndex(([id]) => id === state.tab);
    const next = { ArrowRight: place + 1, ArrowLeft: place - 1, Home: 0, End: views.length - 1 }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    const [id] = views[(next + views.length) % views.length];
    openTab(id);
    byId(`tab-${id}`).focus();
  }

  /** The choice of the unit of frequencies, in every view that has one. */
  function unitChoice(where) {
    // Where Lambda is the speed in rpm it is not offered twice.
    const same = files.every((file) => file.perLambda.rpm && Math.abs(file.perLambda.rpm - 1) < 1e-9);
    const units = ["Lambda", "rpm", "Hz"].filter((unit) => files.every((file) => file.perLambda[unit]) && !(same && unit === "Lambda"));
    return make("fieldset", {}, make("legend", {}, "frequency"), ...units.map((unit) => {
      const input = make("input", {
        type: "radio", name: `unit-${where}`, value: unit, checked: unit === state.unit,
        onchange: () => {
          state.unit = unit;
          document.querySelectorAll(`input[type=radio][value="${unit}"]`).forEach((other) => { other.checked = true; });
          drawers[state.tab]();
        },
      });
      return make("label", {}, input, unit === "Lambda" ? "Λ" : unit);
    }));
  }

  function choice(words, options, value, change) {
    const select = make("select", { onchange: () => change(select.value) });
    for (const [option, text] of options) select.append(make("option", { value: option, selected: option === value }, text));
    return [make("label", {}, words, select), select];
  }

  // ------------------------------------------------------------------------------------------------- response curves

  function responseView(panel) {
    const names = Object.keys(data.quantities).filter((name) => main.series.some((series) => series.values[name]));
    const [quantityLabel] = choice("quantity", names.map((name) => [name, name.replace(/_/g, " ")]), state.quantity, (name) => {
      const along = data.quantities[state.quantity].along;
      state.quantity = name;
      if (data.quantities[name].along !== along) state.part = "all";
      fillParts();
      draw(true);
    });
    const [partLabel, parts] = choice("of", [], "all", (part) => {
      state.part = part;
      if (part !== "all" && data.quantities[state.quantity].along === "mesh") state.mesh = Number(part);
      draw(true);
    });
    function fillParts() {
      const along = data.quantities[state.quantity].along;
      parts.replaceChildren(make("option", { value: "all" }, along === "mesh" ? "all meshes" : "all shafts"),
        ...partsOf(main).map((name, place) => make("option", { value: place }, name)));
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
        type: "checkbox", id: `show-${what}`, checked: true,
        onchange: () => { state.off[box.checked ? "delete" : "add"](what); draw(true); },
      });
      return make("label", {}, box, words);
    });
    const plot = make("div", {
      id: "curve", class: "plot", tabindex: 0, role: "application", "aria-describedby": "keys",
      "aria-label": "Response curves. Arrow keys left and right go along the branch, up and down to the next one.",
    });
    const key = make("ul", { class: "key", id: "key", "aria-label": "Key" });
    panel.append(
      make("div", { class: "controls" }, unitChoice("response"), quantityLabel, partLabel),
      make("div", { class: "controls" }, make("fieldset", {}, make("legend", {}, "show"), ...boxes)),
      make("div", { class: "columns" },
        make("div", { class: "curves" }, key, plot,
          make("p", { class: "note", id: "keys" }, "Click a point, or give the picture the focus: left and right arrow go along the " +
            "branch (with Shift by ten points), Home and End to its ends, up and down to the next branch.")),
        ...pointPanels()),
    );
    plot.addEventListener("keydown", moveKeys);
    let drawn = false;
    function draw(again) {
      if (drawn && !again && drawn === state.unit) { Plotly.Plots.resize(plot); return; }
      drawn = state.unit;
      drawCurves(plot, key);
      const first = main.series.find((series) => series.count);
      if (!state.chosen && first) choose(first, Math.floor(first.count / 2), 0);
      else drawPoint();
    }
    return draw;
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

  function curveTraces() {
    const traces = [];
    for (const number of files.length > 1 && isOn("compare") ? [1, 0] : [0]) {
      const file = files[number], pale = number === 1;
      for (const kind of Object.keys(KINDS)) {
        const members = file.series.filter((series) => series.kind === kind && isOn(kind) && series.values[state.quantity]);
        if (!members.length) continue;
        for (const column of columnsShown(file)) {
          const color = COLORS[column % COLORS.length], name = safe(partsOf(file)[column]);
          const told = `${pale ? `${safe(file.name || file.title)}, ` : ""}${name}`;
          if (isBranch(members[0])) {
            for (const stable of [true, false]) {
              const x = [], y = [], own = [];
              for (const series of members) {
                const values = series.values[state.quantity], width = values.shape[1];
                for (const [from, to, verdict] of pieces(series)) {
                  if (verdict !== stable) continue;
                  for (let i = from; i < to; i++) {
                    x.push(series.lambda[i] * per(file)); y.push(values[i * width + column]); own.push(code(series, i));
                  }
                  x.push(null); y.push(null); own.push(null);
                }
              }
              if (!x.length) continue;
              const words = members[0].stable ? (stable ? "stable" : "unstable") : "";
              traces.push({
                type: "scatter", mode: "lines", x, y, customdata: own, meta: { file: number, column, kind, stable },
                line: { color, dash: stable ? "solid" : UNSTABLE, width: (kind === "response" ? 2.2 : 1.3) + (pale ? 5 : 0) },
                opacity: pale ? 0.3 : 1, connectgaps: false,
                hovertemplate: `${told}, ${KINDS[kind]}${words && `, ${words}`}<br>%{x:.6g}${unitSuffix()}: %{y:.5g}<extra></extra>`,
              });
            }
          } else {
            for (const series of members) {
              const values = series.values[state.quantity], width = values.shape[1], ways = series.directions;
              traces.push({
                type: "scatter", mode: "markers", x: Array.from(series.lambda, (l) => l * per(file)),
                y: range(series.count).map((i) => values[i * width + column]),
                customdata: range(series.count).map((i) => code(series, i)), meta: { file: number, column, kind, stable: true },
                opacity: pale ? 0.4 : 1,
                marker: {
                  color, size: kind === "attractors" ? 10 : 7, line: { color, width: 1.2 },
                  symbol: kind === "attractors" ? "star" : range(series.count).map((i) => ways[i] === "down" ? "triangle-down-open" : "triangle-up"),
                },
                hovertemplate: `${told}, ${KINDS[kind]}<br>%{x:.6g}${unitSuffix()}: %{y:.5g}<extra></extra>`,
              });
            }
          }
        }
      }
    }
    if (isOn("specials")) traces.push(...specialTraces());
    return traces;
  }

  /** Marks of special points: at their own rms; of any other quantity at the value of the point before. */
  function specialTraces() {
    const marks = {};
    for (const series of main.series.filter((s) => isOn(s.kind) && s.values[state.quantity])) {
      for (const special of series.specials) {
        const mark = marks[special.kind] ??= { x: [], y: [], own: [] };
        for (const column of columnsShown(main)) {
          const factor = state.quantity === "rms" ? 1 : state.quantity === "true_ac_rms" ? Math.SQRT1_2 : 0;
          mark.x.push(special.at * per(main));
          mark.y.push(factor ? factor * special.rms[column] : valueAt(series, state.quantity, special.point, column));
          mark.own.push(code(series, special.point));
        }
      }
    }
    return Object.entries(marks).map(([kind, mark]) => ({
      type: "scatter", mode: "markers", x: mark.x, y: mark.y, customdata: mark.own, meta: { file: 0, column: null, kind: "specials" },
      marker: { symbol: SPECIALS[kind] || "star", size: 8, color: "#fff", line: { color: INK, width: 1.6 } },
      hovertemplate: `${kind}<br>%{x:.6g}${unitSuffix()}: %{y:.5g}<extra></extra>`,
    }));
  }

  /** Strips above the curves, a row for each mesh: light where the teeth separate, dark where the back flanks collide. */
  function rangeTraces(rows) {
    const traces = [];
    for (const what of ["apart", "back"]) {
      for (const mesh of rows) {
        const x = [], y = [];
        for (const series of main.series.filter((s) => s.kind === "response")) {
          for (const [own, kind, low, high] of series.ranges) {
            if (own !== mesh || kind !== what) continue;
            x.push(low * per(main), high * per(main), null);
            y.push(rows.indexOf(mesh), rows.indexOf(mesh), null);
          }
        }
        const words = what === "apart" ? "teeth separate" : "back flanks collide";
        if (x.length) {
          traces.push({
            type: "scatter", mode: "lines", x, y, yaxis: "y2", meta: { kind: "ranges" }, opacity: what === "apart" ? 0.4 : 1,
            line: { color: COLORS[mesh % COLORS.length], width: 9 },
            hovertemplate: `${safe(main.meshes[mesh])}: ${words}, to %{x:.6g}${unitSuffix()}<extra></extra>`,
          });
        }
      }
    }
    return traces;
  }

  function drawCurves(plot, key) {
    const rows = !isOn("ranges") || !isOn("response") ? [] : range(main.meshes.length).filter((mesh) =>
      main.series.some((s) => s.kind === "response" && s.ranges.some((row) => row[0] === mesh)));
    const traces = [...curveTraces(), ...rangeTraces(rows)];
    const top = 1 - Math.min(0.35, 0.035 * rows.length + (rows.length ? 0.02 : 0));
    const shapes = selectionShapes();
    const annotations = [];
    if (isOn("ranges") && isOn("response")) {
      for (const series of main.series.filter((s) => s.kind === "response")) {
        for (const [low, high] of series.bands) {
          shapes.push({ type: "rect", xref: "x", yref: "paper", x0: low * per(main), x1: high * per(main), y0: 0, y1: top,
            fillcolor: "#999", opacity: 0.15, line: { width: 0 }, layer: "below" });
        }
      }
    }
    if (isOn("jumps")) {
      for (const series of main.series.filter((s) => s.kind === "response" && isOn(s.kind))) {
        for (const jump of series.jumps) {
          const x = jump.at * per(main), factor = { rms: 1, true_ac_rms: Math.SQRT1_2 }[state.quantity];
          let drawn = 0;
          for (const column of factor ? columnsShown(main) : []) {
            if (jump.after[column] == null) continue;
            drawn++;
            annotations.push({ x, y: factor * jump.after[column], ax: x, ay: factor * jump.before[column], axref: "x", ayref: "y",
              xref: "x", yref: "y", showarrow: true, arrowhead: 2, arrowsize: 1, arrowwidth: 1.3, arrowcolor: "#4a525c", text: "" });
          }
          if (!drawn) {
            shapes.push({ type: "line", xref: "x", yref: "paper", x0: x, x1: x, y0: 0, y1: top,
              line: { color: "#4a525c", width: 1, dash: "dot" } });
          }
        }
      }
    }
    const layout = {
      ...baseLayout(frequencyTitle(), quantityTitle(state.quantity)),
      margin: { l: 68, r: 14, t: 32, b: 48 }, shapes, annotations, hovermode: "closest", dragmode: "zoom",
      uirevision: `${state.unit} ${state.quantity}`, hoverdistance: 30,
    };
    layout.yaxis.domain = [0, top];
    if (data.quantities[state.quantity].unit !== "1") layout.yaxis.exponentformat = "none";
    layout.yaxis.title.standoff = 8;
    if (rows.length) {
      layout.yaxis2 = { domain: [top + 0.015, 1], range: [-0.6, rows.length - 0.4], tickvals: range(rows.length), fixedrange: true,
        ticktext: rows.map((mesh) => `mesh ${mesh + 1}`), showgrid: false, zeroline: false, tickfont: { size: 11 } };
    }
    Plotly.react(plot, traces, layout, CONFIG);
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

  function baseLayout(x, y) {
    const axis = (text) => ({ title: { text, font: { size: 14 } }, gridcolor: "#e6e9ed", zeroline: false, linecolor: "#5b636d",
      showline: true, ticks: "outside", ticklen: 4, tickcolor: "#5b636d", automargin: true, exponentformat: "power" });
    return { xaxis: axis(x), yaxis: axis(y), showlegend: false, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
      font: { color: INK, size: 12.5, family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif' } };
  }

  /** What lines and marks mean, below the controls. */
  function drawKey(key, traces) {
    const kinds = new Set(traces.map((trace) => trace.meta?.kind)), items = [];
    const line = (color, dash = "", width = 2.2, opacity = 1) =>
      `<line x1="1" y1="7" x2="27" y2="7" stroke="${color}" stroke-width="${width}" stroke-dasharray="${dash}" opacity="${opacity}"/>`;
    const mark = (path, fill = "#fff") => `<path d="${path}" fill="${fill}" stroke="${INK}" stroke-width="1.4"/>`;
    for (const column of columnsShown(main)) items.push([line(COLORS[column % COLORS.length]), partsOf(main)[column]]);
    if (traces.some((trace) => trace.meta?.stable === false)) items.push([line("#4a525c", "5,3"), "unstable"]);
    if (["cascade", "branch", "island"].some((kind) => kinds.has(kind))) items.push([line("#4a525c", "", 1.2), "further branches"]);
    if (kinds.has("integration")) {
      items.push([mark("M9 12L14 3L19 12Z", "#4a525c"), "integration, rising speed"]);
      if (files.some((file) => file.series.some((s) => s.directions?.includes("down")))) {
        items.push([mark("M9 3L14 12L19 3Z"), "integration, falling speed"]);
      }
    }
    if (kinds.has("attractors")) items.push([mark("M14 1l2 4 4 .5-3 3 .8 4.3-3.8-2-3.8 2 .8-4.3-3-3 4-.5z", "#4a525c"), "attractors"]);
    if (isOn("jumps") && main.series.some((s) => s.kind === "response" && isOn(s.kind) && s.jumps.length)) {
      items.push([mark("M14 12V4M11 6.5L14 3L17 6.5", "none"), "jump of the response (dotted: to another branch or period)"]);
    }
    const circle = `<circle cx="14" cy="7" r="4" fill="#fff" stroke="${INK}" stroke-width="1.4"/>`;
    const signs = { "fold": circle, "period doubling": mark("M14 2L19 7L14 12L9 7Z"), "neimark-sacker": mark("M10 3H18V11H10Z"),
      "branch point": mark("M10 3L18 11M18 3L10 11", "none") };
    for (const kind of kinds.has("specials") ? Object.keys(SPECIALS) : []) {
      if (main.series.some((s) => isOn(s.kind) && s.specials.some((special) => special.kind === kind))) items.push([signs[kind], kind]);
    }
    if (kinds.has("ranges")) {
      const words = main.series.some((s) => s.ofStable) ? " (stable motions)" : "";
      items.push([line("#4a525c", "", 8, 0.4), `teeth separate${words}`]);
      if (main.series.some((s) => s.ranges.some((row) => row[1] === "back"))) items.push([line("#4a525c", "", 8), `back flanks collide${words}`]);
    }
    if (isOn("ranges") && main.series.some((s) => s.kind === "response" && s.bands.length)) {
      items.push(['<rect x="1" y="1" width="26" height="12" fill="#999" opacity=".3"/>', "no stable motion of this branch"]);
    }
    if (files.length > 1 && isOn("compare")) items.push([line("#4a525c", "", 7, 0.3), `compared: ${files[1].name || files[1].title}`]);
    key.replaceChildren(...items.map(([drawing, words]) => {
      const item = make("li");
      item.innerHTML = `<svg width="28" height="14" aria-hidden="true">${drawing}</svg>`;
      item.append(words);
      return item;
    }));
  }

  // ------------------------------------------------------------------------------------------------- the chosen point

  /** A line at the chosen speed, and a ring at each of its values; always as many, so that they can be moved alone. */
  function selectionShapes() {
    const file = state.chosen ? files[state.chosen.series.file] : main;
    const rings = Math.max(...files.map((other) => columnsShown(other).length));
    const x = state.chosen ? state.chosen.series.lambda[state.chosen.point] * per(file) : 0;
    const there = Boolean(state.chosen);
    const shapes = [{ type: "line", xref: "x", yref: "paper", x0: x, x1: x, y0: 0, y1: 1, line: { color: INK, width: 1 }, opacity: 0.45, visible: there }];
    for (let ring = 0; ring < rings; ring++) {
      const column = columnsShown(file)[ring];
      const y = there && column !== undefined ? valueAt(state.chosen.series, state.quantity, state.chosen.point, column) : NaN;
      shapes.push({ type: "circle", xref: "x", yref: "y", xsizemode: "pixel", ysizemode: "pixel", xanchor: x,
        yanchor: Number.isFinite(y) ? y : 0, x0: -7, x1: 7, y0: -7, y1: 7, line: { color: INK, width: 2.5 }, visible: Number.isFinite(y) });
    }
    return shapes;
  }

  function choose(series, point, column) {
    state.chosen = { series, point };
    if (data.quantities[state.quantity].along === "mesh" && column != null) setMesh(column);
    const plot = byId("curve"), changes = {};
    if (plot.layout) {
      selectionShapes().forEach((shape, place) => {
        for (const name of ["x0", "x1", "xanchor", "yanchor", "visible"]) {
          if (name in shape && (place === 0 || name !== "x0" && name !== "x1")) changes[`shapes[${place}].${name}`] = shape[name];
        }
      });
      Plotly.relayout(plot, changes);
    }
    drawPoint();
  }

  function moveKeys(event) {
    if (!state.chosen || event.ctrlKey || event.altKey || event.metaKey) return;
    const { series, point } = state.chosen, step = event.shiftKey ? 10 : 1, last = series.count - 1;
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
      const at = series.lambda[point] * per(files[series.file]), factor = per(files[other.file]);
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
    const [meshLabel, select] = choice("phase plane of", main.meshes.map((name, place) => [String(place), name]), "0", (mesh) => {
      state.mesh = Number(mesh);
      drawPoint();
    });
    select.id = "plane-mesh";
    const small = (id, words) => make("div", { id, class: "plot small", role: "img", "aria-label": words });
    return [
      make("section", { "aria-label": "The chosen motion", id: "point" },
        make("h2", {}, "The chosen motion"),
        make("div", { id: "facts", "aria-live": "polite" })),
      make("section", { "aria-label": "Time histories of the chosen motion" },
        small("wave", "Displacement of the meshes over time"), small("force", "Force of the meshes over time"),
        make("p", { class: "note", id: "force-note", hidden: true })),
      make("section", { "aria-label": "Phase plane, spectrum and multipliers of the chosen motion" },
        make("div", { class: "pair" }, make("div", {}, small("spectrum", "Spectrum of the displacement")),
          make("div", {}, small("plane", "Phase plane: velocity over displacement"), make("div", { class: "controls" }, meshLabel))),
        small("multipliers", "Floquet multipliers and the unit circle"),
        make("p", { class: "note", id: "multipliers-note", hidden: true })),
    ];
  }

  const PICTURES = [drawHistories, drawForces, drawSpectrum, drawPlane, drawMultipliers];
  let left = 0, next = 0;
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
    if (series.multipliers && Number.isNaN(series.multipliers[point * series.multipliers.shape[1] * 2])) return "stability not known";
    const words = series.stable[point] ? "stable" : "unstable";
    return series.undecided?.[point] ? `${words}, but undecided: the largest multiplier is as near to the unit circle as it is uncertain` : words;
  }

  function drawFacts() {
    const { series, point } = state.chosen, file = files[series.file], facts = [];
    const fact = (name) => series.facts[name]?.[point];
    const lambda = series.lambda[point], speeds = [];
    if (file.perLambda.rpm) speeds.push(`${show(lambda * file.perLambda.rpm)} rpm of ${file.speedOf}`);
    if (file.perLambda.Hz) speeds.push(`${show(lambda * file.perLambda.Hz)} Hz`);
    if (!(file.perLambda.rpm && Math.abs(file.perLambda.rpm - 1) < 1e-9)) speeds.unshift(`Λ = ${show(lambda, 7)}`);
    facts.push(["motion", `${files.length > 1 ? `${file.name || file.title}, ` : ""}${series.name}, point ${point + 1} of ${series.count}` +
      (series.directions?.[point] ? `, ${series.directions[point] === "up" ? "rising" : "falling"} speed` : "")]);
    facts.push(["speed", speeds.join(", ")]);
    facts.push(["verdict", verdict(series, point)]);
    facts.push(["period", series.period[point] ? `${series.period[point]} of the fundamental` : "none found"]);
    if (Number.isFinite(fact("error_estimate"))) {
      facts.push(["error", `${show(fact("error_estimate"), 2)} of the waveform, estimated${fact("estimate_doubtful") ? ", doubtful" : ""}`]);
    }
    if (Number.isFinite(fact("correction"))) facts.push(["refined", `by shooting; it moved by ${show(fact("correction"), 2)}`]);
    if (fact("harmonics")) facts.push(["harmonics", show(fact("harmonics"))]);
    if (Number.isFinite(fact("share"))) facts.push(["share of starts", `${show(100 * fact("share"), 3)} %`]);
    if (Number.isFinite(fact("lyapunov_exponent"))) {
      facts.push(["Lyapunov exponent", `${show(fact("lyapunov_exponent"), 3)} ± ${show(fact("lyapunov_error"), 2) || 0} (1/characteristic frequency)`]);
    }
    if (fact("floating")) facts.push(["floating", "no mean torque holds a mesh in its gap: its mean position is not unique"]);
    const list = make("dl", {}, ...facts.flatMap(([name, words]) => [make("dt", {}, name), make("dd", {}, words)]));
    const names = ["rms", "mean", "minimum", "maximum", "mesh_force_maximum", "dynamic_factor", "separation_fraction", "back_contact_fraction"]
      .filter((name) => series.values[name]);
    const unit = (name) => LENGTHS.has(name) ? lengthText(file) : { N: " N" }[data.quantities[name].unit] || "";
    const head = make("tr", {}, make("th", { scope: "col" }, ""), ...file.meshes.map((name) => make("th", { scope: "col" }, name)));
    const body = names.map((name) => make("tr", {}, make("th", { scope: "row" }, name.replace(/_/g, " ").replace("mesh force maximum", "largest force")),
      ...file.meshes.map((_, mesh) => {
        const value = valueAt(series, name, point, mesh);
        return make("td", {}, Number.isFinite(value) ? show(value, 5) + unit(name) : "");
      })));
    byId("facts").replaceChildren(list, make("div", { class: "scroll" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))));
  }

  /** Displacement, velocity (by the phase of the fundamental) and force over phases of the fundamental, of each mesh. */
  function waveform(series, point, phases) {
    const file = files[series.file], all = series.coefficients, [, meshes, width] = all.shape, period = series.period[point] || 16;
    const base = point * meshes * width, orders = series.orders, found = [];
    for (let mesh = 0; mesh < meshes; mesh++) {
      const p = new Float64Array(phases.length).fill(all[base + mesh * width]), v = new Float64Array(phases.length);
      for (let h = 0; h < orders.length; h++) {
        const a = all[base + mesh * width + 1 + 2 * h], b = all[base + mesh * width + 2 + 2 * h];
        if (!(Math.abs(a) + Math.abs(b) > 0)) continue;  // not there, NaN
        const order = orders[h] / period;
        for (let i = 0; i < phases.length; i++) {
          const c = Math.cos(order * phases[i]), s = Math.sin(order * phases[i]);
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
    const flank = (terms, phase) => terms.reduce((sum, [order, c, s]) => sum + c * Math.cos(order * phase) + s * Math.sin(order * phase), 0);
    return Float64Array.from(phases, (phase, i) => {
      const region = p[i] > law.half || law.half === 0 ? 2 : p[i] < -law.half ? 0 : 1;
      const elastic = region === 2 ? flank(law.drive, phase) * (p[i] - law.half) : region === 0 ? flank(law.back, phase) * (p[i] + law.half) : 0;
      return elastic + law.damping[region] * lambda * v[i];
    });
  }
  const evenly = (count, end) => Float64Array.from({ length: count }, (_, i) => end * i / (count - 1));

  const STILL = { displayModeBar: false, responsive: true };
  const smallLayout = (x, y, more = {}) => ({ ...baseLayout(x, y), margin: { l: 58, r: 8, t: 8, b: 40 }, hovermode: "closest", ...more });

  /** What the pictures of the chosen motion share. */
  function pictured() {
    const { series, point } = state.chosen, file = files[series.file], lambda = series.lambda[point];
    const there = series.coefficients && Number.isFinite(series.coefficients[point * series.coefficients.shape[1] * series.coefficients.shape[2]]);
    const period = series.period[point] || 16, columns = range(file.meshes.length);
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
    const time = Array.from(phases, (phase) => scale * phase / (2 * Math.PI));
    const timeTitle = inTime ? "time  [ms]" : "time, periods of the fundamental";
    const lines = waves ? meshes.filter((mesh) => waves[mesh][what]).map((mesh, row) => ({
      type: "scatter", mode: "lines", x: time, y: Array.from(waves[mesh][what]), name: safe(file.meshes[mesh]),
      line: { color: COLORS[mesh % COLORS.length], width: 1.8, dash: DASHES[row % DASHES.length] },
      hovertemplate: `${safe(file.meshes[mesh])}<br>%{x:.4g}: %{y:.5g}<extra></extra>`,
    })) : [];
    return [lines, timeTitle];
  }

  function drawHistories(picture) {
    const [lines, time] = histories(picture, "p"), several = picture.meshes.length > 1;
    Plotly.react("wave", lines, smallLayout(time, `displacement ${lengthUnit(picture.file)}`, {
      showlegend: several, legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom" }, margin: { l: 58, r: 8, t: several ? 30 : 8, b: 40 },
    }), STILL);
  }

  function drawForces(picture) {
    const [lines, time] = histories(picture, "force"), layout = smallLayout(time, "mesh force  [N]");
    byId("force").hidden = !lines.length;
    byId("force-note").textContent = picture.file.forces;
    byId("force-note").hidden = !picture.file.forces;
    if (!lines.length) return;
    layout.yaxis.exponentformat = "none";
    Plotly.react("force", lines, layout, STILL);
  }

  function drawSpectrum({ series, point, file, meshes, there, period, all }) {
    const traces = [], names = new Map(file.orderNames);
    const factor = state.unit === "Hz" && file.perLambda.Hz ? file.perLambda.Hz * series.lambda[point]
      : state.unit === "rpm" ? file.perLambda.Hz / (file.perLambda.rpm / 60) : 1;
    if (there) {
      const [, count, width] = all.shape;
      const rows = meshes.map((mesh) => series.orders.map((_, h) => {
        const base = (point * count + mesh) * width + 1 + 2 * h;
        return Math.hypot(all[base] || 0, all[base + 1] || 0);
      }));
      const largest = Math.max(...rows.flat());
      const seen = range(series.orders.length).filter((h) => rows.some((row) => row[h] > 3e-3 * largest));
      meshes.forEach((mesh, place) => {
        // Side by side, so that no mesh hides another.
        const gap = seen.length > 1 ? Math.min(...seen.slice(1).map((h, i) => series.orders[h] - series.orders[seen[i]])) : 1;
        const x = [], y = [], told = [];
        for (const h of seen) {
          const order = series.orders[h] / period, name = names.get(order);
          const words = `order ${show(order, 6)}${name ? `: ${safe(name)}` : ""}`;
          told.push(words, words, "");
          const at = factor * (series.orders[h] + gap * 0.16 * (place - (meshes.length - 1) / 2)) / period;
          x.push(at, at, null); y.push(0, rows[place][h], null);
        }
        traces.push({ type: "scatter", mode: "lines+markers", x, y, line: { color: COLORS[mesh % COLORS.length], width: 2.5 },
          marker: { size: range(x.length).map((i) => i % 3 === 1 ? 6 : 0), opacity: 1, symbol: ["circle", "square", "triangle-up", "diamond"][place % 4] },
          text: told, hovertemplate: `${safe(file.meshes[mesh])}<br>%{text}<br>%{y:.4g}<extra></extra>` });
      });
    }
    const title = { Lambda: "order, multiples of Λ", rpm: `order, per revolution of ${safe(file.speedOf)}`, Hz: "frequency  [Hz]" }[state.unit];
    const made = smallLayout(title, `amplitude ${lengthUnit(file)}`);
    made.yaxis.rangemode = "tozero";
    made.xaxis.rangemode = "tozero";
    Plotly.react("spectrum", traces, made, STILL);
  }

  function drawPlane({ series, point, file, there, period, highest, lambda }) {
    const mesh = Math.min(state.mesh, file.meshes.length - 1);
    const phases = evenly(Math.min(8000, Math.max(600, Math.ceil(24 * highest * period))), 2 * Math.PI * period);
    const wave = there ? waveform(series, point, phases)[mesh] : null;
    const made = smallLayout(`displacement ${lengthUnit(file)}`, `velocity ${file.lengthUnit === "um" ? "[mm/s]" : file.lengthUnit ? "[m/s]" : "/ b<sub>c</sub> ω<sub>c</sub>"}`);
    const half = file.laws[mesh]?.half || 0;
    if (wave && half) {
      const low = Math.min(...wave.p), high = Math.max(...wave.p), room = 0.06 * (high - low);
      made.xaxis.range = [low - room, high + room];
      made.shapes = [{ type: "rect", xref: "x", yref: "paper", x0: -half, x1: half, y0: 0, y1: 1, fillcolor: "#999", opacity: 0.18, line: { width: 0 }, layer: "below" }];
      if (half > low && -half < high) {
        made.annotations = [{ x: 0.98, y: 0.98, xref: "paper", yref: "paper", xanchor: "right", yanchor: "top", text: "grey: gap", showarrow: false, font: { size: 11 } }];
      }
    }
    // By the phase of the fundamental; over time it is Lambda times that, over 1/characteristic frequency.
    const omega = 2 * Math.PI * file.perLambda.Hz;
    const factor = lambda * (file.lengthUnit === "um" ? 1e-3 * omega : file.lengthUnit ? omega : 1);
    Plotly.react("plane", wave ? [{ type: "scatter", mode: "lines", x: Array.from(wave.p), y: Array.from(wave.v, (v) => v * factor),
      line: { color: COLORS[mesh % COLORS.length], width: highest * period > 100 ? 0.6 : 1.6 },
      hovertemplate: "%{x:.4g}, %{y:.4g}<extra></extra>" }] : [], made, STILL);
  }

  function drawMultipliers({ series, point }) {
    const note = byId("multipliers-note"), all = series.multipliers;
    const values = all ? range(all.shape[1]).map((i) => [0, 1].map((part) => all[(point * all.shape[1] + i) * 2 + part])).filter((z) => Number.isFinite(z[0])) : [];
    byId("multipliers").hidden = !values.length;
    note.hidden = false;
    if (!values.length) { note.textContent = "Multipliers: not in the file for this motion."; return; }
    const sizes = values.map((z) => Math.hypot(...z)), largest = Math.max(...sizes);
    const outside = sizes.filter((size) => size > 1).length;
    note.textContent = `Largest magnitude of a multiplier ${show(largest, 6)}; outside the unit circle: ${outside || "none"}.`;
    const traces = [false, true].map((out) => {
      const own = values.filter((_, i) => sizes[i] > 1 === out);
      return { type: "scatter", mode: "markers", x: own.map((z) => z[0]), y: own.map((z) => z[1]),
        marker: { size: 9, color: out ? "#D55E00" : "#0072B2", symbol: out ? "diamond" : "circle", line: { color: "#fff", width: 1 } },
        hovertemplate: `%{x:.5g}, %{y:.5g} i<extra>${out ? "outside" : "inside"}</extra>` };
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

  // ------------------------------------------------------------------------------------------------- tables

  function tablesView(panel) {
    panel.append(make("p", { class: "note" }, "A click on a heading sorts, a second one the other way. ‘show’ goes to the motion."));
    files.forEach((file, number) => {
      if (files.length > 1) panel.append(make("h2", {}, file.name || file.title || `file ${number + 1}`));
      for (const table of file.tables) panel.append(sortable(table, number));
    });
    return null;
  }

  function sortable(table, number) {
    const rows = table.rows.map((cells, place) => ({ cells, place }));
    const body = make("tbody");
    const heads = table.headings.map((heading, column) => make("th", { scope: "col" },
      make("button", { type: "button", onclick: () => sort(column) }, heading)));
    function fill() {
      body.replaceChildren(...rows.map(({ cells, place }) => make("tr", {}, ...cells.map((cell) => make("td", {}, words(cell))),
        table.points.length ? make("td", {}, make("button", { type: "button", "aria-label": `show row ${place + 1} of ${table.name}`, onclick: () => {
          const [series, point] = table.points[place];
          openTab("response");
          choose(files[number].series[series], point);
          byId("curve").focus();
        } }, "show")) : null)));
    }
    function sort(column) {
      const down = heads[column].getAttribute("aria-sort") === "ascending", sign = down ? -1 : 1;
      heads.forEach((head) => head.removeAttribute("aria-sort"));
      heads[column].setAttribute("aria-sort", down ? "descending" : "ascending");
      const order = (a, b) => a == null ? 1 : b == null ? -1 :
        sign * (typeof a === "string" || typeof b === "string" ? String(a).localeCompare(String(b)) : a - b) || 0;
      rows.sort((one, other) => order(one.cells[column], other.cells[column]) || one.place - other.place);
      fill();
    }
    const words = (cell) => cell === true ? "yes" : cell === false ? "no" : typeof cell === "number" ? show(cell) : cell ?? "";
    fill();
    return make("div", { class: "scroll" }, make("table", {}, make("caption", {}, table.name),
      make("thead", {}, make("tr", {}, ...heads, table.points.length ? make("th", { scope: "col" }, "") : null)), body));
  }

  // ------------------------------------------------------------------------------------------------- map, run-up, train

  const PARAMETERS = { stiffness_variation: "stiffness variation  κ", mesh_damping_ratio: "mesh damping ratio  ζ" };

  function mapView(panel) {
    const chart = main.map, plot = make("div", { id: "chart", class: "plot", role: "img", "aria-label": "Stability map" });
    plot.style.height = "560px";
    const [what] = choice("show", [["spectral_radius", "largest |multiplier|"], ["stable_motions", "stable motions"], ["motions", "motions"]],
      state.mapWhat, (value) => { state.mapWhat = value; draw(); });
    panel.append(make("div", { class: "controls" }, unitChoice("map"), what), plot,
      make("p", { class: "note", id: "cell", "aria-live": "polite" }, "Click a cell: its numbers stand here."),
      make("p", { class: "note" }, `${chart.linear ? "Of the train without backlash. " : ""}${chart.ended}.`));
    function draw() {
      const rows = chart.values.length, columns = chart.lambda.length, values = chart[state.mapWhat];
      const x = Array.from(chart.lambda, (l) => l * per(main)), y = Array.from(chart.values);
      const z = range(rows).map((row) => range(columns).map((column) => {
        const value = values[row * columns + column];
        return Number.isFinite(value) && value >= 0 ? value : null;
      }));
      const radius = state.mapWhat === "spectral_radius", most = Math.max(1, ...z.flat().filter((v) => v != null));
      const colors = ["#440154", "#31688e", "#35b779", "#fde725", "#ffffff", "#bbbbbb"];
      const steps = range(most + 1).flatMap((k) => [k, k + 1].map((edge) => [edge / (most + 1), colors[Math.min(k, 5)]]));
      const traces = [{
        type: "heatmap", x, y, z, hoverongaps: false,
        ...(radius ? { colorscale: AROUND_ONE, zmin: 0.5, zmax: 1.5 } : { colorscale: steps, zmin: -0.5, zmax: most + 0.5 }),
        colorbar: { title: { text: radius ? "largest |multiplier|" : state.mapWhat.replace("_", " "), side: "right" }, thickness: 14,
          ...(radius ? {} : { tickvals: range(most + 1) }) },
        hovertemplate: `%{x:.6g}${unitSuffix()}, %{y:.5g}: %{z:.4g}<extra></extra>`,
      }];
      if (radius && rows > 1 && columns > 1) {
        traces.push({ type: "contour", x, y, z, contours: { start: 1, end: 1, size: 1, coloring: "none" }, line: { color: INK, width: 1.4 },
          showscale: false, hoverinfo: "skip", ncontours: 1 });
      }
      for (const curve of chart.curves) {
        traces.push({ type: "scatter", mode: "lines", x: curve.lambda.map((l) => l * per(main)), y: curve.values, name: safe(curve.kind),
          line: { color: INK, width: 2, dash: curve.kind === "fold" ? "solid" : "dash" }, hovertemplate: `${safe(curve.kind)}<br>%{x:.6g}, %{y:.6g}<extra></extra>` });
      }
      const title = (PARAMETERS[chart.parameter] || safe(chart.parameter.replace(/_/g, " "))) + (chart.unit && chart.unit !== "1" ? `  [${chart.unit}]` : "");
      const layout = { ...baseLayout(frequencyTitle(), title), margin: { l: 68, r: 10, t: 36, b: 48 }, hovermode: "closest" };
      Plotly.react(plot, traces, layout, CONFIG);
      if (plot.hasClick) return;
      plot.hasClick = true;
      plot.on("plotly_click", (event) => {
        const nearest = (list, value) => list.reduce((best, one, i) => Math.abs(one - value) < Math.abs(list[best] - value) ? i : best, 0);
        const row = nearest(chart.values, event.points[0].y), column = nearest(Array.from(chart.lambda, (l) => l * per(main)), event.points[0].x);
        const cell = row * columns + column, at = [0, 1].map((part) => chart.multiplier[2 * cell + part]);
        byId("cell").textContent = `${chart.parameter.replace(/_/g, " ")} = ${show(chart.values[row])}, ` +
          `${show(chart.lambda[column] * per(main))}${unitSuffix() || " Λ"}: ${chart.motions[cell]} motions, ${chart.stable_motions[cell]} of them stable; ` +
          `largest multiplier of the most stable one ${show(at[0], 5)}${at[1] < 0 ? " - " : " + "}${show(Math.abs(at[1]), 5)} i, magnitude ${show(Math.hypot(...at), 5)}.`;
      });
    }
    return draw;
  }

  function runUpView(panel) {
    const plot = make("div", { id: "ramp", class: "plot", role: "img", "aria-label": "Mesh forces of the run-up" });
    plot.style.height = "460px";
    panel.append(make("div", { class: "controls" }, unitChoice("run-up")), plot, make("p", { class: "note" },
      `Smallest to largest force of each mesh in each tooth period of the slowest mesh. ${main.runUp.ended}.`));
    return () => {
      const { lambda, low, high } = main.runUp, meshes = low.shape[1], x = Array.from(lambda, (l) => l * per(main));
      const traces = range(meshes).flatMap((mesh) => [low, high].map((values, place) => ({
        type: "scatter", mode: "lines", x, y: x.map((_, i) => values[i * meshes + mesh]), line: { color: COLORS[mesh % COLORS.length], width: 1 },
        fill: place ? "tonexty" : "none", name: safe(main.meshes[mesh]), showlegend: place === 1,
        hovertemplate: `${safe(main.meshes[mesh])}<br>%{x:.6g}${unitSuffix()}: %{y:.5g} N<extra></extra>`,
      })));
      const layout = { ...baseLayout(frequencyTitle(), "mesh force  [N]"), margin: { l: 68, r: 10, t: 40, b: 48 }, hovermode: "closest",
        showlegend: true, legend: { orientation: "h", y: 1.02, yanchor: "bottom" } };
      Plotly.react(plot, traces, layout, CONFIG);
    };
  }

  function trainView(panel) {
    for (const file of files) {
      if (files.length > 1) panel.append(make("h2", {}, file.name || file.title));
      const source = URL.createObjectURL(new Blob([file.schematic], { type: "image/svg+xml" }));
      panel.append(make("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Drawing of the train" }, make("img", { class: "schematic",
        src: source, alt: `The train: meshes ${file.meshes.join(", ")}; shafts ${file.shafts.join(", ") || "none"}.` })));
      for (const warning of file.warnings) panel.append(make("p", {}, warning));
      panel.append(make("details", { open: files.length === 1 }, make("summary", {}, "Every number of the train"), make("pre", { tabindex: 0 }, file.explanation)));
    }
    return null;
  }

  openTab(views[0][0]);
  document.documentElement.dataset.ready = "yes";
})().catch((error) => {
  const place = document.getElementById("problem");
  place.textContent = `This page could not be drawn: ${error.message}`;
  place.hidden = false;
  throw error;
});
