// Formulas in plain text, such as "eta (v0 R/(m^2 Ginf^3))^(1/5)", with Greek letters, subscripts and powers.
import { element } from "./elements.js";

const LETTERS = { nu: "ν", eta: "η", tau: "τ", log: "log" };
const PARTS = /\^\(([^()]*)\)|\^(-?\d+)|\be([+-]\d+)\b|(\d(?:\.\d+)?)e([+-]\d+)|(?<![A-Za-z_])(E\*|[A-Za-z]|nu|eta|tau|log)(_[a-z]+|_?\d+|inf)?(?:_(inc|0))?(?![A-Za-z])/g;
// Words of one letter that are no symbols.
const WORDS = new Set(["a", "A", "I"]);

export function formula(text) {
  const parts = [];
  let end = 0;
  for (const match of text.matchAll(PARTS)) {
    const [whole, group, power, , digits, exponent, base, below, further] = match;
    if (base && !below && !further && WORDS.has(base)) continue;
    parts.push(minus(text.slice(end, match.index)));
    end = match.index + whole.length;
    if (group ?? power) parts.push(element("sup", {}, (group ?? power).replace("-", "−")));
    else if (digits) parts.push(`${digits}·10`, element("sup", {}, String(Number(exponent)).replace("-", "−")));
    else if (base) parts.push(...symbol(base, [below, further]));
    else parts.push(whole);
  }
  return [...parts, minus(text.slice(end))];
}

const minus = (text) => text.replace(/(^|[\s(=])-(?=\d)/g, "$1−");

function symbol(base, below) {
  const lowered = below.filter(Boolean).map((index) => index.replace("_", "").replace(/^inf$/, "∞")).join(", ");
  const letter = element(base === "log" ? "span" : "i", {}, LETTERS[base] ?? base);
  return lowered ? [letter, element("sub", {}, lowered)] : [letter];
}
