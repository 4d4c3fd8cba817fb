// The bend of the board.
import { chart, h, section } from "../dom.js";
import { CIVIDIS } from "../colour.js";
import { bySigma, digits, isNumber, range } from "../numbers.js";
import { colourBar, colourScale, heatmap } from "../plot/heatmap.js";

const SIGNIFICANT = 3;  // standard deviations from which on a bend is one

function bendText(warp) {
  const axis = (i) => {
    const [bend, sigma] = [warp.bend_mm?.[i], warp.sigma_mm?.[i]];
    return isNumber(sigma) && sigma > 0
      ? `${bySigma(bend, sigma)} ± ${bySigma(sigma, sigma)} mm` : `${digits(bend, 2)} mm`;
  };
  const flat = [0, 1].every((i) => isNumber(warp.sigma_mm?.[i]) &&
    Math.abs(warp.bend_mm[i]) < SIGNIFICANT * warp.sigma_mm[i]);
  return `The board is bent by ${axis(0)} along x and by ${axis(1)} along y (± 1 sd)` +
    (flat ? ": no more than noise, so the board is flat as far as the pictures tell." : ".");
}

export function warp(data) {
  const bend = data.warp;
  if (!bend) return null;
  const grid = bend.height_mm ?? [];
  const values = grid.flat().filter(isNumber);
  const { low, high } = range(values);
  const scale = values.length ? colourScale(values, CIVIDIS) : null;
  const size = (bend.size_mm ?? [0, 0]).map((x) => x + 1);
  return section("warp", "Shape of the board", null, h("p", null, bendText(bend)),
    scale ? chart({
      name: "warp", marks: values.length,
      label: `Height of the board, from ${digits(low)} to ${digits(high)} mm`,
      read: "the board seen from the front; colour and lines give its height towards the viewer, " +
        "in millimetres. A flat board has one colour.",
    }, h("div", { class: "board-map" },
      heatmap([...grid].reverse(), scale, size), colourBar(scale, "mm")), h("p", { class: "note" },
      `${Math.round(size[0] - 1)} × ${Math.round(size[1] - 1)} mm, origin at the lower left`)) : null);
}
