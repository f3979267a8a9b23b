// The view of a study: parallel coordinates and two quantities over one another, with a point to choose in both.

const SHADES = ["#440154", "#3b528b", "#21918c", "#5ec962", "#d8a800"]; // from dark to light; nothing hangs on hue alone
const AXES_WIDE = 8,
  AXES_NARROW = 4;

function studyView(panel) {
  const study = data.study,
    columns = study.columns;
  // What never changes tells nothing beside the others.
  const telling = range(columns.length).filter((place) => !columns[place].constant || place < study.parameters);
  const onAxes = new Set(telling.slice(0, window.innerWidth < 700 ? AXES_NARROW : AXES_WIDE));
  const outputs = telling.filter((place) => place >= study.parameters);
  const chosen = { x: 0, y: outputs[0] ?? Math.min(1, columns.length - 1), color: outputs[0] ?? 0 };
  const names = columns.map((column, place) => [String(place), column.name]);
  const pick = (words, what) =>
    choice(words, names, String(chosen[what]), (value) => {
      chosen[what] = Number(value);
      draw();
    })[0];
  const boxes = columns.map((column, place) =>
    make(
      "label",
      {},
      make("input", {
        type: "checkbox",
        checked: onAxes.has(place),
        onchange: (event) => {
          onAxes[event.target.checked ? "add" : "delete"](place);
          draw();
        },
      }),
      column.name,
    ),
  );
  const help = "Arrow keys left and right go to the next point, in the order of the study.";
  const parallel = make("div", {
    id: "parallel",
    class: "plot",
    tabindex: 0,
    role: "application",
    "aria-label": `Parallel coordinates of the study. ${help}`,
  });
  const scatter = make("div", {
    id: "scatter",
    class: "plot",
    tabindex: 0,
    role: "application",
    "aria-label": `Two quantities of the study over one another. ${help}`,
  });
  parallel.style.height = scatter.style.height = "420px";
  panel.append(
    make("div", { class: "controls" }, pick("colour", "color"), pick("across", "x"), pick("up", "y")),
    make("details", {}, make("summary", {}, "axes of the parallel coordinates"), make("fieldset", {}, ...boxes)),
    make(
      "ul",
      { class: "key", "aria-label": "Key" },
      ...SHADES.map((shade, place) => {
        const item = make("li");
        const field = `<rect x="1" y="2" width="26" height="10" fill="${shade}"/>`;
        item.innerHTML = `<svg width="28" height="14" aria-hidden="true">${field}</svg>`;
        item.append(place === 0 ? "smallest" : place === SHADES.length - 1 ? "largest of what colours" : "");
        return item;
      }),
    ),
    parallel,
    make(
      "div",
      { class: "columns" },
      scatter,
      make(
        "section",
        { "aria-label": "The chosen point" },
        make("h2", {}, "The chosen point of the study"),
        make("div", { id: "study-facts", "aria-live": "polite" }, make("p", {}, "None yet: click a line or a point.")),
      ),
    ),
    make("p", { class: "note" }, `${help} Each axis goes from its smallest to its largest value.`),
    make(
      "p",
      { class: "note", hidden: !study.leftOut.length },
      `Not on this page, because a point has more than twelve of each: ${study.leftOut.join(", ")}.`,
    ),
  );
  for (const plot of [parallel, scatter]) {
    plot.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      chooseStudy(state.study == null ? 0 : (state.study + step + study.count) % study.count);
    });
  }

  const extent = (values) => {
    let low = Infinity,
      high = -Infinity;
    for (const value of values)
      if (Number.isFinite(value)) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    return [low, high];
  };
  const title = (place) =>
    safe(columns[place].name) + (columns[place].unit && columns[place].unit !== "1" ? `  [${safe(columns[place].unit)}]` : "");
  const share = (place, point, [low, high]) => (high > low ? (columns[place].values[point] - low) / (high - low) : 0.5);

  /** Of each point its shade, by the quantity that colours; null where that is not known. */
  function shades() {
    const ends = extent(columns[chosen.color].values);
    return range(study.count).map((point) => {
      const value = share(chosen.color, point, ends);
      return Number.isFinite(value) ? Math.min(SHADES.length - 1, Math.floor(value * SHADES.length)) : null;
    });
  }

  function draw() {
    const axes = [...onAxes].sort((a, b) => a - b),
      ends = axes.map((place) => extent(columns[place].values)),
      shade = shades();
    const line = (points) => {
      const x = [],
        y = [],
        own = [];
      for (const point of points) {
        axes.forEach((place, i) => {
          x.push(i);
          y.push(share(place, point, ends[i]));
          own.push(point);
        });
        x.push(null);
        y.push(null);
        own.push(null);
      }
      return { x, y: y.map((value) => (Number.isFinite(value) ? value : null)), customdata: own };
    };
    const traces = [null, ...range(SHADES.length)].map((group) => ({
      type: "scatter",
      mode: study.count > 300 ? "lines" : "lines+markers",
      ...line(range(study.count).filter((point) => shade[point] === group)),
      line: { color: group == null ? "#999" : SHADES[group], width: 1.1 },
      marker: { size: 4 },
      opacity: study.count > 300 ? 0.4 : 0.75,
      hovertemplate: "point %{customdata}<extra></extra>",
    }));
    traces.push({
      type: "scatter",
      mode: "lines+markers",
      ...line(state.study == null ? [] : [state.study]),
      line: { color: INK, width: 3.5 },
      marker: { size: 8, color: INK },
      hoverinfo: "skip",
    });
    const layout = { ...baseLayout("", ""), margin: { l: 50, r: 50, t: 40, b: 70 }, hovermode: "closest", hoverdistance: 20 };
    Object.assign(layout.xaxis, {
      tickvals: range(axes.length),
      ticktext: axes.map((place) => wrapped(title(place))),
      range: [-0.25, axes.length - 0.75],
      fixedrange: true,
      showgrid: true,
      gridcolor: "#7a828c",
      showline: false,
      ticks: "",
      title: null,
    });
    Object.assign(layout.yaxis, {
      showticklabels: false,
      range: [-0.09, 1.09],
      fixedrange: true,
      showgrid: false,
      showline: false,
      ticks: "",
      title: null,
    });
    const text = (i, y, value) => ({
      x: i,
      y,
      xref: "x",
      yref: "y",
      text: show(value, 4),
      showarrow: false,
      font: { size: 11 },
      bgcolor: "rgba(255,255,255,.8)",
    });
    layout.annotations = axes.flatMap((_, i) => [text(i, -0.06, ends[i][0]), text(i, 1.06, ends[i][1])]);
    Plotly.react(parallel, traces, layout, { ...config(), displayModeBar: false });
    const known = range(study.count);
    const of = (place) =>
      known.map((point) => {
        const value = columns[place].values[point];
        return Number.isFinite(value) ? value : null;
      });
    const ring =
      state.study != null && [chosen.x, chosen.y].every((place) => Number.isFinite(columns[place].values[state.study]));
    Plotly.react(
      scatter,
      [
        {
          type: "scatter",
          mode: "markers",
          x: of(chosen.x),
          y: of(chosen.y),
          customdata: known,
          marker: {
            color: known.map((point) => (shade[point] == null ? "#999" : SHADES[shade[point]])),
            size: study.count > 500 ? 5 : 8,
            line: { color: "#fff", width: 0.5 },
          },
          hovertemplate: "point %{customdata}<br>%{x:.5g}, %{y:.5g}<extra></extra>",
        },
        {
          type: "scatter",
          mode: "markers",
          x: ring ? [columns[chosen.x].values[state.study]] : [],
          y: ring ? [columns[chosen.y].values[state.study]] : [],
          marker: { symbol: "circle-open", size: 17, line: { width: 3 }, color: INK },
          hoverinfo: "skip",
        },
      ],
      {
        ...baseLayout(title(chosen.x), title(chosen.y)),
        margin: { l: 68, r: 14, t: 36, b: 48 },
        hovermode: "closest",
        uirevision: `${chosen.x} ${chosen.y}`,
      },
      config(),
    );
    for (const plot of [parallel, scatter]) {
      if (plot.hasClick) continue;
      plot.hasClick = true;
      plot.on("plotly_click", (event) => {
        if (event.points[0].customdata != null) chooseStudy(event.points[0].customdata);
      });
    }
  }

  function chooseStudy(point) {
    state.study = point;
    draw();
    const facts = [
      ["point", `${point} of 0 to ${study.count - 1}`],
      ...study.texts.map((text) => [text.name, text.values[point]]),
      ...columns.map((column) => [
        column.name,
        `${show(column.values[point])}${column.unit && column.unit !== "1" ? ` ${column.unit}` : ""}`,
      ]),
    ].filter((row) => row[1] && row[1].trim());
    const file = study.results[point];
    if (file !== undefined) {
      showFiles([data.files[file]]);
      openTab("study");
    }
    byId("study-facts").replaceChildren(
      file === undefined
        ? make("p", { class: "note" }, data.files.length ? "The whole results of this point are not on the page." : "")
        : make(
            "button",
            {
              class: "button",
              type: "button",
              onclick: () => {
                openTab("response");
                byId("curve").focus();
              },
            },
            "its response and motions",
          ),
      make("dl", {}, ...facts.flatMap(([name, words]) => [make("dt", {}, name), make("dd", {}, words)])),
    );
  }
  return draw;
}

/** A name over several lines, at most 14 letters long where it has spaces or underscores. */
function wrapped(text) {
  const lines = [""];
  for (const word of text.split(/(?<=[ _])/)) {
    if ((lines[lines.length - 1] + word).length > 14 && lines[lines.length - 1]) lines.push("");
    lines[lines.length - 1] += word;
  }
  return lines.join("<br>");
}
