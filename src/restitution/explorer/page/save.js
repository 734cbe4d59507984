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

export function saveMenu(panel) {
  const summary = element("summary", {}, "Save");
  summary.setAttribute("aria-label", `Save: ${panel.title}`);
  const button = (words, act) => {
    const made = element("button", { type: "button" }, words);
    made.addEventListener("click", () => {
      menu.open = false;
      summary.focus();
      act();
    });
    return made;
  };
  const menu = element("details", { className: "menu" }, summary, element("div", { className: "sheet" },
    button("PNG", () => png(panel)),
    button("SVG", () => download(`${panel.name}.svg`, "image/svg+xml", svgOf(panel.figure, panel.title))),
    button("CSV", () => download(`${panel.name}.csv`, "text/csv", csv(panel.columns)))));
  closing(menu);
  return menu;
}

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

function png(panel) {
  const source = panel.figure.plot.ctx.canvas;
  const palette = colours();
  const em = palette.em * devicePixelRatio;
  const canvas = element("canvas", { width: source.width, height: source.height + 2 * em });
  const ctx = canvas.getContext("2d");
  ctx.fillStyle = palette.card;
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.fillStyle = palette.ink;
  ctx.font = `600 ${em}px ${palette.font}`;
  ctx.textBaseline = "middle";
  ctx.fillText(panel.title, em, em);
  ctx.drawImage(source, 0, 2 * em);
  canvas.toBlob((blob) => download(`${panel.name}.png`, "image/png", blob));
}
