// What the page holds of a diagram or chart: a grid of points, with sections where there are any.

const numbers = (text, Type) => {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new Type(bytes.buffer);
};

class Grid {
  constructor(data) {
    Object.assign(this, { kind: data.kind, name: data.name, seeds: data.seeds, states: data.states });
    Object.assign(this, { outcomes: data.outcomes, periodColours: data.periods, colours: data.colours });
    this.axes = data.axes.map((axis) => ({ ...axis, values: numbers(axis.values, Float64Array) }));
    this.outcome = numbers(data.outcome, Int8Array);
    this.period = numbers(data.period, Int16Array);
    this.quantities = data.quantities.map((one) => ({ ...one, values: numbers(one.values, Float32Array) }));
    this.section = data.section
      ? { iterates: data.section.iterates, values: numbers(data.section.values, Float32Array) }
      : null;
  }

  // place in the arrays of the run at these indices of the axes, from this seed
  cell(indices, seed) {
    const point = indices.reduce((sum, index, k) => sum * this.axes[k].values.length + index, 0);
    return point * this.seeds.length + seed;
  }

  find(name) {
    return this.quantities.find((one) => one.name === name);
  }

  // states of the run's section points, without those that the archive does not have
  points(cell) {
    if (!this.section) return [];
    const [many, wide] = [this.section.iterates, this.states.length];
    const found = [];
    for (let i = 0; i < many; i++) {
      const start = (cell * many + i) * wide;
      const point = this.section.values.subarray(start, start + wide);
      if (point.every(Number.isFinite)) found.push(point);
    }
    return found;
  }

  outcomeOf(cell) {
    const code = this.outcome[cell];
    const known = this.outcomes.find((one) => one.code === code);
    return known || { code, words: `code ${code}`, advice: "", colour: "#CC79A7" };
  }

  // a cycle has a period; what else ended well or not has only an outcome
  motion(cell) {
    const [period, outcome] = [this.period[cell], this.outcomeOf(cell)];
    if (!["ok", "periodic"].includes(outcome.words)) return outcome;
    if (period <= 0) return { words: "period not found", colour: outcome.colour };
    const colour = this.periodColours[Math.min(period, this.periodColours.length) - 1];
    const longer = period >= this.periodColours.length;
    return { words: longer ? `period ${this.periodColours.length} or more` : `period ${period}`, colour };
  }
}
