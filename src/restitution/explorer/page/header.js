// The header of the page: its tools, its tabs, and the keys for undo and redo.
import { element } from "./elements.js";
import { closing, download } from "./downloads.js";
import { ofBrowser } from "./storage.js";
import { setTheme } from "./theme.js";
import { systemNames } from "./units.js";

const $ = (id) => document.getElementById(id);

export function bindHeader(app) {
  const { state, schema } = app;
  $("case-title").textContent = schema.title ?? "";
  $("case-title").hidden = !schema.title;
  if (schema.title) document.title = `${schema.title} – Restitution explorer`;
  $("undo").addEventListener("click", () => state.undo());
  $("redo").addEventListener("click", () => state.redo());
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=text], textarea")) return;
    const key = event.key.toLowerCase();
    if (key === "z" && !event.shiftKey) state.undo();
    else if (key === "y" || (key === "z" && event.shiftKey)) state.redo();
    else return;
    event.preventDefault();
  });
  $("skip").addEventListener("click", (event) => {
    event.preventDefault();
    $("pictures").focus();
  });

  $("presets").append(...schema.presets.map((preset) => element("option", { value: preset.name }, preset.words)));
  $("presets").addEventListener("change", (event) => {
    const preset = schema.presets.find((one) => one.name === event.target.value);
    if (preset) state.set({ ...state.defaults, ...preset.state }, true);
    event.target.value = "";
  });
  $("units").append(...systemNames().map((name) => element("option", { value: name }, name)));
  $("units").addEventListener("change", (event) => state.set({ "page.units": event.target.value }, true));
  const chosen = ofBrowser.getItem("colours") ?? "auto";
  $("theme").value = chosen;
  setTheme(chosen);
  $("theme").addEventListener("change", (event) => {
    ofBrowser.setItem("colours", event.target.value);
    setTheme(event.target.value);
  });

  // A button shows for a moment what it did. A browser has a clipboard for pages of this machine and of https alone.
  const copy = async (button, text) => {
    const before = button.dataset.words ??= button.textContent;
    button.textContent = await navigator.clipboard?.writeText(text).then(() => "Copied", () => null) ?? "Not allowed here";
    setTimeout(() => {
      button.textContent = before;
    }, 1500);
  };
  $("copy-link").addEventListener("click", () => {
    state.commit();
    copy($("copy-link"), location.href);
  });
  const fetched = (what, act) => {
    app.downloaded = (answer, asked) => {
      if (!answer.ok) app.files.show(answer.error, true);
      else if (asked.what === what) act(answer);
    };
    app.backend.ask("download", { what, state: state.case() });
  };
  const program = () => (app.tab === "indentation" ? "indentation python" : "python");
  const further = () => (app.tab === "bounce" ? `print(rs.bounces(impact, gravity=${state.get("impact.gravity")}))\n` : "");
  $("copy-python").addEventListener("click", () => fetched(program(), ({ text }) => copy($("copy-python"), text + further())));
  $("download-case").addEventListener("click", () => {
    fetched(app.tab === "indentation" ? "indentation" : "case", ({ name, type, text }) => download(name, type, text));
  });
  closing($("save-menu"));
  bindTabs(app);
  bindSheet();
  const update = () => {
    if ($("undo").disabled === state.canUndo) $("undo").disabled = !state.canUndo;
    if ($("redo").disabled === state.canRedo) $("redo").disabled = !state.canRedo;
    const units = state.get("page.units") ?? "SI";
    if ($("units").value !== units) $("units").value = units;
  };
  state.onChange(update);
  update();
}

// On a narrow screen the settings are a sheet that opens.
function bindSheet() {
  const narrow = matchMedia("screen and (max-width: 860px)");
  const fit = () => {
    $("settings-box").open = !narrow.matches;
  };
  narrow.addEventListener("change", fit);
  fit();
}

function bindTabs(app) {
  const tabs = [...document.querySelectorAll("[role=tab]")].filter((tab) => tab.id.slice(4) in app.tabs);
  let shown = null;
  const show = () => {
    if (shown === app.tab) return;
    shown = app.tab;
    for (const tab of tabs) {
      const name = tab.id.slice(4);
      const chosen = name === app.tab;
      tab.setAttribute("aria-selected", chosen);
      tab.tabIndex = chosen ? 0 : -1;
      $(`view-${name}`).hidden = !chosen;
      if (chosen) $("heading").textContent = tab.textContent;
    }
  };
  for (const tab of tabs) tab.addEventListener("click", () => app.state.set({ "page.tab": tab.id.slice(4) }, true));
  $("tabs").addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const at = tabs.indexOf(document.activeElement);
    const next = event.key === "Home" ? 0 : event.key === "End" ? tabs.length - 1 : step ? (at + step + tabs.length) % tabs.length : -1;
    if (at < 0 || next < 0) return;
    event.preventDefault();
    tabs[next].focus();
    tabs[next].click();
  });
  app.state.onChange(show);
  show();
}
