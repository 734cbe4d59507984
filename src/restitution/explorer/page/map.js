// The plane of the paper's Figures 3 and 4: isolines of e over p2 and p3, shaded.
import { colours } from "./theme.js";

const P2 = logspace(-3, 1, 81);
export const P3 = logspace(-2, 2, 81);
const FEWEST = 6;
const LEVELS = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95];

export function logspace(low, high, count) {
  return Float64Array.from({ length: count }, (_, n) => Math.pow(10, low + ((high - low) * n) / (count - 1)));
}

// Isolines and shades on the plane at one Poisson ratio; the last few are kept.
const kept = new Map();

function plane(paper, nu, levels) {
  const { "map-low": low, "map-high": high } = colours();
  const key = [nu, low, high, levels].join();
  if (!kept.has(key)) {
    if (kept.size > 12) kept.delete(kept.keys().next().value);
    const values = paper.map(nu, P2, P3);
    kept.set(key, { curves: isolines(values, levels), image: shade(values, low, high), values });
  }
  return kept.get(key);
}

function isolines(values, levels) {
  return levels.flatMap((level) => chains(values, level).map(({ x, y }) => ({ x, y, level }))).map(({ x, y, level }, n, all) => {
    const longest = all.filter((one) => one.level === level).every((one) => one.x.length <= x.length);
    return { x, y, colour: "ink", width: 1.1, letter: longest && x.length > 12 ? String(level) : undefined };
  });
}

// The segments of marching squares, joined to chains.
function chains(values, level) {
  const ends = new Map();
  const points = new Map();
  const link = (a, b) => {
    for (const [from, to] of [[a, b], [b, a]]) ends.set(from, [...(ends.get(from) ?? []), to]);
  };
  const [across, up] = [P2.length, P3.length];
  const cut = (i, j, k, l) => {
    const [from, to] = [values[j * across + i], values[l * across + k]];
    if ((from < level) === (to < level)) return null;
    const name = (j * across + i) * 2 + (l > j ? 1 : 0);
    const share = (level - from) / (to - from);
    points.set(name, [P2[i] * Math.pow(P2[k] / P2[i], share), P3[j] * Math.pow(P3[l] / P3[j], share)]);
    return name;
  };
  for (let j = 0; j + 1 < up; j++) {
    for (let i = 0; i + 1 < across; i++) {
      const found = [cut(i, j, i + 1, j), cut(i, j, i, j + 1), cut(i, j + 1, i + 1, j + 1), cut(i + 1, j, i + 1, j + 1)].filter((one) => one !== null);
      for (let n = 0; n + 1 < found.length; n += 2) link(found[n], found[n + 1]);
    }
  }
  const made = [];
  const used = new Set();
  const starts = [...ends.keys()].sort((a, b) => ends.get(a).length - ends.get(b).length);
  for (const start of starts) {
    if (used.has(start)) continue;
    const chain = [];
    let here = start;
    while (here !== undefined && !used.has(here)) {
      used.add(here);
      chain.push(points.get(here));
      here = ends.get(here).find((one) => !used.has(one));
    }
    // A piece of a few cells of the plane is no line that a reader could follow.
    if (chain.length > FEWEST) made.push({ x: chain.map(([x]) => x), y: chain.map(([, y]) => y) });
  }
  return made;
}

// The plane as a picture, from one colour at e = 0 to another at e = 1.
function shade(values, ...ends) {
  const [low, high] = ends.map(channels);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [P2.length, P3.length];
  const ctx = canvas.getContext("2d");
  const image = ctx.createImageData(P2.length, P3.length);
  for (let j = 0; j < P3.length; j++) {
    for (let i = 0; i < P2.length; i++) {
      const e = values[j * P2.length + i];
      const place = 4 * ((P3.length - 1 - j) * P2.length + i);
      low.forEach((from, n) => {
        image.data[place + n] = from + (high[n] - from) * e;
      });
      image.data[place + 3] = Number.isFinite(e) ? 255 : 0;
    }
  }
  ctx.putImageData(image, 0, 0);
  return canvas;
}

const channels = (colour) => colour.match(/\d+/g).slice(0, 3).map(Number);

// What a panel draws: the plane at this Poisson ratio, and the present point if it is on the plane.
export function planePicture(paper, nu, marks = [], levels = LEVELS) {
  const { curves, image, values } = plane(paper, nu, levels);
  const edge = (1 - 2 * nu) / (3 * nu);
  const dots = nu > 0 && edge > P2[0] && edge < P2.at(-1) ? [{ x: edge, label: "ν₀ < 0 to the left" }] : [];
  return {
    curves,
    bands: { image },
    marks: [...dots, ...marks],
    x: { label: "p₂ = G∞/G₁", short: "p₂", log: true },
    y: { label: "p₃", log: true },
    columns: () => [
      { name: "p2", unit: "", values: Array.from(values, (_, n) => P2[n % P2.length]) },
      { name: "p3", unit: "", values: Array.from(values, (_, n) => P3[Math.floor(n / P2.length)]) },
      { name: `e at nu = ${nu}`, unit: "", values: [...values] },
    ],
    ranges: { x: [P2[0], P2.at(-1)], y: [P3[0], P3.at(-1)] },
  };
}
