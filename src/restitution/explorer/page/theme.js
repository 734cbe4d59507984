// Colours of the pictures, read from the style sheet; they follow the choice of light or dark, and paper is light.
const NAMES = ["ink", "muted", "card", "grid", "accent", "second", "third", "pinned", "map-low", "map-high", "ground", "body"];
const waiting = new Set();
let palette = null;

export function colours() {
  if (palette) return palette;
  // An element has the colours as numbers; the style sheet has each of them for light and for dark.
  const probe = document.body.appendChild(document.createElement("i"));
  palette = Object.fromEntries(NAMES.map((name) => {
    probe.style.color = `var(--${name})`;
    return [name, getComputedStyle(probe).color];
  }));
  probe.remove();
  const em = parseFloat(getComputedStyle(document.documentElement).fontSize);
  return Object.assign(palette, { font: getComputedStyle(document.body).fontFamily, em, thickness: em / 16 });
}

export function onTheme(callback) {
  waiting.add(callback);
}

function changed() {
  palette = null;
  for (const callback of waiting) callback();
}

let chosen = "auto";

export function setTheme(choice) {
  chosen = choice;
  wear(choice);
}

function wear(theme) {
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  changed();
}

addEventListener("beforeprint", () => wear("light"));
addEventListener("afterprint", () => wear(chosen));

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
let width = innerWidth;
addEventListener("resize", () => {
  if (innerWidth === width) return;
  width = innerWidth;
  changed();
});

export const printing = () => matchMedia("print").matches;

export const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
