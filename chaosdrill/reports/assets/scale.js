// From numbers to places and colours.

const extent = (values) => {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return [0, 1];
  const margin = low === high ? 0.05 * Math.abs(low) || 0.5 : 0;
  return [low - margin, high + margin];
};

const widened = ([low, high], part) => [low - part * (high - low), high + part * (high - low)];

// bounds of the cells around ascending values
const bounds = (values) => {
  const n = values.length;
  if (n === 1) return extent(values);
  const found = [(3 * values[0] - values[1]) / 2];
  for (let i = 1; i < n; i++) found.push((values[i - 1] + values[i]) / 2);
  found.push((3 * values[n - 1] - values[n - 2]) / 2);
  return found;
};

const nearest = (values, wanted) => {
  let [low, high] = [0, values.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle;
  }
  return Math.abs(values[high] - wanted) < Math.abs(wanted - values[low]) ? high : low;
};

const ticks = (low, high, most) => {
  const rough = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough) || rough;
  const digits = Math.max(0, Math.min(15, -Math.floor(Math.log10(step) + 1e-9)));
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step && found.length < 50; i++) {
    const large = Math.abs(i * step) >= 1e6;
    found.push({ value: i * step, text: (large ? (i * step).toPrecision(3) : (i * step).toFixed(digits)).replace("-", "−") });
  }
  return found;
};

// the few values beyond this part on either side do not set the scale
const COVERED = 0.99;

const quantile = (values, part) => {
  const sorted = Float64Array.from(values).sort();
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] : 0;
};

// around zero where the sign matters, each side with a scale of its own; else from least to largest
const colourScale = (values, colours, signed) => {
  const finite = Array.from(values).filter(Number.isFinite);
  if (!signed) {
    const [low, high] = extent(finite);
    const part = (value) => (value - low) / (high - low);
    return { low, high, colours: colours.sequential, part };
  }
  const below = quantile(finite.filter((v) => v < 0).map((v) => -v), COVERED);
  const above = quantile(finite.filter((v) => v > 0), COVERED);
  const [low, high] = [below || above || 1, above || below || 1];
  const part = (value) => (value < 0 ? 0.5 + value / (2 * low) : 0.5 + value / (2 * high));
  return { low: -low, high, colours: colours.diverging, part };
};

const colourOf = (scale, value) => {
  if (Number.isNaN(value)) return null;
  const last = scale.colours.length - 1;
  return scale.colours[Math.round(last * Math.min(1, Math.max(0, scale.part(value))))];
};

// a colour as the four bytes of a pixel; what has none is seen through
const ink = (hex) => {
  if (!hex) return 0;
  const [red, green, blue] = [1, 3, 5].map((start) => parseInt(hex.slice(start, start + 2), 16));
  return new Uint32Array(Uint8Array.of(red, green, blue, 255).buffer)[0];
};
