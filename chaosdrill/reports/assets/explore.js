// One chart: what it shows, where it points, and what answers to clicks and keys.

const SAID_AFTER_MS = 150;

class Explorer {
  constructor(root) {
    const held = root.querySelector("script.data");
    this.grid = new Grid(JSON.parse(held.textContent));
    this.teller = new Teller(this.grid);
    const part = (name) => root.querySelector(`.${name}`);
    [this.stage, this.chart, this.legend, this.readout] = ["stage", "chart", "legend", "readout"].map(part);
    [this.canvas, this.details] = [this.chart.querySelector("canvas"), part("details")];
    this.flat = this.grid.axes.length === 1;
    this.indices = this.grid.axes.map((axis) => axis.values.length >> 1);
    this.seed = 0;
    this.layer = document.createElement("canvas");
    this.controls(part("controls"));
    this.details.append((this.told = make("div", { class: "told" })), (this.plane = make("div", { class: "plane" })));
    this.stage.hidden = false;
    if (this.grid.section) this.sectionControls(root.id);
    this.listen();
    this.draw();
    this.tell(0);
  }

  // what the chart can show, each with its numbers by cell
  views() {
    const { grid } = this;
    const found = [];
    if (grid.section && this.flat) {
      grid.states.forEach((state, k) => found.push({ words: `section: ${state.label}`, label: state.label, state: k }));
    }
    if (!this.flat) found.push({ words: "period and outcome", label: "", kinds: true });
    for (const one of grid.quantities) {
      if (one.name === "lyapunov_error") continue;
      for (let k = 0; k < one.count; k++) {
        const words = one.count > 1 ? `${one.label} ${k + 1}` : one.label;
        found.push({ words, label: withUnit(words, one.unit && `(${one.unit})`), one, k, signed: one.name === "lyapunov_exponent" });
      }
    }
    if (this.flat) {
      const period = { values: Float32Array.from(grid.period), count: 1 };
      found.push({ words: "period", label: "period (0: none found)", one: period, k: 0 });
    }
    return found;
  }

  controls(place) {
    const { grid } = this;
    this.shown = this.views();
    this.view = this.shown[0];
    const choose = (words, options, change) => {
      const select = make("select", {}, ...options.map((text, i) => make("option", { value: i }, text)));
      select.addEventListener("change", () => change(Number(select.value)));
      place.append(make("label", {}, words, " ", select));
    };
    choose("Show", this.shown.map((view) => view.words), (i) => this.change({ view: this.shown[i] }));
    if (grid.seeds.length > 1) choose("Seed", grid.seeds, (seed) => this.change({ seed }));
    this.fields = grid.axes.map((axis, k) => {
      const field = make("input", { type: "number", step: "any", inputmode: "decimal" });
      field.addEventListener("change", () => {
        const wanted = field.valueAsNumber;
        if (Number.isFinite(wanted)) this.move(k, nearest(axis.values, wanted));
        this.fill();
      });
      place.append(make("label", {}, axis.label, " ", field));
      return field;
    });
  }

  sectionControls(key) {
    const names = this.grid.states.map((state) => state.label);
    this.picked = [0, Math.min(1, names.length - 1)];
    const controls = make("div", { class: "controls" });
    ["Across", "Up"].forEach((words, side) => {
      const options = names.map((text, i) => make("option", i === this.picked[side] ? { value: i, selected: "" } : { value: i }, text));
      const select = make("select", {}, ...options);
      select.addEventListener("change", () => {
        this.picked[side] = Number(select.value);
        this.drawSection();
      });
      controls.append(make("label", {}, words, " ", select));
    });
    this.small = make("canvas", { role: "img", "aria-describedby": `${key}-points` });
    this.listed = make("div", { id: `${key}-points`, class: "scroll", tabindex: "0", role: "group", "aria-label": "Section points" });
    this.plane.append(make("h4", {}, "Section at this point"), controls, make("div", { class: "small" }, this.small), this.listed);
  }

