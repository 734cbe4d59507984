// Puts the page together: schema, state, requests, tabs.
import { LocalAnswers } from "./answers.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { describe } from "./description.js";
import { bindHeader } from "./header.js";
import { ImpactTab } from "./impact.js";
import { load } from "./interpolant.js";
import { BounceTab, IndentationTab, TappingTab } from "./motions.js";
import { PaperTab } from "./paper.js";
import { Pins } from "./pins.js";
import { State } from "./state.js";
import { onTheme } from "./theme.js";
import { phrase, setSystem, setSystems } from "./units.js";
import { Uploads } from "./uploads.js";

const $ = (id) => document.getElementById(id);
const LIVE = document.querySelector('meta[name="restitution"]').content === "live";
// What each tab asks for, what it draws, the tab of each answer, and the numbers of the line at the top of a narrow
// screen.
const NEEDED = { impact: ["impact"], paper: ["impact", "paper"], bounce: ["bounces"], indentation: ["indentation"], tapping: ["tapping"] };
const DRAWN = { ...NEEDED, impact: ["impact", "velocity", "surface"], paper: ["impact"] };
const TAB_OF = { impact: "impact", velocity: "impact", surface: "impact", paper: "paper", bounces: "bounce", indentation: "indentation", tapping: "tapping" };
const STRIP = {
  impact: ["restitution_coefficient", "contact_time", "max_force"],
  bounces: ["n_bounces", "drop_height", "total_time"],
  indentation: ["max_force", "max_indentation_depth", "work"],
  tapping: ["amplitude", "phase", "max_force"],
};
const CONNECTION = {
  open: "",
  closed: "The server does not answer. The page tries again; the pictures show the last answers.",
  refused: "The server does not answer this page. If it was started anew, open the address that the terminal shows: this page then goes on if its name and port are the same.",
};
const REST = 140;
// Answers that take so long that they wait until the sliders rest.
const SLOW = new Set(["tapping"]);

class App {
  constructor() {
    Object.assign(this, { last: {}, asked: {}, problems: {}, numbers: null });
    document.documentElement.dataset.mode = LIVE ? "live" : "static";
    if (LIVE) this.backend = new Connection((answer, asked) => this.receive(answer, asked), (word) => this.report(word));
    else this.startAlone();
  }

  async startAlone() {
    const [schema, claims] = await Promise.all(["schema", "paper"].map(async (name) => (await fetch(`static/${name}.json`)).json()));
    this.paper = await load("static/interpolant.json");
    this.backend = new LocalAnswers(schema, this.paper, claims, (answer, asked) => this.receive(answer, asked));
    this.start(schema);
  }

  start(schema) {
    this.schema = schema;
    setSystems(schema.units);
    this.state = new State(schema.inputs, schema.state);
    setSystem(this.state.get("page.units"));
    describe(this);
    this.pins = new Pins($("compare"), this.state, schema.outputs, (kind, values, channel) =>
      this.backend.ask(kind, { state: this.state.case(values) }, channel));
    $("pin-place").replaceWith(this.pins.button);
    const tabs = { impact: ImpactTab, paper: PaperTab, ...(LIVE && { bounce: BounceTab, indentation: IndentationTab, tapping: TappingTab }) };
    this.tabs = Object.fromEntries(Object.entries(tabs).map(([name, Tab]) => [name, new Tab($(`view-${name}`), this)]));
    // The request goes out before the page changes.
    this.state.onChange(() => this.changed());
    addEventListener("hashchange", () => {
      $("address-message").hidden = true;
      this.showIgnored();
    });
    this.controls = new Controls(schema, this.state, $("settings"), () => this.tab);
    if (LIVE) {
      this.files = new Uploads(this, $("open-file"), $("file-message"));
      load("static/interpolant.json").then((paper) => {
        this.paper = paper;
        this.redraw();
      });
    }
    bindHeader(this);
    this.showIgnored();
    onTheme(() => this.redraw());
    this.changed();
  }

  get tab() {
    const name = this.state.get("page.tab");
    return Object.hasOwn(this.tabs, name) ? name : "impact";
  }

