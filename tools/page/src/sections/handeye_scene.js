// The robot in 3D, in the frame of its base.
import { chart, h, key, section } from "../dom.js";
import { count } from "../numbers.js";
import { buildHandeyeScene } from "../plot/handeye_items.js";
import { orbit } from "../plot/orbit.js";

function wordsOf(data) {
  if (!data.mount_from_camera) return "Camera and board are not drawn: their places are not known. ";
  return data.mount === "hand" ? "A line leads from each hand to its camera. "
    : "The board is drawn where each pose of the hand held it. ";
}

export function handeyeScene(data) {
  const hands = data.poses.filter((pose) => pose.base_from_hand).length;
  if (!hands) return null;
  const scene = buildHandeyeScene(data);
  const view = orbit(scene, {
    label: `The robot's base and ${count(hands, "pose")} of its hand in 3D`,
    pick: (index) => document.getElementById(`pose-${index}`)?.scrollIntoView({ block: "center" }),
    nameOf: (index) => data.poses[index].image,
  });
  const button = (words, ...angles) => h("button", { type: "button",
    click: () => view.look(...angles) }, words);
  const rejected = data.poses.some(({ state }) => state === "rejected");
  return section("scene", "The robot", null, chart({
    name: "robot", marks: scene.items.length, label: `${count(hands, "pose")} of the hand`,
    read: "axes x, y, z of base and hand are red, green and blue. " + wordsOf(data) +
      "Good are turns by 30 degrees or more about different axes. Drag to turn, wheel or two " +
      "fingers to come closer, arrow keys and + - after a click" +
      (data.robot ? "; click a pose for its numbers." : "."),
  }, view.node,
  h("p", { class: "controls" }, button("From the side", 0.6, 0.35), button("From above", 0, 1.57)),
  h("p", { class: "legend" },
    data.mount_from_camera ? key("line-camera", "camera") : null, key("square-veil", "hand"),
    rejected ? key("line-rejected", "contradicts the others") : null,
    data.next_hand ? key("line-of--orange", "next pose to take") : null,
    !data.mount_from_camera || !data.boards.length ? null : data.mount === "hand"
      ? key("square-board", "board") : key("square-veil", "board, in the hand"))));
}
