// What plotly draws of a loop: tubes, sticks, labels, the camera, and curvature.

const add = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
const minus = (a, b) => add(a, b, -1);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.sqrt(dot(a, a));
const unit = (a) => { const size = length(a); return size > 1e-9 ? a.map((x) => x / size) : [0, 0, 0]; };
const mean = (points) => points.reduce((sum, p) => add(sum, p), [0, 0, 0]).map((x) => x / points.length);
const across = (a) => unit(cross(a, Math.abs(a[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0]));

function points(flat) {
  const out = [];
  for (let k = 0; k + 2 < flat.length; k += 3) out.push([flat[k], flat[k + 1], flat[k + 2]]);
  return out;
}

// a smooth curve through points (Catmull and Rom), to be drawn as a tube
function smooth(path, steps = 6) {
  if (path.length < 3) return path;
  const at = (k) => path[Math.min(Math.max(k, 0), path.length - 1)];
  const out = [];
  for (let k = 0; k < path.length - 1; k++) {
    for (let s = 0; s < steps; s++) {
      const t = s / steps, [a, b, c, d] = [at(k - 1), at(k), at(k + 1), at(k + 2)];
      out.push(b.map((_, i) => 0.5 * (2 * b[i] + (c[i] - a[i]) * t + (2 * a[i] - 5 * b[i] + 4 * c[i] - d[i]) * t * t
        + (3 * b[i] - a[i] - 3 * c[i] + d[i]) * t * t * t)));
    }
  }
  return [...out, path[path.length - 1]];
}

// a mesh of tubes and beads, with a text for each vertex
class Mesh {
  constructor() {
    [this.x, this.y, this.z, this.i, this.j, this.k, this.text] = [[], [], [], [], [], [], []];
  }

  vertex(p, text) {
    this.x.push(p[0]); this.y.push(p[1]); this.z.push(p[2]); this.text.push(text);
    return this.x.length - 1;
  }

  triangle(a, b, c) { this.i.push(a); this.j.push(b); this.k.push(c); }

  tube(path, radius, text, sides = 14) {
    path = path.filter((p, n) => n === 0 || length(minus(p, path[n - 1])) > 1e-4);
    if (path.length < 2) return this;
    let side = null, last = null;
    path.forEach((p, n) => {
      const along = unit(minus(path[Math.min(n + 1, path.length - 1)], path[Math.max(n - 1, 0)]));
      // the frame is carried along the line: a tube without twist
      side = side === null ? across(along) : unit(minus(side, along.map((x) => x * dot(side, along))));
      const other = cross(along, side), ring = [];
      for (let s = 0; s < sides; s++) {
        const angle = 2 * Math.PI * s / sides;
        ring.push(this.vertex(add(add(p, side, radius * Math.cos(angle)), other, radius * Math.sin(angle)), text(n, path.length)));
      }
      if (last) for (let s = 0; s < sides; s++) {
        const t = (s + 1) % sides;
        this.triangle(last[s], last[t], ring[s]);
        this.triangle(last[t], ring[t], ring[s]);
      }
      last = ring;
      if (n === 0 || n === path.length - 1) {
        const middle = this.vertex(p, text(n, path.length));
        for (let s = 0; s < sides; s++) this.triangle(middle, ring[s], ring[(s + 1) % sides]);
      }
    });
    return this;
  }

  bead(p, radius, text, rows = 8, sides = 14) {
    const rings = [];
    for (let r = 0; r <= rows; r++) {
      const height = Math.cos(Math.PI * r / rows), wide = Math.sin(Math.PI * r / rows), ring = [];
      for (let s = 0; s < sides; s++) {
        const angle = 2 * Math.PI * s / sides;
        ring.push(this.vertex(add(p, [wide * Math.cos(angle), wide * Math.sin(angle), height], radius), text));
      }
      rings.push(ring);
    }
    for (let r = 0; r < rows; r++) for (let s = 0; s < sides; s++) {
      const t = (s + 1) % sides;
      this.triangle(rings[r][s], rings[r][t], rings[r + 1][s]);
      this.triangle(rings[r][t], rings[r + 1][t], rings[r + 1][s]);
    }
    return this;
  }

  trace(name, colour, opacity = 1) {
    const { x, y, z, i, j, k, text } = this;
    const silent = opacity < 1 || !text.some(Boolean);
    return {
      type: "mesh3d", name, x, y, z, i, j, k, color: colour, opacity, flatshading: false,
      hoverinfo: silent ? "skip" : "text", hovertext: silent ? undefined : text,
      lighting: { ambient: 0.62, diffuse: 0.55, specular: 0.12, roughness: 0.7, fresnel: 0.05 },
      lightposition: { x: 4000, y: 6000, z: 9000 },
    };
  }
}

function lines(name, pairs, colour, width, more = {}) {
  const x = [], y = [], z = [];
  for (const pair of pairs) {
    for (const p of pair) { x.push(p[0]); y.push(p[1]); z.push(p[2]); }
    x.push(null); y.push(null); z.push(null);
  }
  return { type: "scatter3d", mode: "lines", name, x, y, z, line: { color: colour, width }, hoverinfo: "skip", ...more };
}

function bonds(flat) {
  const ends = points(flat), pairs = [];
  for (let k = 0; k + 1 < ends.length; k += 2) pairs.push([ends[k], ends[k + 1]]);
  return pairs;
}

// carbon has the colour of its candidate
const ELEMENTS = { N: "#3f5fd0", O: "#d7362c", P: "#e08a1e", S: "#c9a800" };

function atomTraces(item, candidate, colour) {
  const { elements, names, residues, bonds: flat, points: places } = candidate.atoms, at = points(places);
  const x = [], y = [], z = [], colours = [];
  const shade = (k) => ELEMENTS[elements[k]] || colour;
  for (let k = 0; k + 1 < flat.length; k += 2) {
    const [a, b] = [flat[k], flat[k + 1]], middle = at[a].map((value, i) => 0.5 * (value + at[b][i]));
    for (const [p, tint] of [[at[a], shade(a)], [middle, shade(a)], [middle, shade(b)], [at[b], shade(b)], [null, shade(b)]]) {
      x.push(p && p[0]); y.push(p && p[1]); z.push(p && p[2]); colours.push(tint);
    }
  }
  const label = (k) => `${residueLabel(item, residues[k])} ${names[k]}`.trim();
  return [
    { type: "scatter3d", mode: "lines", name: `atoms ${candidate.rank}`, x, y, z, line: { color: colours, width: 6 }, hoverinfo: "skip" },
    {
      type: "scatter3d", mode: "markers", name: `atoms ${candidate.rank}`, x: at.map((p) => p[0]), y: at.map((p) => p[1]), z: at.map((p) => p[2]),
      marker: { size: 3.2, color: at.map((_, k) => shade(k)), line: { width: 0 } }, hoverinfo: "text",
      hovertext: at.map((_, k) => plain(`${label(k)}<br>candidate ${candidate.rank}${errorText(candidate)}`)),
    },
  ];
}

function residueLabel(item, k) {
  const n = item.labels.length, [five, three] = item.strands.map((strand) => strand.labels);
  if (k < 0) return five[five.length + k] ?? "";
  return k < n ? item.labels[k] : three[k - n] ?? "";
}

// plotly reads markup in its texts: what is from files gets a sign that looks alike, line breaks are ours
const plain = (text) => text.replaceAll("<br>", "\n").replaceAll("<", "‹").replaceAll("\n", "<br>");
const errorText = (candidate) => isNumber(candidate.expected_rmsd_A) ? `<br>expected error ${expected(candidate)} Å` : "";

function candidateTrace(item, candidate, colour, first) {
  const line = points(candidate.line), beads = points(candidate.trace);
  const what = `<br>candidate ${candidate.rank}: ${candidate.shape}${errorText(candidate)}`;
  const texts = item.labels.map((label) => plain(label + what));
  const nearest = line.map((p) => {
    const far = beads.map((bead) => length(minus(p, bead)));
    return texts[far.indexOf(Math.min(...far))] ?? "";
  });
  const [five, three] = item.strands.map((strand) => points(strand.points));
  // joined to the stem: from the closing nucleotide to the other one
  const before = five.slice(-1), after = three.slice(0, 1);
  const path = [...before, ...line, ...after];
  const mesh = new Mesh().tube(path, first ? 0.5 : 0.34,
    (n) => nearest[Math.min(Math.max(n - before.length, 0), line.length - 1)]);
  beads.forEach((bead, k) => mesh.bead(bead, first ? 0.9 : 0.65, texts[k]));
  return mesh.trace(`candidate ${candidate.rank}`, colour);
}

function errorTrace(candidate, colour) {
  return new Mesh().tube(points(candidate.line), Math.max(candidate.expected_rmsd_A, 0.1), () => "", 20)
    .trace("expected error", colour, 0.16);
}

function stemTraces(item, colours) {
  const traces = [], [five, three] = item.strands;
  const mesh = new Mesh();
  for (const strand of item.strands) {
    const path = points(strand.points), texts = strand.labels.map(plain);
    mesh.tube(smooth(path), 0.42, (n, count) => texts[Math.round(n / Math.max(count - 1, 1) * (texts.length - 1))]);
    path.forEach((p, k) => mesh.bead(p, 0.6, texts[k], 6, 10));
  }
  if (mesh.x.length) traces.push(mesh.trace("stem", colours.stem));
  if (item.stem.length) traces.push(lines("stem atoms", bonds(item.stem), colours.stem, 2.5));
  if (item.paired) {
    const [a, b] = [points(five.points), points(three.points)], count = Math.min(a.length, b.length);
    const rungs = Array.from({ length: count }, (_, k) => [a[a.length - 1 - k], b[k]]);
    traces.push(lines("pairs", rungs, colours.stem, 2, { line: { color: colours.stem, width: 2, dash: "dot" } }));
  }
  return traces;
}

function neighbourTraces(item, colours) {
  const traces = [lines("neighbours", item.neighbours.map((chain) => points(chain.points)), colours.neighbour, 3)];
  const all = item.neighbours.flatMap((chain) => points(chain.points));
  const labels = item.neighbours.flatMap((chain) => chain.labels);
  traces.push({
    type: "scatter3d", mode: "markers", name: "neighbours", x: all.map((p) => p[0]), y: all.map((p) => p[1]), z: all.map((p) => p[2]),
    marker: { size: 2.6, color: colours.neighbour }, hoverinfo: "text", hovertext: labels.map(plain),
  });
  return traces;
}

// without the chain, which the heading has
const short = (label) => label.replace(/^.*\./, "");

function labelTrace(item, candidate, colours) {
  const at = [], texts = [];
  const put = (p, from, text) => { at.push(add(p, unit(minus(p, from)), 3)); texts.push(plain(text)); };
  const [five, three] = item.strands;
  const ends = [points(five.points), points(three.points)];
  if (candidate) {
    const beads = points(candidate.trace), centre = mean([...beads, ...ends[0].slice(-1), ...ends[1].slice(0, 1)]);
    beads.forEach((bead, k) => put(bead, centre, short(item.labels[k] ?? "")));
  }
  const middle = ends.flat().length ? mean(ends.flat()) : null;
  if (ends[0].length) {
    put(ends[0].at(-1), ends[1][0] ?? middle, short(five.labels.at(-1)));
    if (ends[0].length > 1) put(ends[0][0], ends[0][1], "5′");
  }
  if (ends[1].length) {
    put(ends[1][0], ends[0].at(-1) ?? middle, short(three.labels[0]));
    if (ends[1].length > 1) put(ends[1].at(-1), ends[1].at(-2), "3′");
  }
  return {
    type: "scatter3d", mode: "text", name: "labels", x: at.map((p) => p[0]), y: at.map((p) => p[1]), z: at.map((p) => p[2]),
    text: texts, textfont: { size: 12, color: colours.native }, hoverinfo: "skip",
  };
}

// a cube around the loop, seen so that the stem stands below it
function outlook(item, wide, high) {
  const strands = item.strands.flatMap((strand) => points(strand.points));
  const loops = item.candidates.slice(0, 1).flatMap((candidate) => points(candidate.line));
  const own = item.own ? points(item.own.line) : [];
  const all = [...strands, ...loops, ...own];
  if (!all.length) all.push([0, 0, 0]);
  const top = loops.length ? mean(loops) : mean(all), below = strands.length ? mean(strands) : mean(all);
  let up = unit(minus(top, below));
  if (length(up) < 0.5) up = [0, 0, 1];
  const [five, three] = item.strands.map((strand) => points(strand.points));
  const chord = five.length && three.length ? minus(three[0], five.at(-1)) : across(up);
  let right = unit(minus(chord, up.map((x) => x * dot(chord, up))));
  if (length(right) < 0.5) right = across(up);
  const towards = cross(right, up);
  const spans = [right, up, towards].map((axis) => {
    const along = all.map((p) => dot(p, axis));
    return [Math.min(...along), Math.max(...along)];
  });
  const centre = [right, up, towards].reduce((sum, axis, k) => add(sum, axis, 0.5 * (spans[k][0] + spans[k][1])), [0, 0, 0]);
  const [w, h] = spans.map(([low, high]) => 0.5 * (high - low) + 6.5);
  const half = Math.max(...all.map((p) => length(minus(p, centre)))) + 13;
  // how much of the cube is to be seen decides how far away the eye is
  const far = 2.6 * Math.max(h, w * high / Math.max(wide, 1)) / (2 * half);
  const range = (k) => ({ visible: false, showspikes: false, range: [centre[k] - half, centre[k] + half] });
  return {
    xaxis: range(0), yaxis: range(1), zaxis: range(2), aspectmode: "manual", aspectratio: { x: 1, y: 1, z: 1 },
    dragmode: "orbit", camera: {
      eye: vector(towards.map((x) => x * far)), up: vector(up), center: vector([0, 0, 0]), projection: { type: "perspective" },
    },
  };
}

const vector = ([x, y, z]) => ({ x, y, z });

function sceneTraces(item, state, colours) {
  const colour = (candidate) => colours.ranks[(candidate.rank - 1) % colours.ranks.length];
  const shown = item.candidates.filter((candidate) => state.shown.has(candidate.rank));
  const traces = stemTraces(item, colours);
  if (state.neighbours && item.neighbours.length) traces.push(...neighbourTraces(item, colours));
  if (item.own && state.own) {
    const text = plain("the file's own loop");
    const ends = [item.strands[0].points.slice(-3), item.strands[1].points.slice(0, 3)].map(points);
    const path = [...ends[0], ...points(item.own.line), ...ends[1]];
    traces.push(new Mesh().tube(path, 0.3, () => text, 10).trace("own loop", colours.native));
  }
  if (item.own && state.bonds) traces.push(lines("own atoms", bonds(item.own.bonds), colours.native, 3));
  for (const candidate of shown) traces.push(candidateTrace(item, candidate, colour(candidate), candidate === item.candidates[0]));
  for (const candidate of item.candidates) {
    if (candidate.atoms && state.atoms.has(candidate.rank)) traces.push(...atomTraces(item, candidate, colour(candidate)));
  }
  if (state.error && shown.length) traces.push(errorTrace(shown[0], colour(shown[0])));
  if (state.labels) traces.push(labelTrace(item, shown[0], colours));
  return traces;
}

function curvatureTraces(item, state, colours) {
  const shown = item.candidates.filter((candidate) => state.shown.has(candidate.rank)).reverse();
  const own = item.own && state.own ? [{
    type: "scatter", mode: "lines", name: "own loop", x: item.own.phases, y: item.own.curvature,
    line: { color: colours.native, width: 1.5, dash: "dash" }, hovertemplate: "the file's own loop: %{y:.3f} 1/Å<extra></extra>",
  }] : [];
  return own.concat(shown.map((candidate) => ({
    type: "scatter", mode: "lines", name: `candidate ${candidate.rank}`, x: candidate.phases, y: candidate.curvature,
    line: { color: colours.ranks[(candidate.rank - 1) % colours.ranks.length], width: candidate === item.candidates[0] ? 2.5 : 1.5 },
    hovertemplate: `candidate ${candidate.rank}: %{y:.3f} 1/Å<extra></extra>`,
  })));
}
