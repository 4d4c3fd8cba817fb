// Standard deviation of the projection over the image, at several distances.
import { chart, h, section, table } from "../dom.js";
import { VIRIDIS } from "../colour.js";
import { digits, distance, distanceTitle, isNumber } from "../numbers.js";
import { colourBar, colourScale, heatmap } from "../plot/heatmap.js";

const finite = (maps) => maps.flatMap((map) => (map.sigma_px ?? []).flat()).filter(isNumber);

function mapOf(map, scale, data) {
  const values = map.sigma_px.flat();
  const missing = values.filter((value) => !isNumber(value)).length;
  const hull = data.seen?.hull ?? null;
  return h("div", { class: "small-map" },
    h("h3", null, distanceTitle(map.distance_m)),
    heatmap(map.sigma_px, scale, data.image_size, { hull }),
    missing ? h("p", { class: "note" }, `Hatched: no ray at ${missing} of ${values.length} nodes.`)
      : null);
}

export function uncertainty(data) {
  const maps = (data.projection ?? []).filter((map) => map.sigma_px?.length > 1);
  const values = finite(maps);
  if (!data.image_size || !values.length) return null;
  const scale = colourScale(values, VIRIDIS);
  return section("uncertainty", "Uncertainty of the projection", { wide: true },
    h("p", null, "How well the camera knows in which pixel it sees a point (1 sd per coordinate). ",
      "This is the number to judge a calibration by."),
    chart({
      name: "uncertainty", marks: values.length,
      label: `Standard deviation of the projection at ${maps.length} distances`,
      read: "dark is well known, bright is uncertain; lines join equal values, in pixels. Inside " +
        "of the dashed line corners were seen. Outside of it the numbers hold only as far as the " +
        "lens model does.",
    }, h("div", { class: "grid many" }, maps.map((map) => mapOf(map, scale, data))),
    colourBar(scale, "px")),
    table(["distance", "centre [px]", "at corners [px]", "worst [px]"], maps.map((map) => [
      distance(map.distance_m), digits(map.centre_px), digits(map.region_px), digits(map.max_px)]),
    { numeric: [1, 2, 3], label: "Standard deviation of the projection" }));
}
