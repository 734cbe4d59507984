// An axis of a picture: its range, the places of values on it, and its ticks with their labels.
import { superscript } from "./units.js";

export class Axis {
  // About so many ticks are wanted; `whole` leaves those at whole numbers.
  constructor([low, high], length, wanted, { log = false, whole = false }) {
    Object.assign(this, { low, high, length, log });
    this.scale = log ? Math.log10 : (value) => value;
    this.start = this.scale(low);
    this.share = length / (this.scale(high) - this.start);
    const ticks = log ? decades(low, high, wanted) : linear(low, high, wanted);
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

// The range of the values of curves on an axis. There is room above and below them if wanted, and more for words.
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
  for (const curve of curves) {
    for (const value of curve[key]) {
      if (value === null || !Number.isFinite(value) || (log && value <= 0)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return log ? [0.1, 10] : [0, 1];
  if (low === high) return log ? [low / 2, high * 2] : [low - (Math.abs(low) || 1) / 2, high + (Math.abs(high) || 1) / 2];
  return [low, high];
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

function tickLabels(marks, log) {
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
