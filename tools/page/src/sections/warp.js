// The shape of the board.
import { chart, h, section } from "../dom.js";
import { CIVIDIS } from "../colour.js";
import { bySigma, digits, isNumber, range } from "../numbers.js";
import { colourBar, colourScale, heatmap } from "../plot/heatmap.js";

const SIGNIFICANT = 2;  // standard deviations from which on a term is one, as on the terminal

function termText(value, sigma, unit) {
  return isNumber(sigma) && sigma > 0
    ? `${bySigma(value, sigma)} ± ${bySigma(sigma, sigma)} ${unit}` : `${digits(value, 2)} ${unit}`;
}

function boardText(warp) {
  const [x, y] = [0, 1].map((i) => [warp.bend_mm?.[i], warp.sigma_mm?.[i], "mm"]);
  const twist = [warp.twist_mm, warp.sigma_twist_mm, "mm"];
  const print = [100 * warp.aspect, 100 * warp.sigma_aspect, "%"];
  const flat = [x, y, twist].every(
    ([value, sigma]) => isNumber(sigma) && Math.abs(value) < SIGNIFICANT * sigma);
  return `The board is bent by ${termText(...x)} along x and by ${termText(...y)} along y, twisted ` +
    `by ${termText(...twist)} and longer along y by ${termText(...print)} (± 1 sd)` +
    (flat ? "; bends and twist are no more than noise, so the board is flat as far as the " +
      "pictures tell." : ".");
}

export function warp(data) {
  const bend = data.warp;
  if (!bend) return null;
  const grid = bend.height_mm ?? [];
  const values = grid.flat().filter(isNumber);
  const { low, high } = range(values);
  const scale = values.length ? colourScale(values, CIVIDIS) : null;
  const size = (bend.size_mm ?? [0, 0]).map((x) => x + 1);
  return section("warp", "Shape of the board", null, h("p", null, boardText(bend)),
    scale ? chart({
      name: "warp", marks: values.length,
      label: `Height of the board, from ${digits(low)} to ${digits(high)} mm`,
      read: "the board seen from the front; colour and lines give its height towards the viewer, " +
        "in millimetres. A flat board has one colour.",
    }, h("div", { class: "board-map" },
      heatmap([...grid].reverse(), scale, size), colourBar(scale, "mm")), h("p", { class: "note" },
      `${Math.round(size[0] - 1)} × ${Math.round(size[1] - 1)} mm, origin at the lower left`)) : null);
}
