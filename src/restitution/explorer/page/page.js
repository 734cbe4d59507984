// Puts the page together: schema, state, requests, tabs.
import { BounceTab } from "./bounce.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { describe } from "./description.js";
import { bindHeader } from "./header.js";
import { ImpactTab } from "./impact.js";
import { IndentationTab } from "./indentation.js";
import { Inputs } from "./inputs.js";
import { load } from "./interpolant.js";
import { Offline } from "./offline.js";
import { PaperTab } from "./paper.js";
import { Pins } from "./pins.js";
import { State } from "./state.js";
import { onTheme } from "./theme.js";
import { phrase, setSystem, setSystems } from "./units.js";
import { Uploads } from "./uploads.js";

const $ = (id) => document.getElementById(id);
const LIVE = document.querySelector('meta[name="restitution"]').content === "live";
// What each tab asks for, what it draws, and the numbers of the line at the top of a narrow screen.
const NEEDED = { impact: ["impact"], paper: ["impact", "paper"], bounce: ["bounces"], indentation: ["indentation"] };
const DRAWN = { ...NEEDED, impact: ["impact", "velocity", "surface"], paper: ["impact"] };
const STRIP = {
  impact: ["restitution_coefficient", "contact_time", "max_force"],
  bounces: ["n_bounces", "drop_height", "total_time"],
  indentation: ["max_force", "max_indentation_depth", "work"],
};
const REST = 140;

class App {
  constructor() {
    this.last = {};
    this.asked = {};
    this.problems = {};
    this.numbers = null;
    document.documentElement.dataset.mode = LIVE ? "live" : "static";
    if (LIVE) this.backend = new Connection((answer, asked) => this.receive(answer, asked), (word) => this.report(word));
    else this.startOffline();
  }

  async startOffline() {
    const [schema, claims] = await Promise.all(["schema", "paper"].map(async (name) => (await fetch(`static/${name}.json`)).json()));
    this.paper = await load("static/interpolant.json");
    this.backend = new Offline(schema, this.paper, claims, (answer, asked) => this.receive(answer, asked));
    this.start(schema);
  }

  start(schema) {
    this.schema = schema;
    setSystems(schema.units);
    this.state = new State(new Inputs(schema.inputs), schema.state);
    setSystem(this.state.get("page.units"));
    describe(this);
    this.pins = new Pins($("compare"), this.state, schema.outputs, (kind, values, channel) =>
      this.backend.ask(kind, { state: this.state.case(values) }, channel));
    $("pin-place").replaceWith(this.pins.button);
    this.tabs = {
      impact: new ImpactTab($("view-impact"), this),
      paper: new PaperTab($("view-paper"), this),
      ...(LIVE ? { bounce: new BounceTab($("view-bounce"), this), indentation: new IndentationTab($("view-indentation"), this) } : {}),
    };
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
    const own = ["page.units", "page.pins", "page.tab"].map((key) => this.state.get(key)).join();
    const values = this.state.case();
    const text = JSON.stringify(values);
    for (const kind of NEEDED[this.tab]) {
      if (kind === "paper" ? this.last.paper : this.asked[kind] === text) continue;
      this.asked[kind] = text;
      this.backend.ask(kind, { state: values });
    }
    if (own !== this.own) {
      this.own = own;
      setSystem(this.state.get("page.units"));
      this.redraw();
      this.further();
    }
    this.showProblem();
  }

  receive(answer, asked) {
    if (answer.kind === "schema") {
      if (!this.schema) this.start(answer);
      return;
    }
    if (!asked) return;
    if (answer.kind === "file") this.files.receive(answer);
    else if (answer.kind === "download") this.downloaded?.(answer, asked);
    else if (asked.channel !== "main") {
      if (this.pins.receive(answer, asked.channel)) this.redraw();
    } else this.receiveOwn(answer, asked);
  }

  receiveOwn(answer, asked) {
    // A surface belongs to one impact, and the page can do without it.
    if (answer.kind === "surface" && !(answer.ok && asked.state === this.solved)) return;
    this.problems[answer.kind] = answer.ok ? null : answer;
    if (answer.ok) {
      this.last[answer.kind] = answer;
      if (answer.kind === "impact") {
        this.solved = asked.state;
        this.last.surface = null;
      }
      this.draw(answer);
      if (answer.kind === "impact") this.further();
    }
    this.showProblem();
  }

  draw(answer) {
    if (answer.kind === "impact") {
      this.numbers = answer.numbers;
      if (this.tab === "paper") this.tabs.paper.draw();
      else if (this.tab === "impact") this.tabs.impact.receive(answer);
    } else if (answer.kind === "velocity" || answer.kind === "surface") this.tabs.impact.receive(answer);
    else if (answer.kind === "paper") this.tabs.paper.receive(answer);
    else if (answer.kind === "bounces") this.tabs.bounce.receive(answer);
    else if (answer.kind === "indentation") this.tabs.indentation.receive(answer);
    if (answer.kind === NEEDED[this.tab][0]) this.showNumbers(answer.kind, answer.numbers);
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
    const [own] = NEEDED[this.tab];
    if (!this.last[own]) this.showNumbers(own, null);
  }

  // A solve that fails shows its one line; the last good picture stays, greyed.
  showProblem() {
    const bad = DRAWN[this.tab].map((kind) => this.problems[kind]).find(Boolean);
    const box = $("problem");
    box.hidden = !bad;
    if (bad && box.textContent !== bad.error) box.textContent = bad.error;
    // Without a server, numbers may be those of other inputs.
    const gone = document.documentElement.dataset.connection ?? "open";
    $(`view-${this.tab}`).classList.toggle("stale", Boolean(bad) || gone !== "open");
    this.controls.fault(bad?.field, bad?.error ?? "");
  }

  // Words of an address that are no input are named.
  showIgnored() {
    const { ignored } = this.state;
    if (!ignored.length) return;
    const words = `The address has what the page cannot read, and leaves it out: ${ignored.slice(0, 5).join(", ")}${ignored.length > 5 ? ", …" : ""}.`;
    $("address-message").textContent = words;
    $("address-message").hidden = false;
  }

  // The numbers of the tab in the table of pinned settings and in the strip; `numbers` is null where none are there.
  showNumbers(kind, numbers) {
    const { outputs } = this.schema;
    this.pins.table(kind, numbers);
    const shown = STRIP[kind].filter((name) => numbers?.[name] !== undefined);
    $("strip").hidden = !shown.length;
    $("strip").textContent = shown.map((name) => `${outputs[name].symbol.replace("_max", "")} = ${phrase(numbers[name], outputs[name])}`).join("   ");
  }

  report(word) {
    const box = $("connection");
    const words = {
      open: "",
      closed: "The server does not answer. The page tries again; the pictures show the last answers.",
      refused: "The server does not answer this page. If it was started anew, open the address that the terminal shows: this page then goes on if its name and port are the same.",
    }[word];
    box.textContent = words;
    box.hidden = !words;
    document.documentElement.dataset.connection = word;
    if (this.controls) this.showProblem();
  }
}

window.explorer = new App();
