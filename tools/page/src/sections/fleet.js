// A fleet: its population, the units that are most unlike it, and a histogram and a control chart of
// each parameter.
import { chart, h, key, section, table } from "../dom.js";
import { themeColour } from "../colour.js";
import { NONE, count, digits, px } from "../numbers.js";
import { bars, lineChart, spline } from "../plot/lines.js";
import { plusMinus } from "./verdict.js";

const LIMIT = 3;  // standard deviations of a control chart (Shewhart)

export function fleetPopulation(data) {
  return data.fleet.groups.map((group, index) =>
    section(`population-${index}`, `Population: ${group.title}`, null,
      table(["", "centre", "spread", "own sd"], group.parameters.map((p) => [
        h("b", null, p.name), plusMinus(p.centre_text), plusMinus(p.spread_text), p.own_text]),
      { numeric: [1, 2, 3], label: `Population of ${count(group.num_units, "unit")}` }),
      h("p", { class: "read" }, h("b", null, "How to read it: "),
        `the centre is the robust mean of ${count(group.num_units, "unit")}, the spread the standard ` +
        "deviation by which units differ in truth, own sd what a calibration itself is uncertain by." +
        (group.spread_px ? ` The projections differ by ${px(group.spread_px)} per coordinate.` : ""))));
}

export function fleetWorst(data) {
  const { worst } = data.fleet;
  if (!worst.length) return null;
  return section("worst", "Most unlike the others", { wide: true },
    table(["unit", "verdict", "p", "most", "sd", "projection"], worst.map((unit) => [
      unit.link ? h("a", { href: encodeURI(unit.link) }, unit.name) : unit.name, unit.verdict,
      digits(unit.p_value), unit.most, digits(unit.in_sigmas, 3),
      unit.displacement_px === null ? NONE : px(unit.displacement_px)]),
    { numeric: [2, 4, 5], label: "Units that are most unlike the population" }),
    h("p", { class: "read" }, h("b", null, "How to read it: "),
      "p is the probability that a unit of the population is farther away by all its parameters; the " +
      "parameter that deviates most is named, in standard deviations of population and calibration."));
}

function histogram(parameter, units) {
  const { end, counts, outside } = parameter.histogram;
  const width = 2 * end / counts.length;
  const centres = counts.map((_, bin) => -end + (bin + 0.5) * width);
  const normal = centres.map((z) => units * width * Math.exp(-z * z / 2) / Math.sqrt(2 * Math.PI));
  const plot = lineChart(() => ({
    x: { label: "deviation / standard deviation" }, y: { label: "units" },
    scales: { x: { time: false, range: [-end, end] },
              y: { range: (_, low, high) => [0, 1.05 * Math.max(high, ...normal)] } },
    series: [
      { label: "units", paths: bars(), fill: themeColour("--sky"), points: { show: false } },
      { label: "normal", paths: spline(), stroke: themeColour("--vermilion"), width: 2.5,
        points: { show: false } }],
    data: [centres, counts, normal],
  }));
  return chart({ name: `histogram-${parameter.name}`, marks: units, title: parameter.name,
    label: `Histogram of ${parameter.name} of ${count(units, "unit")}`,
    read: "bars should fill the line. Two hills are two lots, long tails units of another make." +
      (outside ? ` ${count(outside, "unit")} beyond ${end} sd.` : "") }, plot,
  h("p", { class: "legend" }, key("bar-residuals", "units"), key("line-noise", "one population")));
}

function control(parameter, group) {
  const { values, centre, spread } = parameter;
  const level = (k) => values.map(() => centre + k * LIMIT * spread);
  const some = (fails) => values.map((value, i) => (group.fails[i] === fails ? value : null));
  const dots = (colour, size) => ({ paths: () => null,
    points: { show: true, size, fill: themeColour(colour), stroke: themeColour(colour) } });
  const line = { stroke: themeColour("--soft"), width: 1, points: { show: false } };
  const plot = lineChart(() => ({
    x: { label: "unit, by date and name" }, y: { label: parameter.name },
    series: [dots("--sky", 4), dots("--vermilion", 7), line, line, line],
    data: [values.map((_, i) => i + 1), some(false), some(true), level(-1), level(0), level(1)],
  }));
  const failing = group.units.filter((_, i) => group.fails[i]);
  return chart({ name: `control-${parameter.name}`, marks: values.length,
    title: `${parameter.name} in order`, label: `Control chart of ${parameter.name}`,
    read: `the lines are the centre and ${LIMIT} spreads to each side. A step or a slope is a change ` +
      "of the production." + (failing.length ? ` Large dots fail: ${failing.slice(0, 5).join(", ")}` +
      `${failing.length > 5 ? ", .." : ""}.` : "") }, plot);
}

export function fleetCharts(data) {
  return data.fleet.groups.map((group, index) =>
    section(`parameters-${index}`, `Parameters: ${group.title}`, { wide: true },
      group.parameters.map((parameter) => h("div", { class: "grid two" },
        histogram(parameter, group.num_units), control(parameter, group)))));
}

export function fleetDrifts(data) {
  const { drifts } = data.fleet;
  if (!drifts.length) return null;
  return section("drifts", "Drift", null, h("ul", null, drifts.map((line) =>
    h("li", null, plusMinus(line)))));
}
