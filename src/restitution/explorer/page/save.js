// Files that the page writes: a picture as PNG or SVG, its numbers as CSV.
import { element } from "./inputs.js";
import { svgOf } from "./svg.js";
import { colours } from "./theme.js";

export function download(name, type, content) {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  const link = element("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

// The menu of a picture; its files are [words, act].
export function menu(title, files) {
  const summary = element("summary", {}, "Save");
  summary.setAttribute("aria-label", `Save: ${title}`);
  const button = (words, act) => {
    const made = element("button", { type: "button" }, words);
    made.addEventListener("click", () => {
      box.open = false;
      summary.focus();
      act();
    });
    return made;
  };
  const box = element("details", { className: "menu" }, summary,
    element("div", { className: "sheet" }, ...files.map(([words, act]) => button(words, act))));
  closing(box);
  return box;
}

export function saveMenu(panel) {
  return menu(panel.title, files(panel.name, {
    png: () => png(panel.name, panel.title, [panel.figure.plot.ctx.canvas]),
    svg: () => svgOf(panel.figure, panel.title),
    columns: () => (typeof panel.columns === "function" ? panel.columns() : panel.columns),
  }));
}

export const files = (name, { png: draw, svg, columns }) => [
  ["PNG", draw],
  ["SVG", () => download(`${name}.svg`, "image/svg+xml", svg())],
  ["CSV", () => download(`${name}.csv`, "text/csv", csv(columns()))],
];

// An open menu closes with Escape and with a click elsewhere.
export function closing(menu) {
  menu.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !menu.open) return;
    menu.open = false;
    menu.querySelector("summary").focus();
  });
  document.addEventListener("pointerdown", (event) => {
    if (!menu.contains(event.target)) menu.open = false;
  });
}

// Columns of unequal length are filled with empty cells.
export function csv(columns) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const head = columns.map(({ name, unit }) => quoted(unit ? `${name} [${unit}]` : name)).join(",");
  const length = Math.max(0, ...columns.map(({ values }) => values.length));
  const rows = Array.from({ length }, (_, n) => columns.map(({ values }) => values[n] ?? "").join(","));
  return `${[head, ...rows].join("\n")}\n`;
}

// Canvases side by side, under a title.
export function png(name, title, sources) {
  const palette = colours();
  const em = palette.em * devicePixelRatio;
  const canvas = element("canvas", {
    width: sources.reduce((total, one) => total + one.width + em, em), height: Math.max(...sources.map((one) => one.height)) + 3 * em,
  });
  const ctx = canvas.getContext("2d");
  ctx.fillStyle = palette.card;
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.fillStyle = palette.ink;
  ctx.font = `600 ${em}px ${palette.font}`;
  ctx.textBaseline = "middle";
  ctx.fillText(title, em, em);
  let left = em;
  for (const source of sources) {
    ctx.drawImage(source, left, 2 * em);
    left += source.width + em;
  }
  canvas.toBlob((blob) => download(`${name}.png`, "image/png", blob));
}
