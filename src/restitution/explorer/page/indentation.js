// The tab of a prescribed indentation: a triangle or a hold, as an atomic force microscope makes it.
import { picture } from "./curves.js";
import { element } from "./elements.js";
import { Notes, Numbers } from "./numbers.js";
import { Panel } from "./panel.js";
import { phrase } from "./units.js";

const TILES = ["max_force", "max_indentation_depth", "max_contact_radius", "residual_indentation_depth", "contact_end_time", "work"];

export class IndentationTab {
  constructor(root, app) {
    this.app = app;
    this.numbers = new Numbers(root, TILES, app.schema.outputs);
    this.loop = new Panel({ name: "force-depth", title: "Force over depth" });
    this.force = new Panel({ name: "force-time", title: "Force over time" });
    this.depth = new Panel({ name: "depth-time", title: "Depth over time" });
    this.radius = new Panel({ name: "radius-time", title: "Contact radius over time" });
    const grid = element("div", { className: "grid" }, this.loop.root, this.force.root, this.depth.root, this.radius.root);
    root.append(grid);
    this.notes = new Notes(grid);
  }

  receive(answer) {
    const { outputs } = this.app.schema;
    const pinned = this.app.pins.of("indentation");
    const sets = [{ table: answer.curves.history }, ...pinned.map((pin) => ({ ...pin, table: pin.answer.curves.history }))];
    this.numbers.show(answer.numbers);
    const { max_force: force, max_indentation_depth: depth, residual_indentation_depth: rest } = answer.numbers;
    this.loop.show({ ...picture(sets, "indentation_depth", [{ name: "force" }], outputs, { xRoom: true }),
      summary: `The largest force is ${phrase(force, outputs.max_force)} at a depth of up to ${phrase(depth, outputs.max_indentation_depth)}.` });
    this.force.show({ ...picture(sets, "time", [{ name: "force" }], outputs), summary: `The largest force is ${phrase(force, outputs.max_force)}.` });
    this.depth.show({ ...picture(sets, "time", [{ name: "indentation_depth" }], outputs), summary: `The depth at separation is ${phrase(rest, outputs.max_indentation_depth)}.` });
    this.radius.root.hidden = !answer.curves.history.contact_radius.some((one) => one !== null);
    this.radius.show(picture(sets, "time", [{ name: "contact_radius" }], outputs));
    this.notes.show(answer.warnings ?? [], [answer.status?.message, ...(answer.notes ?? [])]);
  }
}
