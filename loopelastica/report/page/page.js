// The page itself: which loop is shown, what of it, and where all is from.

const run = window.report;
const QUIET = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["tableRotation", "resetCameraLastSave3d"] };
const scenes = new Map(Object.entries(run.scenes));
let table = null;
let now = null;
let asked = 0;

// plotly's script, unpacked once
const plotly = new Promise((resolve, reject) => {
  setTimeout(async () => {
    try {
      const packed = Uint8Array.from(atob(byId("plotly").textContent), (letter) => letter.charCodeAt(0));
      const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
      const script = element("script", {}, await new Response(stream).text());
      document.head.append(script);
      resolve(window.Plotly);
    } catch (error) {
      reject(new Error(`this browser cannot unpack the script that draws (${error.message}); a newer one can`));
    }
  });
});

// what is drawn of a folder: in the page, or in a script beside it
function sceneOf(folder) {
  if (scenes.has(folder)) return Promise.resolve(scenes.get(folder));
  return new Promise((resolve, reject) => {
    const script = element("script", { src: place(folder, run.scene) });
    script.onload = () => {
      scenes.set(folder, window.loopelasticaScene);
      script.remove();
      resolve(scenes.get(folder));
    };
    script.onerror = () => {
      script.remove();
      reject(new Error(`${folder}/${run.scene} is not beside this page, so there is nothing to draw; move the page and the folders together`));
    };
    document.head.append(script);
  });
}

async function choose(index, seen) {
  const row = run.rows[index], mine = ++asked;
  if (!row) return;
  table.mark(index);
  byId("viewer").hidden = false;
  byId("title").textContent = [String(row.file ?? "").split(/[/\\]/).pop(), row.loop].filter(Boolean).join(" · ");
  byId("about").replaceChildren(...describe(row));
  byId("previous").disabled = table.beside(-1) === undefined;
  byId("next").disabled = table.beside(1) === undefined;
  say("loading …");
  if (seen) byId("viewer").scrollIntoView({ block: "start", behavior: "smooth" });
  try {
    if (row.place === null || row.place === undefined) throw new Error("its folder was written without a report; the table has what there is");
    const scene = await sceneOf(row.folder);
    const item = scene.items[row.place];
    if (!item.candidates.length) throw new Error(item.row.reason || "nothing was built");
    if (mine !== asked) return;
    now = { row, item, scene, state: firstState(item) };
    controls();
    await plotly;
    if (mine !== asked) return;
    draw(true);
    say("");
  } catch (error) {
    if (mine !== asked) return;
    now = null;
    for (const name of ["switches", "candidates", "notes"]) byId(name).replaceChildren();
    for (const name of ["scene", "curvature"]) if (window.Plotly) window.Plotly.purge(byId(name));
    say(error.message);
  }
}

const say = (text) => { byId("waiting").textContent = text; };

function describe(row) {
  const parts = [];
  const push = (...more) => { if (parts.length) parts.push(" · "); parts.push(...more); };
  if (row.closing_pair) push(`closing pair ${row.closing_pair}`);
  if (row.sequence) push(element("span", { class: "sequence" }, row.sequence));
  if (row.nucleotides) push(`${row.nucleotides} nucleotides`);
  if (row.folder) push(element("a", { href: place(row.folder, "").replace(/\/$/, "/") }, row.folder));
  return parts;
}

const firstState = (item) => ({
  shown: new Set(item.candidates.slice(0, 1).map((candidate) => candidate.rank)), atoms: new Set(),
  own: true, bonds: false, neighbours: true, labels: true, error: false,
});

function controls() {
  const { item, state } = now;
  const change = (act) => () => { act(); controls(); draw(false); };
  const box = (name, checked, act, id) => element("label", {}, element("input", { type: "checkbox", id, checked, onchange: change(act) }), " " + name);
  const flag = (key, name) => box(name, state[key], () => { state[key] = !state[key]; }, `show-${key}`);
  const focused = document.activeElement && document.activeElement.id;
  byId("switches").replaceChildren(...[
    item.own && flag("own", "the file's own loop"), item.own && item.own.bonds.length > 0 && flag("bonds", "its atoms"),
    item.neighbours.length > 0 && flag("neighbours", "neighbours"), flag("labels", "labels"), flag("error", "expected error as a tube"),
  ].filter(Boolean));
  const toggle = (set, rank) => () => { if (!set.delete(rank)) set.add(rank); };
  const all = () => { state.shown = new Set(state.shown.size === item.candidates.length ? [item.candidates[0].rank] : item.candidates.map((c) => c.rank)); };
  const built = item.candidates.some((candidate) => candidate.atoms);
  const columns = [
    ["shape", "shape", "shape"], ["expected_rmsd_A", "expected error (Å)", "number", expected],
    ["energy_kT", "energy (kT)", "number", energy], ["energy_per_A", "E/K0 (1/Å)", "number", digits(4)],
    ["rmsd_A", "RMSD (Å)", "number", digits(2)], ["touches", "touches", ""],
    ["sound", "atoms", "", (row, value) => element("span", { title: row.why || null }, sound(row, value))],
  ].filter(([key]) => known(item.candidates, key) && !(key === "energy_per_A" && known(item.candidates, "energy_kT")));
  const head = element("tr", {}, element("th", { scope: "col" }, box("show", state.shown.size === item.candidates.length, all, "all")),
    built ? element("th", { scope: "col" }, "sticks") : null,
    ...columns.map(([, name, kind]) => element("th", { class: kind, scope: "col", title: name === "expected error (Å)" ? EXPECTED : null }, name)));
  const body = item.candidates.map((candidate) => element("tr", {},
    element("td", {}, element("label", {},
      element("input", { type: "checkbox", id: `candidate-${candidate.rank}`, checked: state.shown.has(candidate.rank), onchange: change(toggle(state.shown, candidate.rank)) }),
      element("span", { class: "swatch", style: `background:${run.colours.ranks[(candidate.rank - 1) % run.colours.ranks.length]}` }), String(candidate.rank))),
    built ? element("td", {}, candidate.atoms ? element("input", { type: "checkbox", id: `atoms-${candidate.rank}`, "aria-label": `atoms of candidate ${candidate.rank}`, checked: state.atoms.has(candidate.rank), onchange: change(toggle(state.atoms, candidate.rank)) }) : "") : null,
    ...columns.map(([key, , kind, format]) => element("td", { class: kind }, textOf(candidate, key, format)))));
  byId("candidates").replaceChildren(element("table", {}, element("thead", {}, head), element("tbody", {}, ...body)));
  if (focused && byId(focused)) byId(focused).focus();
  notes();
}

