// Pictures are nodes of SVG. Those on the screen are the ones that a file gets.
import { colours, onTheme, printing } from "./theme.js";

const SPACE = "http://www.w3.org/2000/svg";

export const round = (value) => Math.round(100 * value) / 100;

export function node(name, attributes = {}) {
  const created = document.createElementNS(SPACE, name);
  for (const [key, value] of Object.entries(attributes)) created.setAttribute(key, value);
  return created;
}

// Gives a node these shapes as its children, each one as [name, attributes, words or further shapes]. The browser
// spends its time on what changes, so a child that is there already gets the new attributes alone.
export function draw(parent, shapes) {
  shapes.forEach(([name, attributes, inside], n) => {
    let child = parent.childNodes[n];
    if (child?.localName !== name) {
      const before = child;
      child = node(name);
      if (before) before.replaceWith(child);
      else parent.append(child);
    }
    const { drawn = {} } = child;
    for (const key in attributes) if (drawn[key] !== attributes[key]) child.setAttribute(key, attributes[key]);
    for (const key in drawn) if (!(key in attributes)) child.removeAttribute(key);
    child.drawn = attributes;
    if (Array.isArray(inside)) draw(child, inside);
    else if (inside !== undefined && inside !== child.words) child.textContent = child.words = inside;
  });
  while (parent.childNodes.length > shapes.length) parent.lastChild.remove();
}

// The size of a node, which a picture fills; it is drawn anew when the size or the theme changes.
export function filled(svg, host, redraw) {
  const size = { width: 0, height: 0 };
  new ResizeObserver(() => {
    const { width, height } = host.getBoundingClientRect();
    // On paper a picture keeps the proportions of the screen.
    if (!width || !height || printing() || (width === size.width && height === size.height)) return;
    Object.assign(size, { width, height });
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    redraw();
  }).observe(host);
  onTheme(redraw);
  return size;
}

// Words whose middle is at this height. The edge in the colour of the card keeps them readable upon lines.
export function words(text, x, y, size, fill, { anchor = "start", edge = null, wide = 0.3 } = {}) {
  const halo = edge && { stroke: edge, "stroke-width": round(wide * size), "stroke-linejoin": "round", "paint-order": "stroke" };
  return ["text", { x: round(x), y: round(y + 0.34 * size), "font-size": size, fill, "text-anchor": anchor, ...halo }, text];
}

// The lines of a path through points [x, y]; one with a place that is no number ends a line.
export function lines(points) {
  let [text, pen] = ["", "M"];
  for (const [x, y] of points) {
    const drawn = Number.isFinite(x) && Number.isFinite(y);
    if (drawn) text += `${pen}${round(x)} ${round(y)}`;
    pen = drawn ? "L" : "M";
  }
  return text;
}

// A card as a file: its title, its legend and its pictures, where they are on the screen.
export function sheet(card) {
  const { card: paper, em, font, ink } = colours();
  const frame = card.getBoundingClientRect();
  const place = ({ left, top, width, height }) => ({ x: round(left - frame.left), y: round(top - frame.top), width: round(width), height: round(height) });
  const lines = [...card.querySelectorAll("h3, .legend li")].map((line) => {
    const range = document.createRange();
    range.selectNodeContents(line.lastChild);
    const { x, y, height } = place(range.getClientRects()[0] ?? line.getBoundingClientRect());
    const style = getComputedStyle(line);
    const text = line.textContent;
    const size = Math.min(parseFloat(style.fontSize), (frame.width - x - em) / (0.6 * text.length));
    return ["text", { x, y: round(y + 0.79 * height), "font-size": round(size), "font-weight": style.fontWeight, fill: style.color }, text];
  });
  const pictures = [...card.querySelectorAll("svg:not(svg svg)")].map((picture) => {
    const copy = picture.cloneNode(true);
    for (const part of copy.querySelectorAll(".cursor, .over, .hover")) part.remove();
    copy.removeAttribute("aria-hidden");
    for (const [key, value] of Object.entries(place(picture.getBoundingClientRect()))) copy.setAttribute(key, value);
    return copy;
  });
  const width = Math.round(frame.width);
  const height = Math.round(Math.max(...pictures.map((copy) => Number(copy.getAttribute("y")) + Number(copy.getAttribute("height")))) + 0.7 * em);
  const root = node("svg", { width, height, viewBox: `0 0 ${width} ${height}`, "font-family": font, fill: ink });
  draw(root, [["rect", { width, height, fill: paper }], ...lines]);
  root.append(...pictures);
  return `${new XMLSerializer().serializeToString(root)}\n`;
}
