// Colours of the pictures, read from the style sheet; they follow the choice of light or dark.
const NAMES = ["ink", "muted", "card", "grid", "accent", "second", "third", "pinned", "map-low", "map-high", "warn", "ground", "body"];
const waiting = new Set();
let found = null;

export function colours() {
  if (found) return found;
  const style = getComputedStyle(document.documentElement);
  found = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  found.font = getComputedStyle(document.body).fontFamily;
  found.em = parseFloat(getComputedStyle(document.documentElement).fontSize);
  found.thickness = found.em / 16;
  return found;
}

export function onTheme(callback) {
  waiting.add(callback);
}

function changed() {
  found = null;
  for (const callback of waiting) callback();
}

export function setTheme(choice) {
  if (choice === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = choice;
  changed();
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
let width = innerWidth;
addEventListener("resize", () => {
  if (innerWidth === width) return;
  width = innerWidth;
  changed();
});

export const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