function notes() {
  const { row, item, scene } = now;
  const files = (scene.files || []).map((name) => element("a", { href: place(row.folder, name) }, name));
  const remarks = item.remarks.map((sentence) => element("p", { class: "note" }, sentence));
  byId("notes").replaceChildren(...remarks, element("details", {}, element("summary", {}, "files and input"),
    element("p", {}, ...files.flatMap((link, k) => k ? [" · ", link] : [link])),
    facts({ input: row.file, "SHA-256": scene.sha256, version: scene.version })));
}

function draw(fresh) {
  const { item, state } = now, Plotly = window.Plotly, stage = byId("scene");
  const layout = {
    margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, uirevision: asked, paper_bgcolor: "#fff",
    hoverlabel: { align: "left", bgcolor: "#fff", bordercolor: "#8a8f98", font: { color: "#1f2933", size: 13 } },
    scene: fresh || !stage.layout ? outlook(item, stage.clientWidth, stage.clientHeight) : stage.layout.scene,
  };
  const axis = { zeroline: false, gridcolor: "#edf0f3", linecolor: "#c3c8cf", rangemode: "tozero", title: { font: { size: 12 }, standoff: 6 }, automargin: true };
  const flat = {
    margin: { l: 48, r: 8, t: 6, b: 36 }, showlegend: false, font: { size: 11 }, hovermode: "closest",
    xaxis: { ...axis, rangemode: "normal", title: { ...axis.title, text: "nucleotide" }, ...ticks(item) }, yaxis: { ...axis, title: { ...axis.title, text: "curvature (1/Å)" } },
  };
  // another loop is drawn from the start: labels keep the size they had on a scene of another scale
  const put = fresh ? Plotly.newPlot : Plotly.react;
  put(stage, sceneTraces(item, state, run.colours), layout, QUIET);
  Plotly.react(byId("curvature"), curvatureTraces(item, state, run.colours), flat, { ...QUIET, displayModeBar: false });
}

function ticks(item) {
  const step = Math.ceil(item.labels.length / 12), every = (_, k) => k % step === 0;
  return { tickvals: item.labels.map((_, k) => k + 1).filter(every), ticktext: item.labels.map(short).map(plain).filter(every), tickangle: 0 };
}

function facts(values) {
  const known = Object.entries(values).filter(([, value]) => value !== null && value !== undefined && value !== "");
  return element("dl", {}, ...known.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, typeof value === "string" ? value : JSON.stringify(value))]));
}

function head() {
  const files = new Set(run.rows.map((row) => row.file)), word = (count, one) => `${count.toLocaleString("en")} ${one}${count === 1 ? "" : "s"}`;
  byId("heading").textContent = run.folder;
  const failed = run.failures.length ? ` · ${word(run.failures.length, "failure")}` : "";
  byId("summary").textContent = `${word(run.rows.length, what)} of ${word(files.size, "file")}${failed} · ${run.program} · ${run.written}`;
  byId("count").textContent = word(run.rows.length, what);
  byId("bend").textContent = `Curvature along the ${what}`;
}

function foot() {
  if (run.failures.length) {
    byId("failures").hidden = false;
    const rows = run.failures.map(({ file, failure }) => element("tr", {}, element("td", { class: "name" }, file), element("td", { class: "name" }, failure)));
    const names = element("tr", {}, element("th", { scope: "col" }, "file"), element("th", { scope: "col" }, "what failed"));
    byId("failures").replaceChildren(element("h2", {}, `${run.failures.length.toLocaleString("en")} failed`),
      element("div", { class: "scroll" }, element("table", {}, element("thead", {}, names), element("tbody", {}, ...rows))));
  }
  const digests = run.inputs.map(({ file, sha256 }) => element("tr", {}, element("td", { class: "name" }, file), element("td", {}, element("code", {}, sha256))));
  byId("provenance").replaceChildren(element("h2", {}, "Where this is from"),
    facts({ program: run.versions.length ? run.versions.map((version) => `loopelastica ${version}`).join(", ") : run.program, page: `${run.program}, ${run.written}` }),
    ...(Object.keys(run.options).length ? [element("details", {}, element("summary", {}, "options"), facts(run.options))] : []),
    ...(digests.length ? [element("details", {}, element("summary", {}, `SHA-256 of ${digests.length.toLocaleString("en")} input${digests.length === 1 ? "" : "s"}`),
      element("div", { class: "scroll" }, element("table", {}, element("tbody", {}, ...digests))))] : []));
}

head();
foot();
if (run.rows.length) {
  byId("loops").hidden = false;
  table = new Table(run.rows, choose);
  byId("previous").addEventListener("click", () => choose(table.beside(-1)));
  byId("next").addEventListener("click", () => choose(table.beside(1)));
  const drawable = run.rows.findIndex((row) => row.candidates);
  choose(Math.max(drawable, 0));
}
