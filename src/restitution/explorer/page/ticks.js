// Places and labels of the ticks of an axis.
import { superscript } from "./units.js";

export function ticks(low, high, { log, whole }, wanted) {
  const marks = log ? decades(low, high, wanted) : linear(low, high, wanted);
  return whole ? marks.filter(Number.isInteger) : marks;
}

function linear(low, high, wanted) {
  const rough = (high - low) / Math.max(wanted, 2);
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 2.5, 5, 10].map((one) => one * power).find((one) => one >= rough * 0.999);
  const first = Math.ceil(low / step - 1e-9);
  const marks = [];
  for (let n = first; n * step <= high + 1e-9 * step; n++) marks.push(n * step);
  return marks;
}

function decades(low, high, wanted) {
  if (!(low > 0)) return [];
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  const marks = [];
  if (last - first >= 1) {
    const every = Math.max(1, Math.ceil((last - first + 1) / Math.max(wanted, 2)));
    for (let n = first; n <= last; n++) if ((n - first) % every === 0) marks.push(Math.pow(10, n));
    if (marks.length > 2 || last - first >= 2) return marks;
  }
  marks.length = 0;
  for (let n = first - 1; n <= last; n++) {
    for (const digit of [1, 2, 5]) marks.push(digit * Math.pow(10, n));
  }
  return marks.filter((one) => one >= low * (1 - 1e-9) && one <= high * (1 + 1e-9));
}

export function tickLabels(marks, log) {
  // Powers of ten are written in one way.
  if (log && marks.every(isDecade) && !(marks[0] >= 0.00099 && marks.at(-1) < 9999)) return marks.map((one) => `10${superscript(Math.round(Math.log10(one)))}`);
  if (log) return marks.map(logLabel);
  const step = marks.length > 1 ? marks[1] - marks[0] : Math.abs(marks[0]) || 1;
  const largest = Math.max(...marks.map(Math.abs));
  if (largest >= 1e5 || (largest < 1e-3 && largest > 0)) return marks.map((one) => plain(Number(one.toPrecision(6)).toExponential()));
  const digits = Math.min(Math.max(0, Math.ceil(-Math.log10(step) + (isRound(step) ? 0 : 1) - 1e-9)), 8);
  return marks.map((one) => plain((Math.abs(one) < 1e-9 * step ? 0 : one).toFixed(digits)));
}

const isDecade = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9;

const isRound = (step) => Math.abs(step / Math.pow(10, Math.floor(Math.log10(step) + 1e-9)) - 2.5) > 1e-6;

function logLabel(value) {
  const power = Math.round(Math.log10(value));
  if (value >= 0.00099 && value < 9999) return plain(String(Number(value.toPrecision(3))));
  const digit = Math.round(value / Math.pow(10, power));
  return digit === 1 ? `10${superscript(power)}` : plain(value.toExponential(0));
}

function plain(text) {
  const [digits, power] = text.replace("-", "−").split("e");
  return power === undefined ? digits : `${digits}·10${superscript(Number(power.replace("−", "-")))}`;
}
