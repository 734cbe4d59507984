// The plane of the paper's Figures 3 and 4: isolines of e over p2 and p3, shaded.
import { colours } from "./theme.js";

const POINTS = 81;
const LEVELS = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95];
// Segments of an isoline with a letter.
const FEWEST = 12;

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
    const curves = levels.map((level) => isoline(across, up, values, level)).filter(({ x }) => x.length);
    kept.set(key, { curves, image: shade(values, low, high), across, up, values });
  }
  return kept.get(key);
}

// The places at a level, by marching squares: a segment within each cell, and a gap after it.
function isoline(p2, p3, values, level) {
  const [x, y] = [[], []];
  const width = p2.length;
  // Where the edge between two neighbouring points has the level.
  const cut = ([i, j], [k, l]) => {
    const [from, to] = [values[j * width + i], values[l * width + k]];
    if ((from < level) === (to < level)) return [];
    const share = (level - from) / (to - from);
    return [[p2[i] * Math.pow(p2[k] / p2[i], share), p3[j] * Math.pow(p3[l] / p3[j], share)]];
  };
  for (let j = 0; j + 1 < p3.length; j++) {
    for (let i = 0; i + 1 < width; i++) {
      const corners = [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]];
      const cuts = corners.flatMap((corner, n) => cut(corner, corners[(n + 1) % 4]));
      for (let n = 0; n + 1 < cuts.length; n += 2) {
        x.push(cuts[n][0], cuts[n + 1][0], null);
        y.push(cuts[n][1], cuts[n + 1][1], null);
      }
    }
  }
  return { x, y, colour: "ink", width: 1.1, letter: x.length > 3 * FEWEST ? String(level) : undefined };
}

// The plane as the address of a small picture, from one colour at e = 0 to another at e = 1.
function shade(values, ...ends) {
  const [low, high] = ends.map((colour) => colour.match(/\d+/g).slice(0, 3).map(Number));
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = POINTS;
  const context = canvas.getContext("2d");
  const image = context.createImageData(POINTS, POINTS);
  values.forEach((e, n) => {
    const place = 4 * ((POINTS - 1 - Math.floor(n / POINTS)) * POINTS + (n % POINTS));
    low.forEach((from, part) => {
      image.data[place + part] = from + (high[part] - from) * e;
    });
    image.data[place + 3] = Number.isFinite(e) ? 255 : 0;
  });
  context.putImageData(image, 0, 0);
  return canvas.toDataURL();
}

// What a panel draws: the plane at this Poisson ratio, and the present point if it is on the plane.
export function planePicture(paper, nu, marks = [], levels = LEVELS) {
  const { curves, image, across, up, values } = plane(paper, nu, levels);
  const { p2, p3 } = paper.about;
  const edge = (1 - 2 * nu) / (3 * nu);
  const limit = nu > 0 && edge > p2[0] && edge < p2[1] ? [{ x: edge, label: "ν₀ < 0 to the left" }] : [];
  return {
    curves,
    image,
    marks: [...limit, ...marks],
    x: { label: "p₂ = G∞/G₁", short: "p₂", symbol: "p₂", log: true },
    y: { label: "p₃", symbol: "p₃", log: true },
    columns: () => [
      { name: "p2", unit: "", values: Array.from(values, (_, n) => across[n % POINTS]) },
      { name: "p3", unit: "", values: Array.from(values, (_, n) => up[Math.floor(n / POINTS)]) },
      { name: `e at nu = ${nu}`, unit: "", values: [...values] },
    ],
    ranges: { x: p2, y: p3 },
  };
}
