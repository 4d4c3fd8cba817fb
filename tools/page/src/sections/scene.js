// Cameras and boards in 3D.
import { chart, h, key, section } from "../dom.js";
import { isCalibration } from "../data.js";
import { count, digits, distance, range } from "../numbers.js";
import { isAnswer } from "./view_parts.js";
import { orbit } from "../plot/orbit.js";
import { buildScene, distancesAndTilts } from "../plot/scene_items.js";
import { openView } from "./viewer.js";

function placesText(data) {
  const places = distancesAndTilts(data);
  const far = range(places.map((place) => place.distance));
  const tilt = range(places.map((place) => place.tilt));
  const board = data.boards.length === 1 ? "the board" : "the nearest board";
  return `Here they were ${distance(far.low)} to ${distance(far.high)} from the middle of ` +
    `${board}, tilted by ${tilt.low.toFixed(0)} to ${tilt.high.toFixed(0)} degrees.`;
}

// The size of the only board, which gives the scene its scale.
function sizeText({ outline }) {
  const edge = (a, b) => Math.hypot(...outline[a].map((x, i) => x - outline[b][i]));
  return `board, ${digits(edge(0, 1), 2)} × ${digits(edge(1, 2), 2)} m`;
}

// Buttons of which one is pressed, at first the first.
function choice(words, action) {
  const buttons = words.map((text, i) => h("button", { type: "button", "aria-pressed": String(!i),
    click: () => {
      buttons.forEach((other, j) => other.setAttribute("aria-pressed", String(i === j)));
      action(i);
    } }, text));
  return buttons;
}

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
    read: "where the camera was for each picture. " +
      (isCalibration(data) ? "Good: cameras on many sides, near and far, some tilted by 30 " +
        "degrees or more. " : "") +
      `${placesText(data)} Drag to turn, wheel or two fingers ` +
      "to come closer, arrow keys and + - after a click; click a camera for its picture.",
  }, view.node, h("p", { class: "controls" },
    button("From the side", () => view.look(0.6, 0.35)),
    button("From above", () => view.look(0, 1.57)),
    choice(["Boards stand still", "Camera stands still"],
      (i) => view.show(buildScene(data, i ? "camera" : "world")))),
  h("p", { class: "legend" }, key("line-camera", "camera"),
    off ? key("line-rejected", "rejected") : null,
    key("square-board", boards.length === 1 ? sizeText(boards[0]) : "board"))));
}
