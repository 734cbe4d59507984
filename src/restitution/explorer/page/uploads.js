// Files that are dropped onto the page, opened or pasted: a table of a material or of measured points, or a case with
// the tables that it names.
import { element } from "./elements.js";
import { pointsText } from "./measured.js";

export class Uploads {
  constructor(app, open, message) {
    Object.assign(this, { app, message });
    const field = element("input", { type: "file", hidden: true, multiple: true, ariaLabel: "Open a file",
      accept: ".csv,.txt,.tsv,.dat,.toml,.json,.inp,.mat,.xlsx" });
    open.after(field);
    open.addEventListener("click", () => field.click());
    field.addEventListener("change", () => {
      this.read(field.files);
      field.value = "";
    });
    let depth = 0;
    const over = (change) => {
      depth = Math.max(0, depth + change);
      document.body.classList.toggle("dropping", depth > 0);
    };
    // A text that is dragged is none of the page's business.
    const on = (kind, act) => document.addEventListener(kind, (event) => event.dataTransfer?.types.includes("Files") && act(event));
    on("dragenter", () => over(1));
    on("dragleave", () => over(-1));
    on("dragover", (event) => event.preventDefault());
    on("drop", (event) => {
      event.preventDefault();
      over(-depth);
      this.read(event.dataTransfer.files);
    });
    document.addEventListener("paste", (event) => {
      const text = event.clipboardData?.getData("text");
      if (text && !event.target.closest?.("input, textarea")) this.read([new File([text], "pasted.csv")]);
    });
  }

  // A case file comes first; tables that it names may be dropped with it.
  async read(list) {
    const files = [...list].sort((a, b) => b.name.endsWith(".toml") - a.name.endsWith(".toml"));
    if (!files.length) return;
    const names = files.map((file) => file.name).join(", ");
    const size = files.reduce((sum, file) => sum + file.size, 0);
    // The server would close the socket of a message that is longer.
    const { file_bytes: most } = this.app.schema.limits;
    if (size > most) {
      this.show(`${names}: ${size} bytes; the files may have at most ${most}.`, true);
      return;
    }
    this.show(`Reading ${names} …`);
    try {
      this.files = await Promise.all(files.map(async (file) => ({ name: file.name, data: base64(await file.arrayBuffer()) })));
    } catch {
      this.show(`${names}: cannot be read.`, true);
      return;
    }
    this.form = null;
    this.ask({});
  }

  ask(answers) {
    this.app.backend.ask("file", { files: this.files, answers, state: this.app.state.case() });
  }

  receive(answer) {
    if (!answer.ok) {
      this.show(answer.error, true, this.form);
      return;
    }
    const { questions, state, points, words, notes = [] } = answer;
    if (questions.length) this.form ??= this.formOf(questions);
    for (const { key, value } of questions) if (value) this.form.elements[key].value ||= value;
    this.show([words, ...notes].join("\n"), !state && !points, this.form);
    if (points) this.app.state.set({ "page.points": pointsText(points), "page.tab": "impact" }, true);
    if (state) this.app.state.set(state, true);
  }

  // What the files do not state is asked for, and may be changed afterwards.
  formOf(questions) {
    const fields = questions.map(({ key, words, options }) => {
      const choices = options && [["", "choose …"], ...options].map(([value, text]) => element("option", { value }, text));
      const field = choices ? element("select", { name: key }, ...choices) : element("input", { type: "text", name: key, autocomplete: "off" });
      return element("label", {}, `${words} `, field);
    });
    const form = element("form", { className: "questions" }, ...fields, element("button", {}, "Use the file"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.ask(Object.fromEntries(new FormData(form)));
    });
    return form;
  }

  show(words, bad = false, form = null) {
    this.message.replaceChildren(element("p", {}, words), ...(form ? [form] : []));
    this.message.dataset.bad = bad;
    this.message.hidden = !words;
  }
}

function base64(buffer) {
  const bytes = new Uint8Array(buffer);
  let text = "";
  for (let n = 0; n < bytes.length; n += 8192) text += String.fromCharCode(...bytes.subarray(n, n + 8192));
  return btoa(text);
}
