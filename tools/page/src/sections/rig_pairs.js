// Pairs of cameras: how well they agree, and how well they measure depth.
import { chart, h, key, s, section, table } from "../dom.js";
import { themeColour } from "../colour.js";
import { count, digits, isNumber } from "../numbers.js";
import { watchSize } from "../plot/frame.js";
import { lineChart } from "../plot/lines.js";
import { linkTo } from "./rig.js";
import { plusMinus } from "./verdict.js";

const SHOWN = 20;     // rows of a table before it folds
const LABELLED = 15;  // pairs that have their numbers in the graph
const LINES = ["--blue", "--vermilion", "--green", "--orange", "--purple", "--sky"];
const WIDTH = 600;

const heightOf = (n) => (n > 2 ? 300 : 110);

const namesOf = (data, pair) => `${data.cameras[pair.a].name} – ${data.cameras[pair.b].name}`;

// The cameras on an ellipse, the first at the left.
function placesOf(n) {
  const middle = heightOf(n) / 2;
  return Array.from({ length: n }, (_, i) => {
    const angle = Math.PI - 2 * Math.PI * i / n;
    return [WIDTH / 2 + 0.36 * WIDTH * Math.cos(angle), middle * (1 - 0.74 * Math.sin(angle))];
  });
}

function kindOf({ disagreement_sd: sd }) {
  if (!isNumber(sd) || sd < 2) return "agrees";
  return sd < 3 ? "strains" : "disagrees";
}

const labelOf = (pair) => [pair.disagreement, count(pair.num_instants, "instant")]
  .filter(Boolean).join(", ");

function graph(data) {
  const places = placesOf(data.cameras.length);
  const height = heightOf(data.cameras.length);
  const most = Math.max(1, ...data.pairs.map((pair) => pair.num_instants));
  // Pairs through the middle have their labels nearer to one end, beside one another.
  const labelAt = (pair) => [0, 1].map((i) => 0.6 * places[pair.a][i] + 0.4 * places[pair.b][i]);
  const edges = data.pairs.map((pair) => s("line", {
    x1: places[pair.a][0], y1: places[pair.a][1], x2: places[pair.b][0], y2: places[pair.b][1],
    class: `edge ${kindOf(pair)}`,
    style: `stroke-width: ${(1 + 4 * Math.sqrt(pair.num_instants / most)).toFixed(1)}px`,
  }, s("title", null, `${namesOf(data, pair)}: ${labelOf(pair)}`)));
  const text = ([x, y], kind, words) => s("text", { x, y, class: `graph-text ${kind}` }, words);
  return watchSize(s("svg", { viewBox: `0 0 ${WIDTH} ${height}`, class: "graph" }, edges,
    data.pairs.length <= LABELLED
      ? data.pairs.map((pair) => text(labelAt(pair), "pair", labelOf(pair))) : null,
    places.map(([x, y], i) => [s("circle", { cx: x, cy: y, r: 7, class: "node" }),
      text([x, y + (y > 0.51 * height ? 26 : -16)], "camera", data.cameras[i].name)])));
}

// Rows beyond the first ones fold up.
function folded(heads, rows, options) {
  return [table(heads, rows.slice(0, SHOWN), options), rows.length <= SHOWN ? null
    : h("details", null, h("summary", null, `${rows.length - SHOWN} more pairs`),
      table(heads, rows.slice(SHOWN), options))];
}

const namesCell = (data, pair) => h("span", null, linkTo(data, pair.a), " – ",
  linkTo(data, pair.b));

export function rigPairs(data) {
  if (!data.pairs?.length || !data.cameras.some((camera) => camera.parameters)) return null;
  const isKnown = data.pairs.some((pair) => isNumber(pair.num_instants));
  const isTested = data.pairs.some((pair) => isNumber(pair.disagreement_sd));
  const sorted = [...data.pairs].sort((a, b) =>
    (b.disagreement_sd ?? 0) - (a.disagreement_sd ?? 0));
  const known = (pair) => (isKnown ? [String(pair.num_instants), pair.epipolar_px] : []);
  return section("pairs", "Pairs of cameras", { wide: true }, h("div", { class: "grid two" },
    isKnown ? chart({
      name: "pairs", marks: data.pairs.length,
      label: `Graph of ${count(data.pairs.length, "pair")} of cameras`,
      read: "a line joins two cameras that saw a board at the same instants: the wider, the more " +
        "instants. " + (isTested
        ? "The number is by how many standard deviations (sd) this pair alone disagrees with the " +
          "rig: up to 2 is noise, and beyond 3 (the strong colour) a camera moved, or pictures " +
          "of different instants were paired."
        : "With two cameras no other pair can disagree; see the excess of each."),
    }, graph(data)) : null,
    h("div", null, folded(["pair", "baseline", ...(isKnown ? ["instants", "epipolar [px]"] : []),
      ...(isTested ? ["disagrees by"] : [])],
    sorted.map((pair) => [namesCell(data, pair), plusMinus(pair.baseline), ...known(pair),
      ...(isTested ? [pair.disagreement] : [])]),
    { numeric: [1, 2, 3, 4], label: "Pairs of cameras" }))));
}

