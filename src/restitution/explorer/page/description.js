// The descriptions of one case, and how one follows from another: constants and the paper's numbers, mass and density.
const clipped = (value, input) => Math.min(Math.max(value, input.low), input.high);
const short = (value) => Number(value.toPrecision(6));

export function describe(app) {
  const { state } = app;
  const value = (key) => state.get(key);
  const input = (key) => state.byKey.get(key);
  const onSlider = (key, number) => clipped(number, input(key));
  const volume = () => (4 * Math.PI * value("body.radius") ** 3) / 3;

  const mass = () => {
    return value("mass_from") === "density" ? value("body.density") * volume() : value("body.mass");
  };
  // The constants of the standard solid with these numbers, for the present body and equilibrium modulus.
  const constants = (p2, p3) => {
    const end = value("material.equilibrium_modulus");
    const unit = ((mass() ** 2 * end ** 3) / (value("impact.velocity") * value("body.radius"))) ** 0.2;
    return { "material.branch_modulus": short(end / p2), "material.viscosity": short(p3 * unit) };
  };
  const groups = () => {
    const { nu, p2, p3 } = app.numbers ?? {};
    if (!Number.isFinite(p2) || !Number.isFinite(p3)) return null;
    return { "groups.nu": short(nu), "groups.p2": short(onSlider("groups.p2", p2)), "groups.p3": short(onSlider("groups.p3", p3)) };
  };

  app.useGroups = () => state.set({ ...groups(), entry: "groups" }, true);

  // Goes to a point of the paper's plane; the description of the case stays as it is.
  app.goTo = (p2, p3, done) => {
    const [x, y] = [onSlider("groups.p2", p2), onSlider("groups.p3", p3)].map((number) => Number(number.toPrecision(3)));
    if (value("entry") === "groups") state.set({ "groups.p2": x, "groups.p3": y }, done);
    else if (groups()) state.set(constants(x, y), done);
    else state.set({ entry: "groups", "groups.p2": x, "groups.p3": y }, done);
  };

  // Half the width and half the height of a round body, else null. Of all ellipsoids with the curvatures of the
  // contact, the one that is drawn is circular around its long axis.
  app.body = () => {
    const shown = (key) => input(key) && state.shown(input(key));
    if (shown("body.radius")) return [value("body.radius"), value("body.radius")];
    if (!shown("profile.radius_1")) return null;
    const radii = [value("profile.radius_1"), value("profile.radius_2")];
    return [Math.sqrt(radii[0] * radii[1]), Math.min(...radii)];
  };

  app.second = () => (value("target") === "ball" ? value("counter_body.radius") : null);

  // What a choice of a description sets, too.
  input("entry").convert = (choice) => (choice === "groups" ? groups() : {
    "material.model": "standard_solid", bulk: "poisson_ratio", "material.poisson_ratio": value("groups.nu"),
    ...constants(value("groups.p2"), value("groups.p3")),
  });
  input("mass_from").convert = (choice) =>
    (choice === "density" ? { "body.density": short(mass() / volume()) } : { "body.mass": short(mass()) });
}
