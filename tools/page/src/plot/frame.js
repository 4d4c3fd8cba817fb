// The frame of an image as an SVG in pixels of the camera, on which charts draw. SVG takes its
// colours from the style sheet, so it follows light, dark and print, and stays sharp.
import { s } from "../dom.js";

// Keeps --px, the length of one screen pixel in units of the SVG, for texts of constant size.
const resized = typeof ResizeObserver === "undefined" ? null : new ResizeObserver((entries) => {
  for (const { target, contentRect } of entries) {
    if (!contentRect.width) continue;
    target.style.setProperty("--px", target.viewBox.baseVal.width / contentRect.width);
  }
});

export function watchSize(node) {
  node.style.setProperty("--px", node.viewBox.baseVal.width / 600);
  resized?.observe(node);
  return node;
}

// The pattern of areas without a value, once on the page: "url(#hatch)".
export function hatchPattern() {
  return s("svg", { width: 0, height: 0, class: "off-screen", "aria-hidden": "true" },
    s("defs", null, s("pattern", { id: "hatch", width: 14, height: 14,
      patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    s("rect", { width: 14, height: 14, class: "no-value" }),
    s("rect", { width: 5, height: 14, class: "hatch-line" }))));
}

// An SVG over an image of [width, height]; pixel (0, 0) is the centre of the top left pixel.
export function imageFrame([width, height], ...marks) {
  const box = [-0.5, -0.5, width, height];
  return watchSize(s("svg", { viewBox: box.join(" "), class: "image-frame" },
    s("rect", { x: -0.5, y: -0.5, width, height, class: "frame" }), marks));
}

// Many dots as one path: lines of no length with round caps, whose width is in screen pixels.
export function dots(points, kind) {
  const path = points.map(([x, y]) => `M${round(x)} ${round(y)}h0`).join("");
  return path ? s("path", { d: path, class: `dots ${kind}` }) : null;
}

// Many crosses (x) as one path, with arms of this length.
export function crosses(points, arm, kind) {
  const a = round(arm);
  const path = points.map(([x, y]) => `M${round(x - a)} ${round(y - a)}l${2 * a} ${2 * a}` +
    `m0 ${-2 * a}l${-2 * a} ${2 * a}`).join("");
  return path ? s("path", { d: path, class: `lines ${kind}` }) : null;
}

// Many upright crosses (+) as one path.
export function pluses(points, arm, kind) {
  const a = round(arm);
  const path = points.map(([x, y]) => `M${round(x - a)} ${round(y)}h${2 * a}` +
    `m${-a} ${-a}v${2 * a}`).join("");
  return path ? s("path", { d: path, class: `lines ${kind}` }) : null;
}

// Many rings as one path.
export function rings(points, radius, kind) {
  const r = round(radius);
  const path = points.map(([x, y]) => `M${round(x - r)} ${round(y)}` +
    `a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`).join("");
  return path ? s("path", { d: path, class: `lines ${kind}` }) : null;
}

// Many lines [x, y, dx, dy] as one path.
export function strokes(lines, kind) {
  const path = lines.map(([x, y, dx, dy]) =>
    `M${round(x)} ${round(y)}l${round(dx)} ${round(dy)}`).join("");
  return path ? s("path", { d: path, class: `lines ${kind}` }) : null;
}

export function polygon(points, kind) {
  return s("polygon", { points: points.map(([x, y]) => `${round(x)},${round(y)}`).join(" "),
                        class: kind });
}

export function round(x) {
  return Math.round(x * 100) / 100;
}
