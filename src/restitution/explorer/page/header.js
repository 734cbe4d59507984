// The header of the page: its tools, its tabs, and the keys for undo and redo.
import { closing, download } from "./downloads.js";
import { element, ofBrowser } from "./elements.js";
import { setTheme } from "./theme.js";
import { systemNames } from "./units.js";

const $ = (id) => document.getElementById(id);
const on = (id, kind, act) => $(id).addEventListener(kind, act);

export function bindHeader(app) {
  const { state, schema } = app;
  $("case-title").textContent = schema.title ?? "";
  $("case-title").hidden = !schema.title;
  if (schema.title) document.title = `${schema.title} – Restitution explorer`;
  bindHistory(state);
  on("skip", "click", (event) => {
    event.preventDefault();
    $("pictures").focus();
  });
  $("presets").append(...schema.presets.map(({ name, words }) => element("option", { value: name }, words)));
  on("presets", "change", (event) => {
    const preset = schema.presets.find(({ name }) => name === event.target.value);
    if (preset) state.set({ ...state.defaults, ...preset.state }, true);
    event.target.value = "";
  });
  $("units").append(...systemNames().map((name) => element("option", { value: name }, name)));
  on("units", "change", (event) => state.set({ "page.units": event.target.value }, true));
  $("theme").value = ofBrowser.getItem("colours") ?? "auto";
  setTheme($("theme").value);
  on("theme", "change", (event) => {
    ofBrowser.setItem("colours", event.target.value);
    setTheme(event.target.value);
  });
  bindFiles(app);
  bindTabs(app);
  // On a narrow screen the settings are a sheet that opens.
  const narrow = matchMedia("screen and (max-width: 860px)");
  const fit = () => {
    $("settings-box").open = !narrow.matches;
  };
  narrow.addEventListener("change", fit);
  fit();
}

function bindHistory(state) {
  on("undo", "click", () => state.undo());
  on("redo", "click", () => state.redo());
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=text], textarea")) return;
    const key = event.key.toLowerCase();
    if (key === "z" && !event.shiftKey) state.undo();
    else if (key === "y" || (key === "z" && event.shiftKey)) state.redo();
    else return;
    event.preventDefault();
  });
  // What stays as it is is left alone.
  const put = (id, key, value) => $(id)[key] === value || Object.assign($(id), { [key]: value });
  const update = () => {
    put("undo", "disabled", !state.canUndo);
    put("redo", "disabled", !state.canRedo);
    put("units", "value", state.get("page.units") ?? "SI");
  };
  state.onChange(update);
  update();
}

function bindFiles(app) {
  const { state } = app;
  // A button shows for a moment what it did. A browser has a clipboard for pages of this machine and of https alone.
  const copy = async (id, text) => {
    const words = $(id).dataset.words ??= $(id).textContent;
    $(id).textContent = await navigator.clipboard?.writeText(text).then(() => "Copied", () => null) ?? "Not allowed here";
    setTimeout(() => {
      $(id).textContent = words;
    }, 1500);
  };
  on("copy-link", "click", () => {
    state.commit();
    copy("copy-link", location.href);
  });
  const fetched = (what, act) => {
    app.downloaded = (answer, asked) => {
      if (!answer.ok) app.files.show(answer.error, true);
      else if (asked.what === what) act(answer);
    };
    app.backend.ask("download", { what, state: state.case() });
  };
  const ofTip = () => ["indentation", "tapping"].includes(app.tab);
  on("copy-python", "click", () => {
    const further = app.tab === "bounce" ? `print(rs.bounces(impact, gravity=${state.get("impact.gravity")}${state.get("bounces.spot") === "same" ? ", same_spot=True" : ""}))\n` : "";
    fetched(ofTip() ? `${app.tab} python` : "python", ({ text }) => copy("copy-python", text + further));
  });
  on("download-case", "click", () =>
    fetched(ofTip() ? app.tab : "case", ({ name, type, text }) => download(name, type, text)));
  closing($("save-menu"));
}

function bindTabs(app) {
  const nameOf = (tab) => tab.id.slice(4);
  const tabs = [...document.querySelectorAll("[role=tab]")].filter((tab) => nameOf(tab) in app.tabs);
  let shown = null;
  const show = () => {
    if (shown === app.tab) return;
    shown = app.tab;
    for (const tab of tabs) {
      const chosen = nameOf(tab) === shown;
      tab.ariaSelected = String(chosen);
      tab.tabIndex = chosen ? 0 : -1;
      $(`view-${nameOf(tab)}`).hidden = !chosen;
      if (chosen) $("heading").textContent = tab.textContent;
    }
  };
  for (const tab of tabs) tab.addEventListener("click", () => app.state.set({ "page.tab": nameOf(tab) }, true));
  on("tabs", "keydown", (event) => {
    const at = tabs.indexOf(document.activeElement);
    const next = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: -1 }[event.key];
    if (at < 0 || next === undefined) return;
    event.preventDefault();
    const tab = tabs.at(next % tabs.length);
    tab.focus();
    tab.click();
  });
  app.state.onChange(show);
  show();
}
