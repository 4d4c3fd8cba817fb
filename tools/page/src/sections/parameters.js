// The camera in one table: each parameter with its standard deviation and its meaning.
import { h, section, table } from "../dom.js";
import { NONE, bySigma, isNumber } from "../numbers.js";
import { plusMinus } from "./verdict.js";

const MEANING = {
  f: "focal length",
  fx: "focal length along x",
  fy: "focal length along y",
  cx: "principal point, x: where the optical axis meets the image",
  cy: "principal point, y",
  k1: "radial distortion: bends lines towards or away from the centre",
  k2: "radial distortion, next order",
  k3: "radial distortion, next order",
  k4: "radial distortion, next order",
  k5: "radial distortion, denominator",
  k6: "radial distortion, denominator",
  p1: "tangential distortion: lens tilted or off centre",
  p2: "tangential distortion",
  s: "pixels per metre",
};

function valueOf(parameter) {
  const { value, sigma, text } = parameter;
  if (!isNumber(value)) return NONE;
  if (text) return plusMinus(text);
  return isNumber(sigma) && sigma > 0
    ? `${bySigma(value, sigma)} ± ${bySigma(sigma, sigma)}` : bySigma(value, sigma);
}

function noteOf({ value, sigma }) {
  if (!isNumber(value)) return "not determined. ";
  if (sigma === 0) return "not estimated. ";
  return isNumber(sigma) ? "" : "standard deviation unknown. ";
}

// "902.496" and "± 0.012" under each other, so that points and signs stand in columns.
function aligned(text) {
  if (text.endsWith(", held")) return [text.replace(", held", ""), "held"];
  const [value, sigma] = text.split(/ ±\s/);
  return sigma === undefined ? [value, ""] : [value, `± ${sigma}`];
}

export function parameters(data) {
  const rows = data.parameters ?? [];
  if (!rows.length) return null;
  return section("parameters", `Camera: ${data.model ?? ""}`, null,
    table(["", "value", "1 sd", "", "meaning"], rows.map((parameter) => ({
      class: isNumber(parameter.value) ? null : "missing",
      cells: [h("b", null, parameter.name), ...aligned(valueOf(parameter)), parameter.unit ?? "",
        h("span", { class: "meaning" }, noteOf(parameter), MEANING[parameter.name] ?? "")],
    })), { numeric: [1, 2], label: "Parameters of the camera", kind: "parameters" }),
    !rows.some((row) => isNumber(row.value) && row.sigma > 0) ? null
      : h("p", { class: "read" }, h("b", null, "How to read it: "),
      "with 68 % probability the true value lies within one standard deviation (sd). ",
      "Coefficients of the distortion act together: judge the lens by the map of its projection."),
    data.readout
      ? h("p", { class: "note" }, "Rolling shutter: its rows take ",
        bySigma(data.readout.ms, data.readout.sigma_ms), " ± ",
        bySigma(data.readout.sigma_ms, data.readout.sigma_ms), " ms from the first to the last.") : null,
    data.image_size
      ? h("p", { class: "note" }, `Image of ${data.image_size[0]} × ${data.image_size[1]} pixels; `,
        "pixel (0, 0) is the centre of the top left pixel.") : null);
}
