// What is on the page: its head, a tab for each view, and how it begins.

const views = []; // of each its name, and what draws it when it is shown, and again after a change of units

/** Shows files, the first and one to compare: their views, after that of the study where there is one. */
function showFiles(list) {
  files = list;
  main = files[0];
  files.forEach((file, number) =>
    file.series.forEach((series, place) =>
      Object.assign(series, { file: number, place, across: series.across || series.lambda }),
    ),
  );
  state.chosen = null;
  if (main) state.quantity ??= main.first;
  if (main && !files.every((file) => file.perLambda[state.unit])) {
    state.unit = files.every((file) => file.perLambda[main.unit]) ? main.unit : "Lambda";
  }
  tellWhat();
  for (const { id } of views.filter((view) => view.id !== "study"))
    for (const part of ["tab", "view"]) byId(`${part}-${id}`).remove();
  views.length = byId("view-study") ? 1 : 0;
  const wanted = [
    ["study", "Study", data.study && !views.length, studyView],
    ["response", "Response", main?.series.length, responseView],
    ["map", main?.map ? "Stability map" : "Curves", main?.map || main?.loci.length, mapView],
    ["tables", "Tables", main?.tables.length, tablesView],
    ["run-up", "Run-up", main?.runUp, runUpView],
    ["train", "Train", main, trainView],
  ];
  for (const [id, words, there, build] of wanted) {
    if (!there) continue;
    byId("tabs").append(
      make(
        "button",
        {
          role: "tab",
          id: `tab-${id}`,
          "aria-controls": `view-${id}`,
          type: "button",
          onclick: () => openTab(id),
          onkeydown: tabKeys,
        },
        words,
      ),
    );
    const panel = make("section", { role: "tabpanel", id: `view-${id}`, "aria-labelledby": `tab-${id}`, hidden: true });
    byId("views").append(panel);
    views.push({ id, draw: build(panel) });
  }
}

/** The head of the page. */
function tellWhat() {
  byId("title").textContent = data.study?.title || main?.title || (data.study ? "Study" : "Gear train");
  const told = files.map((file, number) => {
    const name = files.length > 1 ? `${number ? "pale" : "dark"}: ${file.name}, ` : data.study ? `${file.name}: ` : "";
    return (
      name +
      Object.entries(KINDS)
        .map(([kind, words]) => {
          const own = file.series.filter((series) => series.kind === kind),
            points = own.reduce((sum, series) => sum + series.count, 0);
          const branches = own.length > 1 ? `${own.length} branches, ` : "",
            ended = kind === "response" ? `; ${own[0]?.ended}` : "";
          return (
            own.length &&
            `${words} (${branches}${points} ${isBranch(own[0]) ? "point" : "motion"}${points === 1 ? "" : "s"}${ended})`
          );
        })
        .filter(Boolean)
        .join(", ")
    );
  });
  const lengths = files.map((file) => file.length);
  if (Math.max(...lengths) > 1.000001 * Math.min(...lengths)) {
    told.push(
      `Displacements of the two are over lengths of their own, ${lengths.map((length) => show(length)).join(" and ")} m`,
    );
  }
  byId("about").textContent = [...(data.study ? [data.study.about] : []), ...told, ...files.flatMap((file) => file.notes)]
    .filter(Boolean)
    .map((sentence) => `${sentence}.`)
    .join(" ");
}

function openTab(id) {
  for (const { id: other } of views) {
    const own = other === id,
      tab = byId(`tab-${other}`);
    tab.setAttribute("aria-selected", own);
    tab.tabIndex = own ? 0 : -1;
    byId(`view-${other}`).hidden = !own;
  }
  state.tab = id;
  redraw();
}

/** Draws the open view. */
function redraw() {
  views.find((view) => view.id === state.tab).draw?.();
}

function tabKeys(event) {
  const place = views.findIndex((view) => view.id === state.tab);
  const next = { ArrowRight: place + 1, ArrowLeft: place - 1, Home: 0, End: views.length - 1 }[event.key];
  if (next === undefined) return;
  event.preventDefault();
  const { id } = views[(next + views.length) % views.length];
  openTab(id);
  byId(`tab-${id}`).focus();
}

/** The choice of the unit of frequencies, in every view that has one. */
function unitChoice(where) {
  // Where Lambda is the speed in rpm it is not offered twice.
  const same = files.every((file) => file.perLambda.rpm && Math.abs(file.perLambda.rpm - 1) < 1e-9);
  const units = ["Lambda", "rpm", "Hz"].filter(
    (unit) => files.every((file) => file.perLambda[unit]) && !(same && unit === "Lambda"),
  );
  return make(
    "fieldset",
    {},
    make("legend", {}, "frequency"),
    ...units.map((unit) => {
      const input = make("input", {
        type: "radio",
        name: `unit-${where}`,
        value: unit,
        checked: unit === state.unit,
        onchange: () => {
          state.unit = unit;
          document.querySelectorAll(`input[type=radio][value="${unit}"]`).forEach((other) => {
            other.checked = true;
          });
          redraw();
        },
      });
      return make("label", {}, input, unit === "Lambda" ? "Λ" : unit);
    }),
  );
}

/** A choice of one of `[value, text]`, with its label; both the label and the choice itself. */
function choice(words, options, value, change) {
  const select = make("select", { onchange: () => change(select.value) });
  for (const [option, text] of options) select.append(make("option", { value: option, selected: option === value }, text));
  return [make("label", {}, words, select), select];
}

function tellProblem(text) {
  byId("problem").textContent = text;
  byId("problem").hidden = false;
}

async function begin() {
  if (!("DecompressionStream" in window)) {
    tellProblem("This browser is too old to unpack the page: it takes Chrome or Edge 80, Safari 16.4, Firefox 113, or later.");
    return;
  }
  const [library] = await unpack("plotly");
  const script = document.createElement("script");
  script.textContent = library;
  document.head.append(script);
  const [told, get] = await unpack("data");
  unpackAll(told, get);
  data = told;
  byId("footer").textContent = `Made by geartrain ${data.version}. Drawn with plotly.js. This file needs no network.`;
  showFiles(data.study ? data.files.slice(0, 1) : data.files);
  openTab(views[0].id);
  document.documentElement.dataset.ready = "yes";
}

begin().catch((error) => {
  tellProblem(`This page could not be drawn: ${error.message}`);
  throw error;
});
