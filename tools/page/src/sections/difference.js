// Two calibrations of one camera: where their projections differ, and if that is more than noise.
import { chart, h, section, table } from "../dom.js";
import { VIRIDIS } from "../colour.js";
import { NONE, bySigma, digits, distance, distanceTitle, isNumber, niceBelow,
         px, quantile, range } from "../numbers.js";
import { strokes } from "../plot/frame.js";
import { colourBar, colourScale, heatmap } from "../plot/heatmap.js";

const ROUNDING_PX = 1e-9;

const length = (map) => map.u_px.map((row, j) => row.map((u, i) =>
  (isNumber(u) && isNumber(map.v_px[j][i]) ? Math.hypot(u, map.v_px[j][i]) : null)));

// The difference as lines at every other node.
function field(map, factor, [width, height]) {
  const lines = [];
  map.u_px.forEach((row, j) => row.forEach((u, i) => {
    if ((i + j) % 2 || !isNumber(u) || !isNumber(map.v_px[j][i])) return;
    lines.push([i / (row.length - 1) * (width - 1), j / (map.u_px.length - 1) * (height - 1),
                factor * u, factor * map.v_px[j][i]]);
  }));
  return [strokes(lines, "mean halo"), strokes(lines, "mean")];
}

function mapOf(map, grid, scale, factor, size) {
  return h("div", { class: "small-map" },
    h("h3", null, distanceTitle(map.distance_m)),
    heatmap(grid, scale, size, { over: field(map, factor, size) }));
}

function significance(p) {
  if (!isNumber(p)) return NONE;
  if (p < 1e-6) return "< 0.000001";
  return digits(p, 2);
}

// "in the projection": a chart of all distances and a table.
function maps(data) {
  const list = (data.difference?.maps ?? []).filter((map) => map.u_px?.length > 1);
  if (!list.length || !data.image_size) return null;
  const grids = list.map(length);
  const values = grids.flat(2).filter(isNumber);
  if (!(range(values).high > ROUNDING_PX)) {
    return section("difference", "Difference of the projection", { wide: true },
      h("p", null, "The two cameras project alike, to the last digits of the computer."));
  }
  const scale = colourScale(values, VIRIDIS);
  const large = quantile(values, 0.95);
  const factor = large > 0 ? niceBelow(0.06 * data.image_size[0] / large) : 1;
  return section("difference", "Difference of the projection", { wide: true },
    chart({
      name: "difference", marks: values.length,
      label: `Difference of the projection at ${list.length} distances`,
      read: `colour and contours give how far apart the two cameras see the same point, in pixels; ` +
        `lines give the direction (from A to B, drawn ${digits(factor, 1)} × as long). What a moved ` +
        "and turned camera explains is taken out first. The difference matters if it is larger " +
        "than expected from the uncertainties of both. Far outside of the corners of both, the " +
        "lenses are extrapolated.",
    }, h("div", { class: "grid many" }, list.map((map, i) =>
      mapOf(map, grids[i], scale, factor, data.image_size))), colourBar(scale, "px")),
    table(["distance", "RMS [px]", "by noise [px]", "largest [px]", "p"],
      list.map((map) => [distance(map.distance_m), digits(map.rms_px),
        digits(map.expected_px), digits(map.max_px), significance(map.p_value)]),
      { numeric: [1, 2, 3, 4], label: "Difference at each distance" }),
    h("p", { class: "read" }, h("b", null, "How to read it: "),
      "the difference where both calibrations had corners, beside what noise alone would make ",
      "there. p is the probability of a difference at least this large if both describe the same ",
      "camera. Below 0.01 they do not agree."));
}

function sigmaBar(count) {
  if (!isNumber(count)) return h("span", null, NONE);
  const share = Math.min(1, Math.abs(count) / 5);
  const kind = Math.abs(count) > 3 ? "bar strong" : "bar change";
  return h("div", { class: "bar-cell" }, h("div", { class: "bar-track" },
    h("div", { class: kind, style: `width: ${(100 * Math.max(0.01, share)).toFixed(1)}%` })),
  h("span", { class: "bar-text" }, `${digits(count, 2)} sd`));
}

function parameterTable(data) {
  const rows = data.difference?.parameters ?? [];
  if (!rows.length) return null;
  const value = (x, sigma) => (isNumber(sigma) && sigma > 0
    ? `${bySigma(x, sigma)} ± ${bySigma(sigma, sigma)}` : bySigma(x, sigma));
  return section("difference-parameters", "Parameters of both", { wide: true }, chart({
    name: "difference-parameters", marks: rows.length, label: "Parameters of both calibrations",
    read: "the bar is the difference in standard deviations (sd) of both; beyond 3 (the strong " +
      "colour) it is hardly noise. Single coefficients may differ although the projections agree.",
  }, table(["", `A: ${data.difference.a ?? ""}`,
    `B: ${data.difference.b ?? ""}`, "B − A"], rows.map((row) => [
    h("b", null, row.name), value(row.a, row.sigma_a), value(row.b, row.sigma_b),
    isNumber(row.in_sigmas) || !isNumber(row.b - row.a)
      ? sigmaBar(row.in_sigmas) : digits(row.b - row.a)]),
  { numeric: [1, 2], label: "Parameters of both calibrations", kind: "both" })));
}

export function difference(data) {
  return [maps(data), parameterTable(data)];
}