  // Asks for what the tab shows, if the case is another one; the page's own keys only draw again.
  changed() {
    const look = ["page.units", "page.pins", "page.points", "page.tab"].map((key) => this.state.get(key)).join();
    const values = this.state.case();
    const text = JSON.stringify(values);
    for (const kind of NEEDED[this.tab]) {
      if (kind === "paper" ? this.last.paper : this.asked[kind] === text) continue;
      this.asked[kind] = text;
      clearTimeout(this.waiting);
      const ask = () => this.backend.ask(kind, { state: values });
      if (SLOW.has(kind)) this.waiting = setTimeout(ask, REST);
      else ask();
    }
    if (look !== this.look) {
      this.look = look;
      setSystem(this.state.get("page.units"));
      this.redraw();
      this.further();
    }
    this.showProblem();
  }

  receive(answer, asked) {
    if (answer.kind === "schema") {
      if (!this.schema) this.start(answer);
    } else if (!asked) return;
    else if (answer.kind === "file") this.files.receive(answer);
    else if (answer.kind === "download") this.downloaded?.(answer, asked);
    else if (asked.channel === "main") this.receivePresent(answer, asked);
    else if (this.pins.receive(answer, asked.channel)) this.redraw();
  }

  receivePresent(answer, asked) {
    const { kind, ok } = answer;
    // A surface belongs to one impact, and the page can do without it.
    if (kind === "surface" && !(ok && asked.state === this.solved)) return;
    this.problems[kind] = ok ? null : answer;
    if (ok) {
      this.last[kind] = answer;
      if (kind === "impact") {
        this.solved = asked.state;
        this.last.surface = null;
      }
      this.draw(answer);
      if (kind === "impact") this.further();
    }
    this.showProblem();
  }

  draw(answer) {
    const { kind } = answer;
    if (kind === "impact") this.numbers = answer.numbers;
    if (kind === "impact" && this.tab === "paper") this.tabs.paper.draw();
    else if (kind !== "impact" || this.tab === "impact") this.tabs[TAB_OF[kind]].receive(answer);
    if (kind === NEEDED[this.tab][0]) this.showNumbers(kind, answer.numbers);
  }

  // What costs more follows the numbers: e over velocity at once, the surface when the sliders rest.
  further() {
    clearTimeout(this.resting);
    const { solved: state } = this;
    if (!state || this.tab !== "impact") return;
    const { "impact.velocity": velocity, ...others } = state;
    const text = JSON.stringify(others);
    if (text !== this.asked.velocity) {
      this.asked.velocity = text;
      this.backend.ask("velocity", { state });
    }
    const { history, shape } = this.last.impact.curves ?? {};
    if (history && shape && !this.last.surface) this.resting = setTimeout(() => this.backend.ask("surface", { state }), REST);
  }

  redraw() {
    for (const kind of DRAWN[this.tab]) if (this.last[kind]) this.draw(this.last[kind]);
    if (this.tab === "paper") this.tabs.paper.draw();
    const [kind] = NEEDED[this.tab];
    if (!this.last[kind]) this.showNumbers(kind, null);
  }

  // A solve that fails, or an input that the server refuses, shows its one line; the last good picture stays, greyed.
  showProblem() {
    const problem = DRAWN[this.tab].map((kind) => this.problems[kind]).find(Boolean);
    this.message("problem", problem?.error);
    // Without a server, numbers may be those of other inputs.
    const connection = document.documentElement.dataset.connection ?? "open";
    $(`view-${this.tab}`).classList.toggle("stale", Boolean(problem) || connection !== "open");
    this.controls.fault(problem?.field, problem?.error ?? "");
  }

  // Words of an address that are no input are named.
  showIgnored() {
    const { ignored } = this.state;
    if (!ignored.length) return;
    this.message("address-message",
      `The address has what the page cannot read, and leaves it out: ${ignored.slice(0, 5).join(", ")}${ignored.length > 5 ? ", …" : ""}.`);
  }

  // The numbers of the tab in the table of pinned settings and in the strip; `numbers` is null where none are there.
  showNumbers(kind, numbers) {
    const { outputs } = this.schema;
    this.pins.table(kind, numbers);
    const shown = STRIP[kind].filter((name) => numbers?.[name] !== undefined);
    this.message("strip", shown.map((name) => `${outputs[name].symbol.replace("_max", "")} = ${phrase(numbers[name], outputs[name])}`).join("   "));
  }

  report(word) {
    this.message("connection", CONNECTION[word]);
    document.documentElement.dataset.connection = word;
    if (this.controls) this.showProblem();
  }

  // The words of a line of the page, which is hidden without any.
  message(id, words = "") {
    $(id).hidden = !words;
    if ($(id).textContent !== words) $(id).textContent = words;
  }
}

window.explorer = new App();
