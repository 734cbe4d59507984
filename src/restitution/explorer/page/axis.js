// An axis of a picture: its range, the places of values on it, and its ticks with their labels.
import { superscript } from "./units.js";

export class Axis {
  // There are about `count` ticks; `whole` leaves those at whole numbers.
  constructor([low, high], length, count, { log = false, whole = false }) {
    Object.assign(this, { low, high, length, log });
    this.scale = log ? Math.log10 : (value) => value;
    this.start = this.scale(low);
    this.share = length / (this.scale(high) - this.start);
    const ticks = log ? decades(low, high, count) : linear(low, high, count);
    this.ticks = whole ? ticks.filter(Number.isInteger) : ticks;
    this.labels = tickLabels(this.ticks, log);
  }

  // Distance of a value from the low end; not finite for what has no place.
  at(value) {
    return value === null ? NaN : (this.scale(value) - this.start) * this.share;
  }

  // The value at a distance from the low end, which lies on the axis.
  value(distance) {
    const scaled = this.start + Math.min(Math.max(distance, 0), this.length) / this.share;
    return this.log ? 10 ** scaled : scaled;
  }

  has(value) {
    return value >= this.low && value <= this.high;
  }
}

// The range of the values of curves on an axis, with room above and below them unless `room` is false; more for words.
export function rangeOf(curves, key, log, { room = true, words = false } = {}) {
  const [low, high] = extent(curves, key, log);
  if (!room) return [low, high];
  if (log) {
    const above = Math.pow(high / low, 0.05);
    return [low / above, high * (words ? above ** 3 : above)];
  }
  const above = 0.06 * (high - low);
  return [low >= 0 && low < 0.3 * high ? 0 : low - above, high + above];
}

function extent(curves, key, log) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of curves.flatMap((curve) => [...curve[key]])) {
    if (!Number.isFinite(value) || (log && value <= 0)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (!(low <= high)) return log ? [0.1, 10] : [0, 1];
  if (low === high) return log ? [low / 2, high * 2] : [low - (Math.abs(low) || 1) / 2, high + (Math.abs(high) || 1) / 2];
  return [low, high];
}

// The whole numbers from one to another.
const span = (first, last) => Array.from({ length: Math.max(last - first + 1, 0) }, (_, n) => first + n);

function linear(low, high, count) {
  const rough = (high - low) / Math.max(count, 2);
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 2.5, 5, 10].map((digits) => digits * power).find((size) => size >= rough * 0.999);
  return span(Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)).map((n) => n * step);
}

function decades(low, high, count) {
  if (!(low > 0)) return [];
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  if (last - first >= 2) {
    const every = Math.ceil((last - first + 1) / Math.max(count, 2));
    return span(first, last).filter((n) => (n - first) % every === 0).map((n) => Math.pow(10, n));
  }
  const marks = span(first - 1, last).flatMap((n) => [1, 2, 5].map((digit) => digit * Math.pow(10, n)));
  const inside = marks.filter((mark) => mark >= low * (1 - 1e-9) && mark <= high * (1 + 1e-9));
  // Within a part of a decade.
  return inside.length > 1 ? inside : linear(low, high, count);
}

function tickLabels(marks, log) {
  // Powers of ten are written in one way.
  if (log && marks.every(isDecade) && !(marks[0] >= 0.00099 && marks.at(-1) < 9999)) return marks.map((mark) => `10${superscript(Math.round(Math.log10(mark)))}`);
  if (log) return marks.map(logLabel);
  const step = marks.length > 1 ? marks[1] - marks[0] : Math.abs(marks[0]) || 1;
  const largest = Math.max(...marks.map(Math.abs));
  if (largest >= 1e5 || (largest < 1e-3 && largest > 0)) return marks.map((mark) => (Math.abs(mark) < 1e-9 * step ? "0" : plain(Number(mark.toPrecision(6)).toExponential())));
  const digits = Math.min(Math.max(0, Math.ceil(-Math.log10(step) + (isRound(step) ? 0 : 1) - 1e-9)), 8);
  return marks.map((mark) => plain((Math.abs(mark) < 1e-9 * step ? 0 : mark).toFixed(digits)));
}

const isDecade = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9;

const isRound = (step) => Math.abs(step / Math.pow(10, Math.floor(Math.log10(step) + 1e-9)) - 2.5) > 1e-6;

function logLabel(value) {
  if (value >= 0.00099 && value < 9999) return plain(String(Number(value.toPrecision(4))));
  return isDecade(value) ? `10${superscript(Math.round(Math.log10(value)))}` : plain(Number(value.toPrecision(4)).toExponential());
}

function plain(text) {
  const [digits, power] = text.replace("-", "−").split("e");
  return power === undefined ? digits : `${digits}·10${superscript(Number(power.replace("−", "-")))}`;
}
