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
    document.addEventListener("dragenter", () => over(1));
    document.addEventListener("dragleave", () => over(-1));
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      over(-depth);
      if (event.dataTransfer.files.length) this.read(event.dataTransfer.files[0]);
    });
  }

  async read(file) {
    if (!file) return;
    const most = this.app.schema.limits.file_characters;
    if (file.size > most) {
      this.say(`${file.name} has ${file.size} bytes; a file may have at most ${most}.`, true);
      return;
    }
    this.say(`Reading ${file.name} …`);
    this.app.backend.ask("file", { name: file.name, text: await file.text(), state: this.app.state.case() });
  }

  receive(answer) {
    if (!answer.ok) {
      this.say(answer.error, true);
      return;
    }
    this.say([answer.words, ...(answer.notes ?? [])].join("\n"));
    this.app.state.set(answer.state, true);
  }

  say(words, bad = false) {
    this.message.textContent = words;
    this.message.dataset.bad = bad;
    this.message.hidden = !words;
  }
}