const lastOf = (pair) => pair.depths[pair.depths.length - 1].sigma_m;

// At most one pair a line colour, from the best to the worst.
function drawnPairs(pairs) {
  const sorted = [...pairs].sort((a, b) => lastOf(a) - lastOf(b));
  if (sorted.length <= LINES.length) return sorted;
  return LINES.map((_, i) => sorted[Math.round(i * (sorted.length - 1) / (LINES.length - 1))]);
}

const metres = (_, ticks) => ticks.map((x) => (x === null || x === undefined ? ""
  : x < 1e-4 ? `${digits(1e6 * x, 1)} µm` : x < 0.1 ? `${digits(1e3 * x, 1)} mm`
  : `${digits(x, 1)} m`));

function depthChart(data, drawn) {
  const distances = [...new Set(drawn.flatMap((pair) => pair.depths.map((d) => d.distance_m)))]
    .sort((a, b) => a - b);
  const valuesOf = (pair, name) => distances.map((distance) =>
    pair.depths.find((d) => d.distance_m === distance)?.[name] || null);
  const withLenses = drawn.length === 1;
  return lineChart(() => ({
    x: { label: "distance", values: metres },
    y: { label: "sd of the depth", values: metres },
    scales: { x: { time: false, distr: 3, range: (_, low, high) => [0.8 * low, 1.25 * high] }, y: { distr: 3 } },
    series: [...drawn.map((_, i) => ({ stroke: themeColour(LINES[i]),
      width: 2 + 1.5 * (drawn.length - 1 - i),  // so that lines under others show
      points: { show: true, size: 7, fill: themeColour(LINES[i]) } })),
    ...(withLenses ? [{ stroke: themeColour("--orange"), width: 2, dash: [6, 4],
      points: { show: true, size: 6, fill: themeColour("--orange") } }] : [])],
    data: [distances, ...drawn.map((pair) => valuesOf(pair, "sigma_m")),
      ...(withLenses ? [valuesOf(drawn[0], "of_lenses_m")] : [])],
  }));
}

// "± 1.4 mm (0.0076 mm of it by the lenses)" for each distance.
function depthTable(data, pairs) {
  const distances = [...new Set(pairs.flatMap((pair) => pair.depths.map((d) => d.distance_m)))]
    .sort((a, b) => a - b);
  const cell = (pair, distance) => {
    const depth = pair.depths.find((d) => d.distance_m === distance);
    return depth ? plusMinus(depth.text.replace(/^at [^ ]+ m /, "")) : "not seen by both";
  };
  return folded(["pair", ...distances.map((distance) => `at ${distance} m`)],
    pairs.map((pair) => [namesCell(data, pair),
      ...distances.map((distance) => cell(pair, distance))]),
    { label: "Standard deviation of the depth", kind: "depths" });
}

export function rigDepth(data) {
  const pairs = (data.pairs ?? []).filter((pair) => pair.depths?.length);
  if (!pairs.length || !data.cameras.some((camera) => camera.parameters)) return null;
  const drawn = drawnPairs(pairs);
  return section("depth", "Depth that pairs measure", { wide: true }, chart({
    name: "depth", marks: drawn.length, label: `Depth of ${count(drawn.length, "pair")}`,
    read: "how far a triangulated point would be off (1 sd), on the axis of the first camera, by " +
      "the uncertainty of places and lenses; the noise of its pixels comes on top. Both axes are " +
      "logarithmic: an error of the baseline grows with the distance, and one of the angle between " +
      "the cameras with its square." +
      (drawn.length < pairs.length
        ? ` Drawn are ${drawn.length} of ${pairs.length} pairs, from the best to the worst.` : ""),
  }, depthChart(data, drawn), h("p", { class: "legend" },
    drawn.map((pair, i) => key(`line-of${LINES[i]}`, namesOf(data, pair))),
    drawn.length === 1 ? key("line-tangential", "part of the lenses") : null)),
  depthTable(data, pairs));
}
