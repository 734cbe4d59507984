// Files that the page writes: a picture as PNG or SVG, its numbers as CSV.
import { sheet } from "./drawing.js";
import { button, element } from "./elements.js";

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
  const summary = element("summary", { ariaLabel: `Save: ${title}` }, "Save");
  const buttons = files.map(([words, act]) => button(words, () => {
    box.open = false;
    summary.focus();
    act();
  }));
  const box = element("details", { className: "menu" }, summary, element("div", { className: "sheet" }, ...buttons));
  closing(box);
  return box;
}

// The picture is that of a card.
export const files = (name, card, columns) => [
  ["PNG", () => png(name, sheet(card()))],
  ["SVG", () => download(`${name}.svg`, "image/svg+xml", sheet(card()))],
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
function csv(columns) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const head = columns.map(({ name, unit }) => quoted(unit ? `${name} [${unit}]` : name)).join(",");
  const length = Math.max(0, ...columns.map(({ values }) => values.length));
  const rows = Array.from({ length }, (_, n) => columns.map(({ values }) => values[n] ?? "").join(","));
  return `${[head, ...rows].join("\n")}\n`;
}

// The browser turns SVG into pixels on a canvas, which nobody sees.
function png(name, svg) {
  const image = new Image();
  image.addEventListener("load", () => {
    const ratio = Math.max(2, devicePixelRatio);
    const canvas = element("canvas", { width: ratio * image.width, height: ratio * image.height });
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => download(`${name}.png`, "image/png", blob));
  });
  image.src = `data:image/svg+xml,${encodeURIComponent(svg)}`;
}
