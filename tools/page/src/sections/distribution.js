// The distribution of the residuals against the noise that is claimed.
import { chart, h, key } from "../dom.js";
import { themeColour } from "../colour.js";
import { count, digits, isNumber, px } from "../numbers.js";
import { bars, lineChart, spline } from "../plot/lines.js";

const BINS = 41;
const END = 4.5;  // standard deviations shown to each side

// Residual coordinates divided by their claimed standard deviation, or by their own spread.
function scaled(data, used) {
  const own = Math.sqrt(used.reduce((sum, c) => sum + c.size ** 2, 0) / (2 * used.length));
  const hasClaim = isNumber(data.noise_px) || used.some((corner) => corner.sd > 0);
  const sdOf = (corner) => corner.sd || data.noise_px || own || 1;
  const values = used.flatMap((corner) => [corner.du / sdOf(corner), corner.dv / sdOf(corner)]);
  return { values, hasClaim, spread: Math.sqrt(values.reduce((sum, z) => sum + z * z, 0) /
    values.length) };
}

function histogram(values) {
  const width = 2 * END / BINS;
  const centres = Array.from({ length: BINS }, (_, bin) => -END + (bin + 0.5) * width);
  const counts = new Array(BINS).fill(0);
  for (const z of values) {
    const bin = Math.floor((z + END) / width);
    if (bin >= 0 && bin < BINS) counts[bin] += 1;
  }
  const normal = centres.map((z) =>
    values.length * width * Math.exp(-z * z / 2) / Math.sqrt(2 * Math.PI));
  return { centres, counts, normal };
}

// What the chart shows, as a sentence.
function judgement({ values, spread, hasClaim }) {
  const share = (test) => `${digits(100 * values.filter(test).length / values.length, 2)} %`;
  const within = share((z) => Math.abs(z) <= 1);
  const beyond = share((z) => Math.abs(z) > 3);
  const shares = `${within} lie within 1 sd (noise: 68 %), ${beyond} beyond 3 sd (noise: 0.27 %).`;
  if (!hasClaim) return `No noise was claimed; the line has the spread of the residuals. ${shares}`;
  const words = spread > 1.25 ? "more than claimed: the model does not fit, or the noise is larger"
    : spread < 0.8 ? "less than claimed: the noise was overestimated" : "as claimed";
  return `The spread is ${digits(spread, 2)} × the claimed noise, ${words}. ${shares}`;
}

export function distribution(data, used) {
  const all = scaled(data, used);
  const { centres, counts, normal } = histogram(all.values);
  const outside = all.values.filter((z) => Math.abs(z) > END).length;
  const plot = lineChart(() => ({
    x: { label: "residual / claimed standard deviation" },
    y: { label: "coordinates", values: (_, ticks) => ticks.map((n) => count(n, "", "").trim()) },
    scales: { x: { time: false, range: [-END, END] },
              y: { range: (_, low, high) => [0, 1.05 * Math.max(high, ...normal)] } },
    series: [
      { label: "residuals", paths: bars(), fill: themeColour("--sky"), points: { show: false } },
      { label: "noise", paths: spline(), stroke: themeColour("--vermilion"), width: 2.5,
        points: { show: false } },
    ],
    data: [centres, counts, normal],
  }));
  const sd = data.noise_px;
  return chart({
    name: "distribution", marks: all.values.length, title: "Against the claimed noise",
    label: `Histogram of ${count(all.values.length, "residual coordinate")}`,
    read: "bars should fill the line. Wider bars: the noise is larger than claimed, or the model " +
      `does not fit. ${judgement(all)}`,
  }, plot, h("p", { class: "legend" }, key("bar-residuals", "residuals, x and y"),
    key("line-noise", isNumber(sd) ? `claimed noise (sd ${px(sd)})` : "claimed noise"),
    outside ? h("span", { class: "note" }, `${outside} beyond ${END} sd`) : null));
}
