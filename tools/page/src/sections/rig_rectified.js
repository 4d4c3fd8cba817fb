// One instant of a pair of cameras, rectified, with lines across both pictures.
import { chart, h, section } from "../dom.js";

export function rigRectified(data) {
  const pair = data.rectified;
  if (!pair) return null;
  const [a, b] = [pair.a, pair.b].map((camera) => data.cameras[camera].name);
  const [width, height] = pair.size;
  const { lines, order } = pair.is_vertical
    ? { lines: "columns", order: "above" } : { lines: "rows", order: "at the left" };
  return section("rectified", "A rectified pair", { wide: true }, chart({
    name: "rectified", marks: 1, label: `Rectified pictures of ${a} and ${b}`,
    read: `instant ${pair.instant}, ${a} ${order}: each point of the scene must be on equal ${lines} ` +
      "in both pictures, whatever its distance. Follow a line from a corner of the board to the " +
      "same corner in the other picture: where an offset is visible, a camera moved, or the two " +
      "pictures are of different instants.",
  }, h("img", { src: pair.uri, width, height, class: "rectified",
    alt: `${a} and ${b}, rectified, with lines across both pictures` })));
}
