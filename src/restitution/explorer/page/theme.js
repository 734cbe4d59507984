// Colours of the pictures, read from the style sheet; they follow the choice of light or dark, and paper is light.
const NAMES = ["ink", "muted", "card", "grid", "accent", "second", "third", "pinned", "map-low", "map-high", "ground", "body"];
const waiting = new Set();
let found = null;

export function colours() {
  if (found) return found;
  // An element has the colours as numbers; the style sheet has each of them for light and for dark.
  const probe = document.body.appendChild(document.createElement("i"));
  found = Object.fromEntries(NAMES.map((name) => {
    probe.style.color = `var(--${name})`;
    return [name, getComputedStyle(probe).color];
  }));
  probe.remove();
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

// On paper a picture keeps the proportions that it has on the screen.
export const printing = () => matchMedia("print").matches;

export const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
