// Pictures as SVG, with the curves, ticks and labels of those on the screen.
import { dashOf } from "./figure.js";
import { colours } from "./theme.js";
import { tickLabels, ticks } from "./ticks.js";

const escaped = (text) => String(text).replace(/[&<>"]/g, (one) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[one]);
const round = (value) => Math.round(value * 100) / 100;

export function svgOf(figure, title) {
  const palette = colours();
  const { plot, options, ranges, size } = figure;
  const em = palette.em;
  const key = legend(figure.curves, em, size.width);
  const top = 2 * em + key.height;
  const box = { left: plot.over.offsetLeft, top: plot.over.offsetTop + top, width: plot.over.clientWidth, height: plot.over.clientHeight };
  const at = (x, y) => [round(plot.valToPos(x, "x") + box.left), round(plot.valToPos(y, "y") + box.top)];
  const parts = [];
  const text = (x, y, words, extra = "") => parts.push(`<text x="${round(x)}" y="${round(y)}" ${extra}>${escaped(words)}</text>`);
  const stroke = (x1, y1, x2, y2, colour, extra = "") =>
    parts.push(`<line x1="${round(x1)}" y1="${round(y1)}" x2="${round(x2)}" y2="${round(y2)}" stroke="${colour}" ${extra}/>`);

  for (const { curve, left, line } of key.entries) {
    stroke(left, line, left + 1.7 * em, line, palette[curve.colour ?? "accent"], `stroke-width="2" stroke-dasharray="${dashOf(curve).join(" ")}"`);
    text(left + 2.1 * em, line + 0.3 * em, curve.label);
  }
  if (figure.bands) {
    parts.push(`<image x="${box.left}" y="${box.top}" width="${box.width}" height="${box.height}" preserveAspectRatio="none" `
      + `opacity="${figure.bands.alpha ?? 1}" href="${figure.bands.image.toDataURL()}"/>`);
  }
  for (const key of ["x", "y"]) {
    const [low, high] = ranges[key];
    const marks = ticks(low, high, options[key], figure.count(key, em));
    tickLabels(marks, options[key].log).forEach((label, n) => {
      if (key === "x") {
        const [x] = at(marks[n], ranges.y[0]);
        stroke(x, box.top, x, box.top + box.height, palette.grid);
        text(x, box.top + box.height + 1.2 * em, label, 'text-anchor="middle"');
      } else {
        const [, y] = at(ranges.x[0], marks[n]);
        stroke(box.left, y, box.left + box.width, y, palette.grid);
        text(box.left - 0.4 * em, y + 0.3 * em, label, 'text-anchor="end"');
      }
    });
  }
  text(box.left + box.width / 2, box.top + box.height + 2.7 * em, figure.label("x", em), 'text-anchor="middle"');
  const [across, middle] = [0.9 * em, box.top + box.height / 2];
  text(across, middle, figure.label("y", em), `text-anchor="middle" transform="rotate(-90 ${round(across)} ${round(middle)})"`);

  parts.push(`<g clip-path="url(#inside)" fill="none" stroke-linejoin="round" stroke-linecap="round">`);
  for (const curve of figure.curves) {
    const path = [];
    let pen = "M";
    curve.x.forEach((x, n) => {
      const y = curve.y[n];
      const drawn = Number.isFinite(x) && Number.isFinite(y) && x !== null && y !== null
        && !(options.x.log && x <= 0) && !(options.y.log && y <= 0);
      if (drawn) path.push(`${pen}${at(x, y).join(" ")}`);
      pen = drawn ? "L" : "M";
    });
    parts.push(`<path d="${path.join("")}" stroke="${palette[curve.colour ?? "accent"]}" stroke-width="${curve.width ?? 2}" `
      + `stroke-dasharray="${dashOf(curve).join(" ")}"><title>${escaped(curve.label ?? curve.letter ?? "")}</title></path>`);
  }
  parts.push("</g>");
  for (const curve of figure.curves) {
    if (!curve.letter || curve.placed === undefined) continue;
    const [x, y] = at(curve.x[curve.placed], curve.y[curve.placed]);
    text(x, y + 0.3 * em, curve.letter, `text-anchor="middle" stroke="${palette.card}" stroke-width="4" paint-order="stroke"`);
  }
  for (const mark of figure.marks) {
    if (mark.y === undefined) {
      const [x] = at(mark.x, ranges.y[0]);
      stroke(x, box.top, x, box.top + box.height, palette.ink, 'stroke-dasharray="4 3"');
      text(x + (mark.before ? -5 : 5), box.top + em, mark.label ?? "", `text-anchor="${mark.before ? "end" : "start"}" stroke="${palette.card}" stroke-width="4" paint-order="stroke"`);
    } else {
      const [x, y] = at(mark.x, mark.y);
      parts.push(`<circle cx="${x}" cy="${y}" r="5.5" fill="${palette.card}" stroke="${palette[mark.colour ?? "ink"]}" stroke-width="2.5"/>`);
    }
  }
  const inside = `<clipPath id="inside"><rect x="${box.left}" y="${box.top}" width="${box.width}" height="${box.height}"/></clipPath>`;
  return sheet(title, size.width, size.height + top, [inside, ...parts]);
}

// The places of the names of curves under the title.
function legend(curves, em, width) {
  const entries = [];
  let [left, line] = [em, 2.3 * em];
  for (const curve of curves.filter(({ label }) => label).reverse()) {
    const wide = (3 + 0.5 * curve.label.length) * em;
    if (left > em && left + wide > width) [left, line] = [em, line + 1.4 * em];
    entries.push({ curve, left, line });
    left += wide;
  }
  return { entries, height: entries.length ? line - 0.9 * em : 0 };
}

// The scenes of the slow motion side by side.
export function svgOfScenes(scenes, title) {
  const { em } = colours();
  let left = em;
  const parts = scenes.map((scene) => {
    const { width, height } = scene.size;
    const pen = new SvgPen();
    scene.draw({ ctx: pen, width, height, em });
    left += width + em;
    return `<svg x="${left - width - em}" y="${2 * em}" width="${width}" height="${height}">${pen.parts.join("\n")}</svg>`;
  });
  return sheet(title, left, Math.max(...scenes.map(({ size }) => size.height)) + 3 * em, parts);
}

function sheet(title, width, height, parts) {
  const { card, em, font, ink } = colours();
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" `
    + `font-family="${escaped(font)}" font-size="${0.88 * em}" fill="${ink}">`
    + `<rect width="${width}" height="${height}" fill="${card}"/>`
    + `<text x="${em}" y="${1.2 * em}" font-size="${Math.min(em, (width - 2 * em) / (0.6 * title.length))}" font-weight="600">${escaped(title)}</text>${parts.join("\n")}</svg>\n`;
}

// Takes those calls of a canvas that the slow motion makes, and writes them as SVG.
class SvgPen {
  constructor() {
    this.parts = [];
    this.globalAlpha = 1;
    this.dash = [];
  }

  beginPath() {
    this.path = "";
  }

  moveTo(x, y) {
    this.path += `M${round(x)} ${round(y)}`;
  }

  lineTo(x, y) {
    this.path += `${this.path ? "L" : "M"}${round(x)} ${round(y)}`;
  }

  // A whole ellipse, as two halves.
  ellipse(x, y, across, up) {
    const half = (side) => `A${round(across)} ${round(up)} 0 0 1 ${round(x + side * across)} ${round(y)}`;
    this.path += `M${round(x - across)} ${round(y)}${half(1)}${half(-1)}`;
  }

  closePath() {
    this.path += "Z";
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  fill() {
    this.add("path", `d="${this.path}" fill="${this.fillStyle}"`);
  }

  stroke() {
    this.add("path", `d="${this.path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-dasharray="${this.dash.join(" ")}"`);
  }

  fillRect(x, y, width, height) {
    this.add("rect", `x="${round(x)}" y="${round(y)}" width="${round(width)}" height="${round(height)}" fill="${this.fillStyle}"`);
  }

  fillText(words, x, y) {
    const anchor = { left: "start", center: "middle", right: "end" }[this.textAlign];
    this.add("text", `x="${round(x)}" y="${round(y)}" text-anchor="${anchor}" dominant-baseline="central" style="font:${escaped(this.font)}" fill="${this.fillStyle}"`, words);
  }

  add(name, attributes, words = "") {
    this.parts.push(`<${name} ${attributes} opacity="${this.globalAlpha}">${escaped(words)}</${name}>`);
  }
}
