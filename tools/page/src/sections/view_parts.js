// What thumbnails and the enlarged picture share.
import { s } from "../dom.js";
import { count, isNumber, px } from "../numbers.js";

export const isAnswer = (view) => view.status === "ok" || view.status === "ambiguous";

// The picture (or a blank frame) in pixels of the camera.
export function picture(view, size) {
  const [width, height] = size;
  return view.thumbnail?.startsWith("data:image/")
    ? s("image", { x: -0.5, y: -0.5, width, height, preserveAspectRatio: "none",
                   href: view.thumbnail })
    : s("rect", { x: -0.5, y: -0.5, width, height, class: "no-picture" });
}

export function captionOf(view) {
  const parts = [isNumber(view.rms_px) ? `RMS ${px(view.rms_px)}` : ""];
  parts.push(count(view.num_corners ?? 0, "corner"));
  if (view.num_rejected) parts.push(`${view.num_rejected} rejected`);
  if (isNumber(view.time_s)) parts.push(`at ${view.time_s.toFixed(3)} s`);
  return parts.filter(Boolean).join(", ");
}
