// The inputs as the server states them: default, range, options and conditions of each. What the page shows and what
// it refuses follows from this table alone; no input is known here by its name.
import { phrase } from "./units.js";

const holds = (when, values) => Object.entries(when ?? {}).every(([key, wanted]) => wanted.includes(values[key]));

export class Inputs {
  constructor(list) {
    this.list = list;
    this.byKey = new Map(list.map((input) => [input.key, input]));
    this.defaults = Object.fromEntries(list.map((input) => [input.key, input.default]));
  }

  options(input, values) {
    return input.options.filter((option) => holds(option.when, values));
  }

  shown(input, values) {
    return holds(input.when, values);
  }

  // A choice whose option is not available takes the first that is.
  settled(values) {
    const settled = { ...values };
    for (const input of this.list) {
      if (input.type !== "choice") continue;
      settled[input.key] = String(settled[input.key]);
      const free = this.options(input, settled);
      if (free.length && !free.some((option) => option.value === settled[input.key])) settled[input.key] = free[0].value;
    }
    return settled;
  }

  // A text of an address as the value of an input; undefined if it is none.
  read(key, text) {
    const input = this.byKey.get(key);
    if (!input) return undefined;
    const number = (one) => (one.trim() === "" ? NaN : Number(one));
    const value = input.type === "choice" ? text : input.type === "number" ? number(text) : text ? text.split(",").map(number) : [];
    return fault(input, value) ? undefined : value;
  }
}

// Why an input does not take a value, in words.
export function fault(input, value) {
  if (input.type === "choice") return input.options.some((option) => option.value === value) ? "" : "Choose one of the list.";
  const list = input.type === "list";
  const values = list ? value : [value];
  if (!values.every(Number.isFinite)) return list ? "Write numbers with spaces between them." : "Write a number.";
  if (values.length > (input.most_items ?? 1)) return `Must have at most ${input.most_items} numbers.`;
  const { least, most } = input;
  return values.every((one) => one >= least && one <= most) ? "" : `Must be from ${phrase(least, input)} to ${phrase(most, input)}.`;
}
