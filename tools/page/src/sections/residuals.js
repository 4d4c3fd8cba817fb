// Residuals (observed minus reprojected): as vectors, and their mean over the image.
import { chart, h, key, section } from "../dom.js";
import { CIVIDIS, colourAt, css } from "../colour.js";
import { count, digits, niceBelow, px, quantile } from "../numbers.js";
import { corners, usedCorners } from "../data.js";
import { crosses, dots, imageFrame, strokes } from "../plot/frame.js";
import { colourBar, colourScale } from "../plot/heatmap.js";
import { s } from "../dom.js";
import { distribution } from "./distribution.js";
import { profile } from "./profile.js";

const FEW = 4;  // corners in a cell below which its size says little
const CROWDED = 3000;  // corners from which on vectors are drawn smaller
const CHANCE = 0.01;  // probability that noise alone makes a mean count as different from zero

// How much longer than true the vectors are drawn: the largest ones get this share of the width.
function magnification(sizes, width, share) {
  const large = quantile(sizes, 0.95);
  return large > 0 ? niceBelow(width * share / large) : 1;
}

// A line of a round length in pixels, for scale.
function scaleBar(factor, width) {
  const length = niceBelow(width * 0.16 / factor);
  const share = 100 * length * factor / width;
  return h("p", { class: "legend" },
    h("span", { class: "scale-bar", style: `width: ${share.toFixed(2)}%` }),
    ` ${digits(length, 1)} px, drawn ${factor >= 1 ? digits(factor, 1) : factor} × as long`);
}

function vectorPlot(data, used) {
  const [width] = data.image_size;
  const crowd = Math.min(1, Math.sqrt(CROWDED / used.length));  // shorter where there are many
  const factor = magnification(used.map((corner) => corner.size), width, 0.035 * crowd);
  const lines = used.map(({ u, v, du, dv }) => [u, v, factor * du, factor * dv]);
  const rejected = corners(data).filter((corner) => corner.rejected);
  return chart({
    name: "residual-vectors", marks: used.length, title: "As vectors",
    label: `${count(used.length, "residual")}, drawn as lines over the image`,
    read: "each line starts at a corner and points to where it was seen, away from where the " +
      "camera puts it. Good: no order. Lines that turn or point the same way in a part of the " +
      "image show a lens model or a board that does not fit.",
  }, imageFrame(data.image_size, strokes(lines, crowd < 1 ? "vector crowded" : "vector"),
    dots(used.map(({ u, v }) => [u, v]), crowd < 1 ? "base crowded" : "base"),
    crosses(rejected.map(({ u, v }) => [u, v]), width / 120, "rejected")),
  scaleBar(factor, width),
  rejected.length ? h("p", { class: "legend" },
    key("cross-rejected", `${count(rejected.length, "corner")} rejected, without a line`)) : null);
}

// F test of a mean of n residuals with equal noise in x and y: F(2, m), m = 2 (n - 1), whose
// upper quantile is m / 2 (p^(-2 / m) - 1).
function differsFromZero(n, size, scatter) {
  const m = 2 * (n - 1);
  return size * size / scatter * m / 2 > m / 2 * (CHANCE ** (-2 / m) - 1);
}

// How many cells differ from zero, beside how many would by chance.
function judgement(list, data) {
  const tested = list.filter((cell) => cell.n >= FEW).length;
  const found = list.filter((cell) => cell.significant).length;
  const chance = CHANCE * tested;
  const biased = data.findings?.some(({ code }) => code === "residuals_biased");
  const words = `Here ${found} of ${tested} cells have one; noise alone makes about ` +
    `${Math.round(chance)}`;
  if (biased || found > chance + 4 * Math.sqrt(chance) + 1) {
    return `${words}: the residuals are systematic.`;
  }
  return `${words}.`;
}

// Corners in cells of a grid over the image, with mean residual and its standard error.
function cellsOf(used, [width, height]) {
  const wished = Math.round(Math.sqrt(used.length / 12 * width / height));
  const columns = Math.max(4, Math.min(20, wished));
  const rows = Math.max(3, Math.round(columns * height / width));
  const cells = new Map();
  for (const { u, v, du, dv } of used) {
    const i = Math.min(columns - 1, Math.max(0, Math.floor((u + 0.5) / width * columns)));
    const j = Math.min(rows - 1, Math.max(0, Math.floor((v + 0.5) / height * rows)));
    const cell = cells.get(j * columns + i) ?? { i, j, n: 0, du: 0, dv: 0, squares: 0 };
    cell.n += 1;
    cell.du += du;
    cell.dv += dv;
    cell.squares += du * du + dv * dv;
    cells.set(j * columns + i, cell);
  }
  const list = [...cells.values()].map(({ i, j, n, du, dv, squares }) => {
    const mean = [du / n, dv / n];
    const scatter = Math.max(0, squares / n - mean[0] ** 2 - mean[1] ** 2);
    return { i, j, n, mean, rms: Math.sqrt(squares / n), size: Math.hypot(...mean),
             significant: n >= FEW && differsFromZero(n, Math.hypot(...mean), scatter) };
  });
  return { columns, rows, list };
}

function meanMap(data, used) {
  const [width, height] = data.image_size;
  const { columns, rows, list } = cellsOf(used, data.image_size);
  const [dx, dy] = [width / columns, height / rows];
  const trusted = list.filter((cell) => cell.n >= FEW).map((cell) => cell.rms);
  const scale = colourScale(trusted.length ? trusted : list.map((cell) => cell.rms), CIVIDIS);
  const factor = magnification(list.map((cell) => cell.size), dx, 0.6);
  const arrow = ({ i, j, mean }) => [(i + 0.5) * dx - 0.5, (j + 0.5) * dy - 0.5,
    factor * mean[0], factor * mean[1]];
  const drawn = (significant) => list.filter((cell) => cell.significant === significant).map(arrow);
  const significant = list.filter((cell) => cell.significant).length;
  return chart({
    name: "residual-map", marks: list.length, title: "As a map",
    label: `Mean residual in ${list.length} cells; ${significant} differ from zero`,
    read: "the colour is the size (RMS) of the residuals in a cell, the line their mean. A white " +
      `line is more than noise would make (p < ${CHANCE}). ${judgement(list, data)}` +
      (trusted.length < list.length ? ` Faded cells hold fewer than ${FEW} corners.` : ""),
  }, imageFrame(data.image_size,
    list.map(({ i, j, rms, n }) => s("rect", {
      x: i * dx - 0.5, y: j * dy - 0.5, width: dx, height: dy, class: n < FEW ? "cell few" : "cell",
      fill: css(colourAt(CIVIDIS, scale.share(rms))) },
    s("title", null, `${count(n, "corner")}, RMS ${px(rms)}`))),
    strokes(drawn(false), "mean faint"), strokes(drawn(true), "mean halo"),
    strokes(drawn(true), "mean"), dots(list.filter((c) => c.significant).map(arrow), "mean-base")),
  colourBar(scale, "px"), scaleBar(factor, width));
}

export function residuals(data) {
  const used = usedCorners(data);
  if (!data.image_size || !used.length) return null;
  return section("residuals", "Residuals", { wide: true },
    h("p", null, "A residual is the difference between where a corner was seen and where the ",
      "calibrated camera puts it. What is left over should be noise only."),
    h("div", { class: "grid two" }, vectorPlot(data, used), meanMap(data, used),
      distribution(data, used), profile(data, used)));
}
