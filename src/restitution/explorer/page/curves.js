// Curves of several settings in common units: the present one in colour, the pinned ones in grey.
import { axisLabel, unitFor } from "./units.js";

const largest = (columns) => columns.reduce((most, values) => values.reduce((top, one) => Math.max(top, Math.abs(one ?? 0)), most), 0);

// `sets` holds {table, letter, dash}, the present one first; `ys` are the names of columns with their styles.
export function picture(sets, x, ys, outputs, axes = {}) {
  const known = sets.filter(({ table }) => table);
  const unitOf = (names) => unitFor(outputs[names[0]], largest(known.flatMap(({ table }) => names.map((name) => table[name] ?? []))));
  const across = unitOf([x]);
  const up = unitOf(ys.map((one) => one.name));
  // Of a pinned setting only the first curve is shown.
  const curves = known.flatMap(({ table, letter, dash }) => (letter ? ys.slice(0, 1) : ys).map((style) => ({
    x: converted(table[x], across),
    y: converted(table[style.name], up),
    ...(letter ? { colour: "pinned", dash, width: 1.6, letter }
      : { colour: "accent", width: 2.4, ...style, label: ys.length > 1 ? style.label : undefined }),
  }))).reverse();
  return {
    curves,
    across,
    up,
    x: { ...labels(outputs[x], across, axes.xWords), log: axes.xLog, room: axes.xRoom },
    y: { ...labels(outputs[ys[0].name], up, axes.words), log: axes.yLog },
    columns: known.flatMap(({ table, letter }) => [x, ...ys.map((one) => one.name)].map((name) => ({
      name: letter ? `${letter}: ${name}` : name, unit: outputs[name].unit, values: table[name],
    }))),
  };
}

const labels = (quantity, unit, words) => ({
  label: words ? axisLabel({ symbol: "" }, unit, words) : axisLabel(quantity, unit),
  short: axisLabel(quantity, unit, ""),
});

const converted = (values, unit) => values.map((one) => (one === null ? null : one * unit.factor + (unit.offset ?? 0)));
