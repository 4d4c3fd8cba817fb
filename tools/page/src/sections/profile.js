// The mean residual over the distance from the principal point: what a lens model misses.
import { chart, h, key } from "../dom.js";
import { themeColour } from "../colour.js";
import { digits, isNumber } from "../numbers.js";
import { centreOf } from "../data.js";
import { lineChart } from "../plot/lines.js";

const MIN_PER_BIN = 8;

// Radial and tangential component of each residual, by radius.
function components(data, used) {
  const [cx, cy] = centreOf(data);
  return used.map(({ u, v, du, dv }) => {
    const radius = Math.hypot(u - cx, v - cy) || 1e-9;
    const [x, y] = [(u - cx) / radius, (v - cy) / radius];
    return { radius, radial: du * x + dv * y, tangential: dv * x - du * y };
  }).sort((a, b) => a.radius - b.radius);
}

function meanOf(list, name) {
  const mean = list.reduce((sum, item) => sum + item[name], 0) / list.length;
  const scatter = list.reduce((sum, item) => sum + (item[name] - mean) ** 2, 0);
  return { mean, error: Math.sqrt(scatter / Math.max(1, list.length - 1) / list.length) };
}

// Bins of equally many corners.
function binned(list) {
  const bins = Math.max(3, Math.min(16, Math.floor(list.length / MIN_PER_BIN)));
  return Array.from({ length: bins }, (_, bin) => {
    const part = list.slice(Math.floor(bin * list.length / bins),
      Math.floor((bin + 1) * list.length / bins));
    return { radius: part.reduce((sum, item) => sum + item.radius, 0) / part.length,
             radial: meanOf(part, "radial"), tangential: meanOf(part, "tangential") };
  });
}

function seriesOf(bins) {
  const of = (name, sign) => bins.map((bin) => bin[name].mean + sign * bin[name].error);
  return [bins.map((bin) => bin.radius), of("radial", 0), of("radial", 1), of("radial", -1),
    of("tangential", 0), of("tangential", 1), of("tangential", -1)];
}

export function profile(data, used) {
  if (used.length < 3 * MIN_PER_BIN) return null;
  const bins = binned(components(data, used));
  const pulls = bins.map(({ radial }) => radial.mean / radial.error).filter(isNumber);
  const strongest = Math.max(0, ...pulls.map(Math.abs));
  const plot = lineChart(() => {
    const line = (name, dash) => ({ stroke: themeColour(name), width: 2, dash,
                                    points: { show: true, size: 6, fill: themeColour(name) } });
    const edge = { stroke: "transparent", points: { show: false } };
    return {
      x: { label: "distance from the principal point [px]" },
      y: { label: "mean residual [px]" },
      series: [line("--blue"), edge, edge, line("--orange", [6, 4]), edge, edge],
      bands: [{ series: [2, 3], fill: themeColour("--blue-band") },
              { series: [5, 6], fill: themeColour("--orange-band") }],
      data: seriesOf(bins),
    };
  });
  return chart({
    name: "radial-profile", marks: bins.length, title: "From the centre outwards",
    label: `Mean radial and tangential residual in ${bins.length} rings around the centre`,
    read: "both lines should stay at zero within their bands (1 standard error). A solid line " +
      "that swings is radial distortion that the lens model does not have. Here it leaves zero by " +
      `at most ${digits(strongest, 2)} standard errors` +
      (strongest > 4 ? ": try a larger lens model." : "."),
  }, plot, h("p", { class: "legend" }, key("line-radial", "outwards (radial)"),
    key("line-tangential", "around (tangential)")));
}
