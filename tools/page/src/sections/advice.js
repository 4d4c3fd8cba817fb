// The next picture to take: the board as it should be seen.
import { chart, h, key, section } from "../dom.js";
import { corners } from "../data.js";
import { digits, isNumber, px } from "../numbers.js";
import { dots, imageFrame, polygon } from "../plot/frame.js";

// What the picture would gain, unless the sentence says it.
function gainOf({ sentence, focal_sigma_now_px: now, focal_sigma_px: then }) {
  if (/standard deviation/.test(sentence)) return null;
  if (!isNumber(now) || !isNumber(then)) return null;
  const times = now / then;
  return `With this picture the sd of the focal length would go from ${px(now)} to ${px(then)}` +
    (times > 1.05 ? ` (${digits(times, 2)} times better).` : ": it adds little.");
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

export function advice(data) {
  const next = data.advice;
  if (!next) return null;
  const squares = next.squares_px ?? [];
  const seen = corners(data).filter((corner) => !corner.rejected).map(({ u, v }) => [u, v]);
  return section("next-view", "The next picture to take", { class: "card drawing" },
    h("p", { class: "lead" }, capital(next.sentence ?? "")),
    data.image_size && next.outline_px?.length ? chart({
      name: "next-view", marks: squares.length || 1,
      label: "The board as it should be seen in the next picture",
      read: "hold the board so that the camera sees it like this. Grey dots are the corners that " +
        "the pictures already have.",
    }, imageFrame(data.image_size, dots(seen, "faint"), polygon(next.outline_px, "board"),
      squares.map((square) => polygon(square, "square"))),
    h("p", { class: "legend" }, key("square-board", "the board, next"),
      key("dot-faint", "corners so far"))) : null,
    h("p", null, gainOf(next)));
}
