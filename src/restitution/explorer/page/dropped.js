// A file that is dropped onto the page, or opened: a table of a material, or a case.
import { element } from "./inputs.js";

export class Dropped {
  constructor(app, button, message) {
    Object.assign(this, { app, message });
    const field = element("input", { type: "file", hidden: true, accept: ".csv,.txt,.tsv,.dat,.toml,.json,.inp,.mat" });
    field.setAttribute("aria-label", "Open a file");
    button.after(field);
    button.addEventListener("click", () => field.click());
    field.addEventListener("change", () => {
      this.read(field.files[0]);
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
      this.read(event.dataTransfer.files[0]);
    });
  }

  async read(file) {
    if (!file) return;
    const most = this.app.schema.limits.file_characters;
    if (file.size > most) {
      this.show(`${file.name} has ${file.size} bytes; a file may have at most ${most}.`, true);
      return;
    }
    this.show(`Reading ${file.name} …`);
    try {
      this.app.backend.ask("file", { name: file.name, text: textOf(await file.arrayBuffer()), state: this.app.state.case() });
    } catch {
      this.show(`${file.name} cannot be read.`, true);
    }
  }

  receive(answer) {
    if (!answer.ok) {
      this.show(answer.error, true);
      return;
    }
    this.show([answer.words, ...(answer.notes ?? [])].join("\n"));
    this.app.state.set(answer.state, true);
  }

  show(words, bad = false) {
    this.message.textContent = words;
    this.message.dataset.bad = bad;
    this.message.hidden = !words;
  }
}

// Instruments write UTF-8, UTF-16 with a mark at its start, or Windows-1252.
function textOf(bytes) {
  const mark = new Uint8Array(bytes.slice(0, 2)).join();
  const encoding = { "255,254": "utf-16le", "254,255": "utf-16be" }[mark] ?? "utf-8";
  try {
    return new TextDecoder(encoding, { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}
