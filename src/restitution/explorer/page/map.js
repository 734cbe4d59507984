// The plane of the paper's Figures 3 and 4: isolines of e over p2 and p3, shaded.
import { colours } from "./theme.js";

const POINTS = 81;
const FEWEST = 6;
const LEVELS = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95];

export function logspace([low, high], count) {
  return Float64Array.from({ length: count }, (_, n) => (n + 1 < count ? low * Math.pow(high / low, n / (count - 1)) : high));
}

// Isolines and shades on the plane at one Poisson ratio; the last few are kept.
const kept = new Map();

function plane(paper, nu, levels) {
  const { "map-low": low, "map-high": high } = colours();
  const key = [nu, low, high, levels].join();
  if (!kept.has(key)) {
    if (kept.size > 12) kept.delete(kept.keys().next().value);
    const { p2, p3 } = paper.about;
    const [across, up] = [logspace(p2, POINTS), logspace(p3, POINTS)];
    const values = paper.map(nu, across, up);
    kept.set(key, { curves: isolines(across, up, values, levels), image: shade(values, low, high), across, up, values });
  }
  return kept.get(key);
}

function isolines(p2, p3, values, levels) {
  return levels.flatMap((level) => chains(p2, p3, values, level).map(({ x, y }) => ({ x, y, level }))).map(({ x, y, level }, n, all) => {
    const longest = all.filter((one) => one.level === level).every((one) => one.x.length <= x.length);
    return { x, y, colour: "ink", width: 1.1, letter: longest && x.length > 12 ? String(level) : undefined };
  });
}

// The segments of marching squares, joined to chains.
function chains(p2, p3, values, level) {
  const ends = new Map();
  const points = new Map();
  const link = (a, b) => {
    for (const [from, to] of [[a, b], [b, a]]) ends.set(from, [...(ends.get(from) ?? []), to]);
  };
  const [across, up] = [p2.length, p3.length];
  const cut = (i, j, k, l) => {
    const [from, to] = [values[j * across + i], values[l * across + k]];
    if ((from < level) === (to < level)) return null;
    const name = (j * across + i) * 2 + (l > j ? 1 : 0);
    const share = (level - from) / (to - from);
    points.set(name, [p2[i] * Math.pow(p2[k] / p2[i], share), p3[j] * Math.pow(p3[l] / p3[j], share)]);
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

// The plane as the address of a small picture, from one colour at e = 0 to another at e = 1.
function shade(values, ...ends) {
  const [low, high] = ends.map(channels);
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = POINTS;
  const ctx = canvas.getContext("2d");
  const image = ctx.createImageData(POINTS, POINTS);
  for (let j = 0; j < POINTS; j++) {
    for (let i = 0; i < POINTS; i++) {
      const e = values[j * POINTS + i];
      const place = 4 * ((POINTS - 1 - j) * POINTS + i);
      low.forEach((from, n) => {
        image.data[place + n] = from + (high[n] - from) * e;
      });
      image.data[place + 3] = Number.isFinite(e) ? 255 : 0;
    }
  }
  ctx.putImageData(image, 0, 0);
  return canvas.toDataURL();
}

const channels = (colour) => colour.match(/\d+/g).slice(0, 3).map(Number);

// What a panel draws: the plane at this Poisson ratio, and the present point if it is on the plane.
export function planePicture(paper, nu, marks = [], levels = LEVELS) {
  const { curves, image, across, up, values } = plane(paper, nu, levels);
  const { p2, p3 } = paper.about;
  const edge = (1 - 2 * nu) / (3 * nu);
  const dots = nu > 0 && edge > p2[0] && edge < p2[1] ? [{ x: edge, label: "ν₀ < 0 to the left" }] : [];
  return {
    curves,
    image,
    marks: [...dots, ...marks],
    x: { label: "p₂ = G∞/G₁", short: "p₂", log: true },
    y: { label: "p₃", log: true },
    columns: () => [
      { name: "p2", unit: "", values: Array.from(values, (_, n) => across[n % POINTS]) },
      { name: "p3", unit: "", values: Array.from(values, (_, n) => up[Math.floor(n / POINTS)]) },
      { name: `e at nu = ${nu}`, unit: "", values: [...values] },
    ],
    ranges: { x: p2, y: p3 },
  };
}
