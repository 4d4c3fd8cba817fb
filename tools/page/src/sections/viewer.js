// One picture enlarged, with detected and reprojected corners and magnified residuals.
import { h, key, table } from "../dom.js";
import { cornersOfView } from "../data.js";
import { NONE, count, digits, isNumber, niceBelow, px, quantile } from "../numbers.js";
import { crosses, dots, imageFrame, pluses, rings, strokes } from "../plot/frame.js";
import { zoomable } from "../plot/viewbox.js";
import { findingList } from "./findings.js";
import { captionOf, picture } from "./view_parts.js";

const WORST = 8;

function overlay(data, view, seen) {
  const size = data.image_size ?? view.thumbnail_size ?? [4, 3];
  const [width] = size;
  const used = seen.filter((corner) => !corner.rejected);
  const known = seen.filter((corner) => corner.has);
  const at = (list) => list.map(({ u, v }) => [u, v]);
  const large = quantile(used.map((corner) => corner.size), 0.9);
  const factor = large > 0 ? Math.max(1, niceBelow(0.03 * width / large)) : 1;
  const lines = known.map(({ u, v, du, dv }) => [u - du, v - dv, factor * du, factor * dv])
    .filter(([, , dx, dy]) => Math.hypot(dx, dy) < width / 4);
  const reprojected = known.map(({ u, v, du, dv }) => [u - du, v - dv]);
  const rejected = seen.filter((corner) => corner.rejected);
  return { factor, size, image: imageFrame(size, picture(view, size),
    strokes(lines, "magnified halo"), strokes(lines, "magnified"),
    rings(at(used), width / 200, "detected halo"), rings(at(used), width / 200, "detected"),
    dots(at(used), "exact"), pluses(reprojected, width / 320, "reprojected"),
    crosses(at(rejected), width / 90, "rejected halo"),
    crosses(at(rejected), width / 90, "rejected")) };
}

function worstTable(seen) {
  const known = seen.filter((corner) => corner.has).sort((a, b) => b.size - a.size);
  if (!known.length) return null;
  const signed = (x) => (x > 0 ? `+${digits(x, 2)}` : digits(x, 2));
  return h("details", null, h("summary", null, "Largest residuals"),
    table(["tag, corner", "seen at [px]", "residual [px]", "size [px]", ""],
      known.slice(0, WORST).map((corner) => [
        [corner.tag, corner.corner].map((id) => (isNumber(id) ? String(id) : NONE)).join(", "),
        `${corner.u.toFixed(2)}, ${corner.v.toFixed(2)}`,
        `${signed(corner.du)}, ${signed(corner.dv)}`, digits(corner.size, 2),
        corner.rejected ? "rejected" : ""]), { numeric: [1, 2, 3], label: "Largest residuals" }));
}

export function hypothesesTable(view) {
  if (!view.hypotheses?.length) return null;
  const rows = view.hypotheses.map(({ camera_from_world: pose, probability, rms_px }, i) => [
    String(i + 1), isNumber(probability) ? `${digits(100 * probability, 3)} %` : NONE, px(rms_px),
    pose ? [0, 1, 2].map((row) => pose[row][3].toFixed(4)).join(", ") : NONE]);
  return table(["pose", "probability", "RMS", "world's origin in the camera: x, y, z [m]"], rows,
    { numeric: [1, 2, 3], label: "Poses that fit" });
}

function content(data, index) {
  const view = data.views[index];
  const seen = cornersOfView(data, index);
  const { factor, size, image } = overlay(data, view, seen);
  image.style.maxWidth = `calc(74vh * ${size[0] / size[1]})`;  // so that it is 74vh high at most
  const zoom = zoomable(image, size);
  const rejected = seen.some((corner) => corner.rejected);
  const button = (words, label, action) =>
    h("button", { type: "button", "aria-label": label, click: action }, words);
  return { zoom, nodes: [
    h("div", { class: "viewer-image" }, image,
      h("div", { class: "zoom" }, button("+", "zoom in", () => zoom.zoomBy(1.6)),
        button("−", "zoom out", () => zoom.zoomBy(1 / 1.6)), button("1:1", "whole", zoom.reset))),
    h("p", { class: "legend" }, key("ring-detected", "detected"),
      key("plus-reprojected", "reprojected"),
      key("line-magnified", `residual, drawn ${count(factor, "", "").trim()} × as long`),
      rejected ? key("cross-rejected", "rejected") : null),
    h("p", null, view.status === "ok" ? "" : `${view.status}. `, captionOf(view),
      isNumber(view.max_px) ? `, largest ${px(view.max_px)}` : "",
      view.sentence ? `. ${view.sentence}` : ""),
    view.findings?.length ? findingList(view.findings) : null,
    hypothesesTable(view), worstTable(seen)] };
}

let dialog = null;

// Shows the view with this index; order is that of "previous" and "next". Escape closes (by the
// dialog element itself), arrows go on.
export function openView(data, order, index) {
  dialog?.remove();
  const title = h("h2", { id: "viewer-title" });
  const body = h("div", { class: "viewer-body" });
  let at = Math.max(0, order.indexOf(index));
  let zoom = null;
  const show = (step) => {
    at = (at + step + order.length) % order.length;
    const shown = content(data, order[at]);
    zoom = shown.zoom;
    title.textContent = `${data.views[order[at]].image} (${at + 1} of ${order.length})`;
    dialog.dataset.view = order[at];
    body.replaceChildren(...shown.nodes.filter(Boolean));
  };
  const keys = { ArrowRight: () => show(1), ArrowLeft: () => show(-1), "+": () => zoom.zoomBy(1.6),
                 "-": () => zoom.zoomBy(1 / 1.6), 0: () => zoom.reset() };
  const button = (words, label, action) =>
    h("button", { type: "button", "aria-label": label, click: action }, words);
  dialog = h("dialog", { class: "viewer", "aria-labelledby": "viewer-title",
    keydown: (event) => { if (!event.ctrlKey && !event.metaKey) keys[event.key]?.(); },
    click: (event) => { if (event.target === dialog) dialog.close(); } },
  h("div", { class: "viewer-head" }, title, h("div", { class: "buttons" },
    button("‹", "previous picture", () => show(-1)), button("›", "next picture", () => show(1)),
    button("✕", "close", () => dialog.close()))), body);
  document.body.append(dialog);
  show(0);
  dialog.showModal();
}
