"use strict";
// Elements, cells and the table of all loops. What comes from files is always text, never markup.

function element(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

const byId = (name) => document.getElementById(name);
const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
const digits = (count) => (row, value) => isNumber(value) ? value.toFixed(count) : "";
const place = (folder, file) => (folder ? encodeURIComponent(folder) + "/" : "") + encodeURIComponent(file);

function expected(row) {
  if (!isNumber(row.expected_rmsd_A)) return "";
  const [low, middle, high] = [row.expected_10_A, row.expected_rmsd_A, row.expected_90_A];
  return `${middle.toFixed(1)} (${low.toFixed(1)}–${high.toFixed(1)})`;
}

function energy(row, value) {
  if (!isNumber(value)) return "";
  return value !== 0 && Math.abs(value) < 0.01 ? value.toExponential(1) : value.toFixed(2);
}

function sound(row, value) {
  const text = String(value).toLowerCase();
  return text === "true" ? "sound" : text === "false" ? "not sound" : "";
}

const what = window.report.rows.some((row) => row.status) ? "strand" : "loop";
const EXPECTED = "The median of the error to expect of the trace, and the range of 80 % of cases, Å";
// key, heading, class, text of a cell, what the heading means
const COLUMNS = [
  ["file", "file", "name"],
  ["model", "model", "number"],
  ["loop", what, "name"],
  ["closing_pair", "closing pair", "name"],
  ["sequence", "sequence", "sequence"],
  ["nucleotides", "nt", "number"],
  ["status", "status", ""],
  ["shape", "first shape", "shape"],
  ["energy_kT", "energy (kT)", "number", energy, "Energy of deformation of the first shape"],
  ["energy_per_A", "E/K0 (1/Å)", "number", digits(4), "Elastic energy over the bending rigidity"],
  ["expected_rmsd_A", "expected error (Å)", "number", expected, EXPECTED],
  ["rmsd_A", "RMSD (Å)", "number", digits(2), "Trace against the file's own loop, not superposed"],
  ["sound", "atoms", "", sound, "Whether the chemistry of the first candidate's atoms is right"],
  ["folder", "folder", "name", (row, value) => value &&
    element("a", { href: encodeURIComponent(value) + "/", onclick: (event) => event.stopPropagation() }, value)],
];

const textOf = (row, key, format) => {
  const value = row[key];
  if (format) return format(row, value) ?? "";
  return value === null || value === undefined ? "" : String(value);
};

const known = (rows, key) => rows.some((row) => row[key] !== null && row[key] !== undefined && row[key] !== "");

function used(rows) {
  return COLUMNS.filter(([key]) => {
    if (key === "model") return new Set(rows.map((row) => row.model)).size > 1;
    return known(rows, key);
  });
}

class Table {
  constructor(rows, choose) {
    this.rows = rows.map((row, index) => ({ row, index }));
    this.choose = choose;
    this.columns = used(rows);
    this.sorted = { key: null, down: false };
    this.size = 50;
    this.page = 0;
    this.chosen = -1;
    this.words = "";
    this.shown = this.rows;
    // what the filter looks at
    this.texts = rows.map((row) => ["file", "loop", "closing_pair", "sequence", "shape", "status", "folder"]
      .map((key) => row[key] ?? "").join("\n").toLowerCase());
    byId("filter").addEventListener("input", (event) => this.filter(event.target.value));
    this.draw();
  }

  filter(text) {
    this.words = text.toLowerCase().split(/\s+/).filter(Boolean);
    this.page = 0;
    this.arrange();
  }

  sort(key) {
    this.sorted = { key, down: this.sorted.key === key && !this.sorted.down };
    this.page = 0;
    this.arrange();
  }

  arrange() {
    const words = this.words || [];
    this.shown = this.rows.filter(({ index }) => words.every((word) => this.texts[index].includes(word)));
    const { key, down } = this.sorted;
    if (key) {
      const order = new Intl.Collator("en", { numeric: true });
      const there = (value) => value !== null && value !== undefined && value !== "";
      this.shown.sort((one, other) => {
        const [a, b] = [one.row[key], other.row[key]];
        // what is unknown comes last, whichever way
        if (!there(a) || !there(b)) return there(b) - there(a);
        const way = isNumber(a) && isNumber(b) ? a - b : order.compare(String(a), String(b));
        return down ? -way : way;
      });
    }
    this.draw();
  }

  // the loop beside the chosen one, in the order that is shown
  beside(step) {
    const here = this.shown.findIndex(({ index }) => index === this.chosen);
    return this.shown[here + step]?.index;
  }

  mark(index) {
    this.chosen = index;
    const here = this.shown.findIndex((one) => one.index === index);
    if (here >= 0) this.page = Math.floor(here / this.size);
    this.draw();
  }

  draw() {
    const head = element("tr", {}, ...this.columns.map(([key, name, kind, , title]) => element("th", {
      class: kind, title, scope: "col",
      "aria-sort": this.sorted.key === key ? (this.sorted.down ? "descending" : "ascending") : null,
    }, element("button", { type: "button", "data-key": key, onclick: () => this.sort(key) }, name))));
    const first = this.page * this.size;
    const body = this.shown.slice(first, first + this.size).map(({ row, index }) => element("tr", {
      tabindex: 0, class: index === this.chosen ? "chosen" : null, "data-index": index,
      onclick: () => this.choose(index, true),
      onkeydown: (event) => { if (event.key === "Enter") this.choose(index, true); },
    }, ...this.columns.map(([key, , kind, format]) => element("td", { class: kind }, textOf(row, key, format)))));
    byId("table").replaceChildren(element("table", {}, element("thead", {}, head), element("tbody", {}, ...body)));
    this.turn(first, body.length);
  }

  turn(first, count) {
    const total = this.shown.length, pages = Math.ceil(total / this.size);
    if (pages < 2) {
      byId("pages").replaceChildren(...(total ? [] : [element("p", { class: "note" }, "nothing matches")]));
      return;
    }
    const go = (to) => () => { this.page = to; this.draw(); };
    byId("pages").replaceChildren(
      element("button", { type: "button", disabled: this.page === 0, onclick: go(this.page - 1) }, "‹ previous 50"),
      element("span", { class: "note" }, `${first + 1}–${first + count} of ${total.toLocaleString("en")}`),
      element("button", { type: "button", disabled: this.page >= pages - 1, onclick: go(this.page + 1) }, "next 50 ›"),
    );
  }
}
