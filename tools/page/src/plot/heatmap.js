// A grid of values over an image: colours between the nodes, contours with labels, a colour bar.
import { h, s } from "../dom.js";
import { colourAt, css, gradient } from "../colour.js";
import { digits, isNumber, quantile, range } from "../numbers.js";
import { contourSegments } from "./contour.js";
import { imageFrame, polygon } from "./frame.js";

const STEPS = 6;  // pixels of the picture between two nodes
const RARE = 0.02;  // share of the values that may lie beyond each end of the colours ..
const FAR = 2;  // .. if they are at least this factor away

// The value between the nodes, bilinear; NaN beside a node without a value.
function between(grid, x, y) {
  const column = Math.min(grid[0].length - 2, Math.floor(x));
  const row = Math.min(grid.length - 2, Math.floor(y));
  const [fx, fy] = [x - column, y - row];
  const at = (j, i) => (isNumber(grid[j]?.[i]) ? grid[j][i] : NaN);
  return (1 - fy) * ((1 - fx) * at(row, column) + fx * at(row, column + 1)) +
    fy * ((1 - fx) * at(row + 1, column) + fx * at(row + 1, column + 1));
}

// The grid as a picture, transparent where there is no value.
function picture(grid, share, map) {
  const canvas = document.createElement("canvas");
  canvas.width = (grid[0].length - 1) * STEPS + 1;
  canvas.height = (grid.length - 1) * STEPS + 1;
  const context = canvas.getContext("2d");
  for (let y = 0; y < canvas.height; ++y) {
    for (let x = 0; x < canvas.width; ++x) {
      const value = between(grid, x / STEPS, y / STEPS);
      if (Number.isNaN(value)) continue;
      context.fillStyle = css(colourAt(map, share(value)));
      context.fillRect(x, y, 1, 1);
    }
  }
  return canvas.toDataURL();
}

// The scale of colours: linear, or logarithmic where values span more than a factor of 8. There,
// single values far from all others share the colour of the end ("below", "above").
export function colourScale(values, map) {
  let { low, high } = range(values);
  if (low === high) high = low + (Math.abs(low) || 1) * 1e-3;
  if (!(low > 0 && high / low > 8)) {
    return { low, high, logarithmic: false, share: (x) => (x - low) / (high - low), map };
  }
  const [most, least] = [quantile(values, 1 - RARE), quantile(values, RARE)];
  const above = high > FAR * most;
  const below = low < least / FAR;
  if (above) high = most;
  if (below) low = least;
  return { low, high, above, below, logarithmic: true, map,
           share: (x) => Math.log(x / low) / Math.log(high / low) };
}

// Levels for contours on the scale: 1, 2, 5 steps of a logarithmic one, else round steps.
export function levelsOf({ low, high, logarithmic, share }) {
  const levels = [];
  if (logarithmic) {
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); ++e) {
      for (const step of [1, 2, 5]) levels.push(step * 10 ** e);
    }
  } else {
    const raw = (high - low) / 5;
    const base = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((n) => n * base >= raw * (1 - 1e-9)) * base;
    for (let i = Math.ceil(low / step); i * step <= high; ++i) levels.push(i * step);
  }
  return levels.filter((level) => share(level) > 0.02 && share(level) < 0.98);
}

// Up to two labels per level, far from the borders and from the other labels.
function placeLabels(lines, [width, height]) {
  const placed = [];
  const clearance = ([x, y]) => Math.min(x - 0.06 * width, 0.94 * width - x,
    (y - 0.05 * height) * 2, (0.95 * height - y) * 2,
    ...placed.map((p) => Math.hypot((p.x - x) * 0.7, (p.y - y) * 1.6)));
  for (const { level, segments } of lines) {
    let best = null;
    for (const [a, b] of segments) {
      const middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      const room = clearance(middle);
      if (room > (best?.room ?? 0.085 * width)) best = { room, x: middle[0], y: middle[1], level };
    }
    if (best) placed.push(best);
  }
  return placed;
}

// Contours of the grid over size, as lines with labels.
function contours(grid, scale, [width, height]) {
  const [dx, dy] = [(width - 1) / (grid[0].length - 1), (height - 1) / (grid.length - 1)];
  const lines = levelsOf(scale).map((level) => ({
    level,
    segments: contourSegments(grid, level).map((ends) => ends.map(([i, j]) => [i * dx, j * dy])),
  })).filter(({ segments }) => segments.length);
  const path = ({ segments }) => segments.map(([a, b]) =>
    `M${a[0].toFixed(1)} ${a[1].toFixed(1)}L${b[0].toFixed(1)} ${b[1].toFixed(1)}`).join("");
  return [
    ...lines.flatMap((line) => [s("path", { d: path(line), class: "contour halo" }),
      s("path", { d: path(line), class: "contour", "data-level": line.level })]),
    ...placeLabels(lines, [width, height]).map(({ x, y, level }) =>
      s("text", { x, y, class: "contour-label" }, digits(level, 1))),
  ];
}

// The whole map: image, contours and what "over" draws above it.
export function heatmap(grid, scale, size, { hull = null, over = null } = {}) {
  const [width, height] = size;
  return imageFrame(size,
    s("rect", { x: -0.5, y: -0.5, width, height, fill: "url(#hatch)" }),
    s("image", { x: -0.5, y: -0.5, width, height, preserveAspectRatio: "none",
                 href: picture(grid, scale.share, scale.map) }),
    contours(grid, scale, size),
    hull?.length > 2 ? [polygon(hull, "hull halo"), polygon(hull, "hull")] : null,
    over);
}

export function colourBar(scale, unit) {
  const levels = levelsOf(scale);
  const marks = [];
  for (const level of levels) {  // apart from the ends and from each other
    const share = scale.share(level);
    const last = marks.length ? scale.share(marks.at(-1)) : 0;
    const [from, to] = [scale.below ? 0.33 : 0.24, scale.above ? 0.63 : 0.72];
    if (share > from && share < to && share - last > 0.16) marks.push(level);
  }
  return h("div", { class: "colour-bar" },
    h("div", { class: "ramp", style: `background: ${gradient(scale.map)}` }),
    h("div", { class: "ticks" },
      h("span", { style: "left: 0" }, `${scale.below ? "≤ " : ""}${digits(scale.low, 2)}`),
      marks.map((level) => h("span", { class: "middle",
        style: `left: ${(100 * scale.share(level)).toFixed(1)}%` }, digits(level, 1))),
      h("span", { class: "end", style: "right: 0" }, 
        `${scale.above ? "≥ " : ""}${digits(scale.high, 2)} ${unit}`)));
}
