// The paper's restitution coefficient e(nu, p2, p3) by the shipped interpolant: a translation of
// restitution/surrogates/standard_solid.py.

/** Load the data and return {restitution(nu, p2, p3), map(nu, p2s, p3s), about}. */
export async function load(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address}: ${answer.status}`);
  return interpolant(await answer.json());
}

export function interpolant(data) {
  const n = data.terms;
  const bytes = Uint8Array.from(atob(data.coefficients), (c) => c.charCodeAt(0));
  const coefficients = Float64Array.from(new Float32Array(bytes.buffer));
  const { low, high, levels, places } = data;
  const finest = [0, 1, 2].map((d) => Math.max(...levels.map((level) => level[d])));
  const size = finest.map((level) => 2 ** level);
  const scale = [0, 1, 2].map((d) => size[d] / (high[d] - low[d]));
  const cells = new Int32Array(size[0] * size[1] * size[2]).fill(-1);
  const middle = new Float64Array(3 * levels.length);
  const inverse = new Float64Array(3 * levels.length);
  levels.forEach((level, box) => {
    const first = [], count = [];
    for (let d = 0; d < 3; d++) {
      const width = (high[d] - low[d]) * 0.5 ** level[d];
      middle[3 * box + d] = low[d] + width * (places[box][d] + 0.5);
      inverse[3 * box + d] = 2 / width;
      count.push(2 ** (finest[d] - level[d]));
      first.push(places[box][d] * count[d]);
    }
    for (let i = first[0]; i < first[0] + count[0]; i++) {
      for (let j = first[1]; j < first[1] + count[1]; j++) {
        const row = (i * size[1] + j) * size[2];
        cells.fill(box, row + first[2], row + first[2] + count[2]);
      }
    }
  });
  const terms = [0, 1, 2].map(() => new Float64Array(n));

  function cell(value, d) {
    return Math.min(Math.max(Math.trunc((value - low[d]) * scale[d]), 0), size[d] - 1);
  }

  function valueAt(point) {
    const box = cells[(cell(point[0], 0) * size[1] + cell(point[1], 1)) * size[2] + cell(point[2], 2)];
    for (let d = 0; d < 3; d++) {
      const t = (point[d] - middle[3 * box + d]) * inverse[3 * box + d];
      const row = terms[d];
      row[0] = 1;
      row[1] = t;
      for (let k = 2; k < n; k++) row[k] = 2 * t * row[k - 1] - row[k - 2];
    }
    const start = box * n * n * n;
    let total = 0;
    for (let a = 0; a < n; a++) {
      let overY = 0;
      for (let b = 0; b < n; b++) {
        let overZ = 0;
        const row = start + (a * n + b) * n;
        for (let c = 0; c < n; c++) overZ += coefficients[row + c] * terms[2][c];
        overY += overZ * terms[1][b];
      }
      total += overY * terms[0][a];
    }
    return total;
  }

  const slack = 1e-12;

  function restitution(nu, p2, p3) {
    const inside = (value, [low, high]) => value >= low * (1 - slack) && value <= high * (1 + slack);
    if (!(nu >= data.nu[0] && nu <= data.nu[1] && inside(p2, data.p2) && inside(p3, data.p3))) return NaN;
    const q = 1 + 1 / p2;
    const logQ = Math.log(q);
    const r = ((1 + nu) + 2 * q * (1 - 2 * nu)) / (3 * (1 - nu));
    const x = Math.log(r) / logQ;
    const y = Math.log(p2) / Math.LN10;
    const slope = x < 0.5 ? 0.5 : 0.07;
    const z = (Math.log(p2 * p3) + (0.4 + slope * x) * logQ) / Math.LN10;
    return valueAt([x, y, z]);
  }

  function map(nu, p2s, p3s) {
    return Float64Array.from({ length: p2s.length * p3s.length }, (_, n) => restitution(nu, p2s[n % p2s.length], p3s[Math.floor(n / p2s.length)]));
  }

  return { restitution, map, about: { nu: data.nu, p2: data.p2, p3: data.p3, error: data.error } };
}

/** Instantaneous Poisson ratio of a standard solid with constant bulk modulus. */
export function instantaneousPoissonRatio(nu, p2) {
  const bulk = (2 * (1 + nu)) / 3;
  const glass = (1 - 2 * nu) * (1 + 1 / p2);
  return (3 * bulk - 2 * glass) / (6 * bulk + 2 * glass);
}

/** The paper's three numbers of a sphere on a standard solid, from quantities in SI. */
export function groups(solid) {
  const { equilibrium_modulus: end, branch_modulus: branch, viscosity, poisson_ratio: nu, mass, radius, velocity } = solid;
  return { nu, p2: end / branch, p3: viscosity * ((velocity * radius) / (mass * mass * end ** 3)) ** 0.2 };
}
