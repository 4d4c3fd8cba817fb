// Where in the image corners were seen.
import { chart, h, key, section } from "../dom.js";
import { count, percent } from "../numbers.js";
import { corners } from "../data.js";
import { crosses, dots, imageFrame, polygon } from "../plot/frame.js";

export function coverage(data) {
  const all = corners(data);
  if (!data.image_size || !all.length) return null;
  const [width] = data.image_size;
  const used = all.filter((corner) => !corner.rejected);
  const rejected = all.filter((corner) => corner.rejected);
  const at = (list) => list.map(({ u, v }) => [u, v]);
  const hull = data.seen?.hull ?? [];
  const share = percent(data.seen?.share);
  const image = imageFrame(data.image_size,
    hull.length > 2 ? polygon(hull, "seen") : null,
    dots(at(used), all.length > 8000 ? "used fine" : "used"),
    crosses(at(rejected), width / 120, "rejected"));
  return section("coverage", "Coverage of the image", null, chart({
    name: "coverage", marks: all.length,
    label: `${count(all.length, "corner")} over the image, ${share} of it lies among them`,
    read: "each dot is a corner of the board. Outside of the dashed line no corner was seen: " +
      "there the lens is extrapolated, and the next pictures should show the board.",
  }, image, h("p", { class: "legend" },
    key("dot-used", `${count(used.length, "corner")} used`),
    rejected.length ? key("cross-rejected", `${count(rejected.length, "corner")} rejected`) : null,
    hull.length > 2 ? key("line-seen", `covered: ${share}`) : null)));
}
