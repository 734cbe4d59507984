// The fields of the ranges of a picture, for those who know the numbers and for the keyboard.
import { closing } from "./downloads.js";
import { button, element } from "./elements.js";
import { typedNumber, unitText } from "./units.js";

const ENDS = [["x", 0, "from"], ["x", 1, "to"], ["y", 0, "from"], ["y", 1, "to"]];
const AXES = { x: "Across", y: "Up" };

export function rangeMenu(title, figure) {
  const fields = ENDS.map(([key, end, words]) => {
    const field = element("input", { type: "text", inputMode: "decimal", autocomplete: "off", ariaLabel: `${AXES[key]}, ${words}` });
    field.addEventListener("change", () => set());
    return { key, end, field };
  });
  const of = (key) => fields.filter((field) => field.key === key);
  const rows = Object.keys(AXES).map((key) => {
    const unit = element("span", { className: "unit" });
    return { key, unit, row: element("p", {}, `${AXES[key]} `, of(key)[0].field, " to ", of(key)[1].field, " ", unit) };
  });
  const show = () => {
    if (!figure.ranges) return;
    const { shown, options } = figure;
    for (const { key, end, field } of fields) {
      field.value = String(Number(shown[key][end].toPrecision(5)));
      field.ariaInvalid = "false";
    }
    for (const { key, unit } of rows) unit.textContent = unitText(options[key].unit?.unit ?? "");
  };
  // What is no range is marked, and the picture stays.
  const set = () => {
    const part = {};
    for (const key of Object.keys(AXES)) {
      part[key] = of(key).map(({ field }) => typedNumber(field.value));
      const good = part[key][0] < part[key][1] && part[key].every(Number.isFinite) && (!figure.options[key].log || part[key][0] > 0);
      for (const { field } of of(key)) field.ariaInvalid = String(!good);
      if (!good) return;
    }
    figure.zoom(part);
  };
  const whole = button("The whole picture", () => {
    figure.zoom(null);
    show();
  });
  const summary = element("summary", { ariaLabel: `Range: ${title}` }, "Range");
  const box = element("details", { className: "menu ranges" }, summary, element("div", { className: "sheet" }, ...rows.map(({ row }) => row), whole));
  box.addEventListener("toggle", () => box.open && show());
  closing(box);
  return box;
}
