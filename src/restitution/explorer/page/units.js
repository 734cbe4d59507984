// Numbers as a reader wants them: units of a system, prefixes, digits, subscripts.
import { element } from "./elements.js";

const PREFIXES = [[-15, "f"], [-12, "p"], [-9, "n"], [-6, "µ"], [-3, "m"], [0, ""], [3, "k"], [6, "M"], [9, "G"], [12, "T"]];
const PREFIXED = new Set(["m", "s", "N", "J", "Pa", "Pa s", "m/s", "rad/s"]);
const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

let systems = { SI: {} };
let system = "SI";

export function setSystems(table) {
  systems = table;
}

export function setSystem(name) {
  system = Object.hasOwn(systems, name) ? name : "SI";
}

export const systemNames = () => Object.keys(systems);

export const superscript = (number) => [...String(number)].map((sign) => RAISED[sign] ?? sign).join("");

export const unitText = (unit) => unit
  .replace(/\^(-?\d+)/g, (_, power) => superscript(power))
  .replace(/([a-zµ])(\d)$/i, (_, letter, power) => letter + superscript(power))
  .replace(/\bu(?=[msgNJ])/g, "µ");

// The unit in which a quantity is shown, as {unit, factor, offset}: shown = SI factor + offset.
function shownIn(quantity) {
  return systems[system]?.[quantity.dimension] ?? { unit: quantity.unit ?? "", factor: 1 };
}

// The same for values of about this size: in SI a prefix makes them readable.
export function unitFor(quantity, size) {
  const base = shownIn(quantity);
  const value = Math.abs(size);
  if (system !== "SI" || base.offset || !Number.isFinite(value) || value === 0) return base;
  if (base.unit === "kg") return massUnit(value);
  if (!PREFIXED.has(base.unit)) return base;
  const power = Math.floor(Math.log10(value) / 3 + 1e-9) * 3;
  const places = ["m/s", "rad/s"].includes(base.unit) && power >= 0 ? 0 : power;
  return prefixed(base).find((unit) => unit.power === places) ?? base;
}

const prefixed = (base) => PREFIXES.map(([power, prefix]) => ({ power, unit: prefix + base.unit, factor: base.factor / Math.pow(10, power) }));

const MASSES = [[1, "kg"], [1e3, "g"], [1e6, "mg"], [1e9, "µg"], [1e12, "ng"]].map(([factor, unit]) => ({ unit, factor }));

const massUnit = (value) => MASSES.find(({ factor }) => value * factor >= 1) ?? MASSES.at(-1);

export const convert = (value, unit) => value * unit.factor + (unit.offset ?? 0);
export const back = (shown, unit) => (shown - (unit.offset ?? 0)) / unit.factor;

// A text such as "20 kPa" as {value in SI, unit}, where a number alone has the unit that is shown; else null.
export function typed(text, quantity, shown) {
  const [, number, name] = text.trim().replace("−", "-").match(/^([-+]?[\d.,]+(?:e[-+]?\d+)?)\s*(.*)$/i) ?? [];
  const value = typedNumber(number ?? "");
  const unit = name ? unitNamed(name, quantity) : shown;
  return number && Number.isFinite(value) && unit ? { value: back(value, unit), unit } : null;
}

// A number as people write it, with a decimal comma or a true minus sign; NaN if it is none.
export const typedNumber = (text) => (text.trim() ? Number(text.replace("−", "-").replace(",", ".")) : NaN);

// A unit of any system by its name, or one of SI with a prefix.
function unitNamed(name, quantity) {
  const plainly = (unit) => unit.replaceAll("µ", "u").replaceAll(/[\s·*]/g, "").replaceAll("²", "2").replaceAll("³", "3").replace("^", "");
  const text = plainly(name);
  const ofSystems = Object.values(systems).map((units) => units[quantity.dimension]).filter(Boolean);
  const plain = { unit: quantity.unit ?? "", factor: 1 };
  const base = systems.SI?.[quantity.dimension] ?? plain;
  const sizes = base.unit === "kg" ? MASSES : PREFIXED.has(base.unit) ? prefixed(base) : [];
  return [plain, ...ofSystems, ...sizes].find(({ unit }) => unit && plainly(unit) === text) ?? null;
}

export const systemName = () => system;

// A number with a few digits, with a true minus sign and no trailing zeros that mean nothing.
export function digits(value, count = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  let text;
  if (size >= 1e6 || size < 1e-4) {
    const [mantissa, power] = value.toExponential(count - 1).split("e");
    text = `${mantissa}·10${superscript(Number(power))}`;
  } else if (size >= Math.pow(10, count)) text = value.toFixed(0);
  else text = value.toPrecision(count);
  if (text.includes("e")) text = String(Number(text));
  return text.replace("-", "−");
}

// A value in SI with the unit in which it is shown, such as "0.954 ms".
export function withUnit(value, quantity, count = 4) {
  const unit = unitFor(quantity, value);
  const shown = value === null || value === undefined ? null : convert(value, unit);
  if (!unit.unit && Number.isInteger(shown)) return { text: String(shown).replace("-", "−"), unit: "" };
  return { text: digits(shown, count), unit: shown === null ? "" : unitText(unit.unit) };
}

export function phrase(value, quantity, count = 4) {
  const { text, unit } = withUnit(value, quantity, count);
  return unit ? `${text} ${unit}` : text;
}

export function axisLabel(quantity, unit, words = quantity.words) {
  const symbol = plainSymbol(quantity.symbol);
  return [words, symbol, unit.unit && `[${unitText(unit.unit)}]`].filter(Boolean).join(" ");
}

const LOWERED = { 0: "₀", 1: "₁", 2: "₂", 3: "₃", "∞": "∞" };
export const plainSymbol = (symbol) => (symbol ?? "").replace(/_(.)$/, (_, sign) => LOWERED[sign] ?? `_${sign}`).replace(/_\{?(\w+)\}?/, " $1");

// A symbol such as "d_max" as elements, with its subscript lowered.
export function symbolNodes(symbol) {
  const [base, below] = (symbol ?? "").split("_");
  return [element("i", {}, base), ...(below ? [element("sub", {}, below)] : [])];
}