  listen() {
    const point = (event) => {
      const box = this.canvas.getBoundingClientRect();
      const found = this.frame.at(event.clientX - box.left, event.clientY - box.top);
      this.grid.axes.forEach((axis, k) => (this.indices[k] = nearest(axis.values, found[k])));
      this.moved();
    };
    this.canvas.addEventListener("click", point);
    this.canvas.addEventListener("pointermove", (event) => event.buttons === 1 && event.pointerType === "mouse" && point(event));
    this.chart.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.chart.clientWidth !== this.frame.width && this.change({})).observe(this.chart);
    for (const query of ["(prefers-color-scheme: dark)", "print"]) {
      window.matchMedia(query).addEventListener("change", () => this.change({}));
    }
  }

  key(event) {
    const steps = { ArrowRight: [0, 1], ArrowLeft: [0, -1], PageUp: [0, 10], PageDown: [0, -10] };
    Object.assign(steps, { Home: [0, -Infinity], End: [0, Infinity] });
    if (!this.flat) Object.assign(steps, { ArrowUp: [1, 1], ArrowDown: [1, -1] });
    const step = steps[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    this.move(step[0], this.indices[step[0]] + (event.shiftKey ? 10 : 1) * step[1]);
  }

  move(axis, index) {
    this.indices[axis] = Math.min(this.grid.axes[axis].values.length - 1, Math.max(0, index));
    this.moved();
  }

  moved() {
    this.point();
    this.tell(SAID_AFTER_MS);
  }

  change(what) {
    Object.assign(this, what);
    this.draw();
    this.tell(SAID_AFTER_MS);
  }

  draw() {
    const { grid, view } = this;
    const frame = (this.frame = new Frame(this.canvas, this.flat ? 320 : 460));
    const across = grid.axes[0];
    const edges = bounds(across.values);
    if (this.flat) {
      const pairs = this.pairs();
      const heights = pairs.filter((_, i) => i % 2);
      frame.span(extent(edges), widened(extent(heights), 0.03));
      const size = heights.length > 20000 ? 1 : heights.length > 2000 ? 1.5 : 3;
      frame.dots(pairs, theme().ink, size);
      frame.axes(across.label, view.label);
      this.legend.replaceChildren();
    } else {
      const up = grid.axes[1];
      const upper = bounds(up.values);
      frame.span(extent(edges), extent(upper));
      const colours = this.colours();
      frame.cells(edges, upper, (i, j) => colours(grid.cell([i, j], this.seed)));
      frame.axes(across.label, up.label);
    }
    this.layer.width = this.canvas.width;
    this.layer.height = this.canvas.height;
    this.layer.getContext("2d").drawImage(this.canvas, 0, 0);
    this.point();
  }

  // over one parameter: what is shown, as pairs of numbers one after the other
  pairs() {
    const { grid, view, seed } = this;
    const found = [];
    const add = (at, value) => Number.isFinite(value) && found.push(at, value);
    const [many, wide] = grid.section ? [grid.section.iterates, grid.states.length] : [0, 0];
    grid.axes[0].values.forEach((at, i) => {
      const cell = grid.cell([i], seed);
      if (view.one) add(at, view.one.values[cell * view.one.count + view.k]);
      else for (let k = cell * many; k < (cell + 1) * many; k++) add(at, grid.section.values[k * wide + view.state]);
    });
    return Float64Array.from(found);
  }

  // over two: the colour of each cell, and what the colours mean
  colours() {
    const { grid, view } = this;
    if (view.kinds) {
      const seen = new Map();
      grid.outcome.forEach((_, cell) => {
        const motion = grid.motion(cell);
        seen.set(motion.words, motion.colour);
      });
      const listed = [...seen].sort(([a], [b]) => a.localeCompare(b, "en", { numeric: true }));
      this.legend.replaceChildren(
        make("ul", {}, ...listed.map(([words, colour]) => {
          const swatch = make("span", { class: "swatch", "aria-hidden": "true" });
          swatch.style.backgroundColor = colour;
          return make("li", {}, swatch, words);
        })),
      );
      return (cell) => grid.motion(cell).colour;
    }
    const own = view.one.values.filter((_, i) => i % view.one.count === view.k);
    const scale = colourScale(own, grid.colours, view.signed);
    const bar = make("span", { class: "bar", "aria-hidden": "true" });
    bar.style.backgroundImage = `linear-gradient(to right, ${scale.colours.join(", ")})`;
    const middle = view.signed ? ", 0 in the middle" : "";
    this.legend.replaceChildren(make("p", {}, `${view.label}: ${written(scale.low, 3)} `, bar, ` ${written(scale.high, 3)}${middle}`));
    return (cell) => colourOf(scale, own[cell]);
  }

  // the mark over what has been drawn already
  point() {
    const { grid, frame, indices, view } = this;
    frame.pen.save();
    frame.pen.setTransform(1, 0, 0, 1, 0, 0);
    frame.pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    frame.pen.drawImage(this.layer, 0, 0);
    frame.pen.restore();
    const place = indices.map((index, k) => grid.axes[k].values[index]);
    frame.cross(...place);
    if (this.flat && !view.one) {
      const points = grid.points(grid.cell(indices, this.seed));
      frame.dots(points.flatMap((point) => [place[0], point[view.state]]), theme().mark, 4);
    }
    this.fill();
  }

  fill() {
    const plain = (value) => String(Number(value.toPrecision(12)));
    this.fields.forEach((field, k) => (field.value = plain(this.grid.axes[k].values[this.indices[k]])));
  }

  // the tables at once; the sentence, which is read aloud, when the point rests
  tell(delay) {
    this.told.replaceChildren(...this.teller.tables(this.indices, this.seed));
    if (this.grid.section) this.drawSection();
    clearTimeout(this.waiting);
    const say = () => (this.readout.textContent = this.teller.sentence(this.indices, this.seed));
    if (delay) this.waiting = setTimeout(say, delay);
    else say();
  }

  drawSection() {
    const { all, table } = this.teller.points(this.indices, this.seed);
    const [across, up] = this.picked.map((k) => this.grid.states[k].label);
    const pairs = all.flatMap((point) => this.picked.map((k) => point[k]));
    const frame = new Frame(this.small, 280);
    const spans = [0, 1].map((side) => widened(extent(pairs.filter((_, i) => i % 2 === side)), 0.06));
    frame.span(...spans).dots(pairs, theme().mark, 4);
    frame.axes(across, up);
    this.small.setAttribute("aria-label", `${all.length} section points at ${this.teller.place(this.indices)}: ${up} over ${across}`);
    this.listed.replaceChildren(table);
  }
}

document.querySelectorAll(".explorer").forEach((root) => new Explorer(root));
