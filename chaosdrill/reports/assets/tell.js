// What is said of a point, in a sentence and in tables.

const make = (tag, attributes, ...children) => {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
  made.append(...children);
  return made;
};

const written = (value, digits = 6) => {
  if (Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const rounded = Number(value.toPrecision(digits));
  const text = rounded && Math.abs(rounded) < 1e-4 ? rounded.toExponential() : String(rounded);
  return text.replace(/-/g, "−");
};

const withUnit = (text, unit) => (unit ? `${text} ${unit}` : text);

const tableOf = (caption, head, rows) =>
  make(
    "table",
    {},
    make("caption", {}, caption),
    make("thead", {}, make("tr", {}, ...head.map((name) => make("th", { scope: "col" }, name)))),
    make(
      "tbody",
      {},
      ...rows.map(([first, ...rest]) =>
        make("tr", {}, make("th", { scope: "row" }, first), ...rest.map((cell) => make("td", { class: "number" }, cell))),
      ),
    ),
  );

const MOST_POINTS = 32;

class Teller {
  constructor(grid) {
    this.grid = grid;
  }

  place(indices) {
    return this.grid.axes.map((axis, k) => `${axis.name} = ${written(axis.values[indices[k]], 10)}`).join(", ");
  }

  sentence(indices, seed) {
    const { grid } = this;
    const cell = grid.cell(indices, seed);
    const [period, outcome] = [grid.period[cell], grid.outcomeOf(cell)];
    const parts = [`${this.place(indices)}${grid.seeds.length > 1 ? `, seed ${grid.seeds[seed]}` : ""}: ${outcome.words}`];
    if (period > 0) parts.push(`period ${period}`);
    const exponents = grid.find("lyapunov_exponent");
    if (exponents) {
      const listed = Array.from({ length: exponents.count }, (_, k) => written(exponents.values[cell * exponents.count + k], 4));
      parts.push(`Lyapunov exponents ${listed.join(", ")}`);
    }
    const points = grid.points(cell);
    if (grid.section) parts.push(points.length ? `${points.length} section points` : "no section points");
    return `${parts.join("; ")}.`;
  }

  tables(indices, seed) {
    const { grid } = this;
    const cell = grid.cell(indices, seed);
    const outcome = grid.outcomeOf(cell);
    const rows = grid.axes.map((axis, k) => [axis.label, written(axis.values[indices[k]], 12)]);
    if (grid.seeds.length > 1) rows.push(["seed", grid.seeds[seed]]);
    rows.push(["outcome", outcome.words], ["period", grid.period[cell] > 0 ? String(grid.period[cell]) : "none found"]);
    for (const one of grid.quantities) {
      if (one.count === 1 && !one.name.startsWith("lyapunov_")) {
        rows.push([one.label, withUnit(written(one.values[cell], one.name.includes("_error") ? 2 : 6), one.unit)]);
      }
    }
    const made = [tableOf("This point", ["quantity", "value"], rows)];
    const [exponents, errors] = [grid.find("lyapunov_exponent"), grid.find("lyapunov_error")];
    if (exponents) {
      const of = (array, k) => (array ? array.values[cell * exponents.count + k] : NaN);
      const listed = Array.from({ length: exponents.count }, (_, k) => [
        String(k + 1),
        written(of(exponents, k)),
        written(of(errors, k), 2),
      ]);
      made.push(tableOf("Lyapunov exponents", ["number", "exponent", "standard error"], listed));
    }
    if (outcome.advice) made.unshift(make("p", { class: "note" }, outcome.advice));
    return made;
  }

  // of a cycle one turn, of anything else its first points
  points(indices, seed) {
    const { grid } = this;
    const cell = grid.cell(indices, seed);
    const all = grid.points(cell);
    const period = grid.period[cell];
    const cycle = period > 0 && period <= all.length;
    const shown = all.slice(0, cycle ? Math.min(period, MOST_POINTS) : MOST_POINTS);
    const caption = cycle && shown.length === period ? `Section points of one cycle` : `Section points, ${shown.length} of ${all.length}`;
    const rows = shown.map((point, i) => [String(i + 1), ...Array.from(point, (value) => written(value))]);
    return { all, table: tableOf(caption, ["point", ...grid.states.map((state) => state.name)], rows) };
  }
}
