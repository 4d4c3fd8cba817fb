// Cameras and boards in 3D.
import { chart, h, key, section } from "../dom.js";
import { count } from "../numbers.js";
import { isAnswer } from "./view_parts.js";
import { orbit } from "../plot/orbit.js";
import { buildScene } from "../plot/scene_items.js";
import { openView } from "./viewer.js";

export function scene(data) {
  const poses = (data.views ?? []).filter((view) => view.camera_from_world);
  const boards = data.boards ?? [];
  if (!poses.length || !boards.length) return null;
  const order = data.views.map((_, index) => index);
  const view = orbit(buildScene(data, "world"), {
    label: `${count(poses.length, "camera")} and ${count(boards.length, "board")} in 3D`,
    pick: (index) => openView(data, order, index),
    nameOf: (index) => data.views[index].image,
  });
  const button = (words, action) => h("button", { type: "button", click: action }, words);
  const off = poses.some((pose) => !isAnswer(pose));
  return section("scene", "Cameras and boards", null, chart({
    name: "scene", marks: poses.length + boards.length,
    label: `${count(poses.length, "camera")} and ${count(boards.length, "board")}`,
    read: "where the camera was for each picture. Good: cameras on many sides, near and far, " +
      "tilted and turned. Drag to turn, wheel or two fingers to come closer, arrow keys and + - " +
      "after a click; click a camera for its picture.",
  }, view.node, h("p", { class: "controls" },
    button("From the side", () => view.look(0.6, 0.35)),
    button("From above", () => view.look(0, 1.57)),
    button("Boards stand still", () => view.show(buildScene(data, "world"))),
    button("Camera stands still", () => view.show(buildScene(data, "camera")))),
  h("p", { class: "legend" }, key("line-camera", "camera"),
    off ? key("line-rejected", "rejected") : null, key("square-board", "board"))));
}
