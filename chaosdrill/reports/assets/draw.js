// Canvases: a frame with axes, dots of a diagram, cells of a chart, a section.

const theme = () => {
  const style = getComputedStyle(document.documentElement);
  const one = (name) => style.getPropertyValue(name).trim();
  return { ink: one("--ink"), faint: one("--line"), mark: one("--mark"), ground: one("--card"), quiet: one("--quiet") };
};

// the cell in which each pixel of a row or column lies
const places = (many, edges, at) =>
  Int32Array.from({ length: many }, (_, i) => {
    const value = at(i);
    let [low, high] = [0, edges.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (edges[middle] <= value) low = middle;
      else high = middle;
    }
    return low;
  });

class Frame {
  constructor(canvas, height) {
    this.canvas = canvas;
    this.ratio = window.devicePixelRatio || 1;
    this.width = Math.max(160, canvas.parentElement.clientWidth);
    this.height = Math.min(height, Math.max(180, Math.round(0.9 * this.width)));
    canvas.width = Math.round(this.width * this.ratio);
    canvas.height = Math.round(this.height * this.ratio);
    canvas.style.width = `${this.width}px`;
    canvas.style.height = `${this.height}px`;
    this.pen = canvas.getContext("2d");
    this.pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.box = { left: 74, right: this.width - 22, top: 10, bottom: this.height - 42 };
  }

  span(x, y) {
    [this.xs, this.ys] = [x, y];
    return this;
  }

  x(value) {
    return this.box.left + ((value - this.xs[0]) / (this.xs[1] - this.xs[0])) * (this.box.right - this.box.left);
  }

  y(value) {
    return this.box.bottom - ((value - this.ys[0]) / (this.ys[1] - this.ys[0])) * (this.box.bottom - this.box.top);
  }

  // the numbers at a place of the canvas
  at(left, top) {
    const across = (left - this.box.left) / (this.box.right - this.box.left);
    const up = (this.box.bottom - top) / (this.box.bottom - this.box.top);
    return [this.xs[0] + across * (this.xs[1] - this.xs[0]), this.ys[0] + up * (this.ys[1] - this.ys[0])];
  }

  axes(xLabel, yLabel) {
    const { pen, box } = this;
    const colours = theme();
    pen.strokeStyle = colours.quiet;
    pen.fillStyle = colours.ink;
    pen.lineWidth = 1;
    pen.font = "12px system-ui, sans-serif";
    pen.strokeRect(box.left, box.top, box.right - box.left, box.bottom - box.top);
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const tick of ticks(...this.xs, (box.right - box.left) / 80)) {
      pen.fillRect(this.x(tick.value), box.bottom, 1, 4);
      pen.fillText(tick.text, this.x(tick.value), box.bottom + 6);
    }
    pen.fillText(xLabel, (box.left + box.right) / 2, box.bottom + 24, box.right - box.left);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const tick of ticks(...this.ys, (box.bottom - box.top) / 45)) {
      pen.fillRect(box.left - 4, this.y(tick.value), 4, 1);
      pen.fillText(tick.text, box.left - 6, this.y(tick.value));
    }
    pen.save();
    pen.translate(11, (box.top + box.bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(yLabel, 0, 0, box.bottom - box.top);
    pen.restore();
  }

  // pairs one after the other in one array: x, y, x, y
  dots(pairs, colour, size) {
    this.pen.fillStyle = colour;
    for (let i = 0; i < pairs.length; i += 2) {
      this.pen.fillRect(this.x(pairs[i]) - size / 2, this.y(pairs[i + 1]) - size / 2, size, size);
    }
  }

  // every pixel has the colour of the cell in which it lies, also on an uneven grid
  cells(xs, ys, colour) {
    const { box, ratio } = this;
    const [left, top] = [Math.round(box.left * ratio), Math.round(box.top * ratio)];
    const [wide, high] = [Math.round(box.right * ratio) - left, Math.round(box.bottom * ratio) - top];
    const image = this.pen.createImageData(wide, high);
    const pixels = new Uint32Array(image.data.buffer);
    const [across, up] = [xs.length - 1, ys.length - 1];
    const painted = new Uint32Array(across * up);
    for (let i = 0; i < across; i++) for (let j = 0; j < up; j++) painted[i * up + j] = ink(colour(i, j));
    const column = places(wide, xs, (i) => this.at((left + i + 0.5) / ratio, 0)[0]);
    const row = places(high, ys, (j) => this.at(0, (top + j + 0.5) / ratio)[1]);
    for (let j = 0; j < high; j++) {
      for (let i = 0; i < wide; i++) pixels[j * wide + i] = painted[column[i] * up + row[j]];
    }
    this.pen.putImageData(image, left, top);
  }

  cross(x, y) {
    const { pen, box } = this;
    const line = (colour, width) => {
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.beginPath();
      pen.moveTo(this.x(x), box.top);
      pen.lineTo(this.x(x), box.bottom);
      if (y !== undefined) {
        pen.moveTo(box.left, this.y(y));
        pen.lineTo(box.right, this.y(y));
      }
      pen.stroke();
    };
    const colours = theme();
    line(colours.ground, 4);
    line(colours.mark, 1.5);
  }
}
