// The cameras of a rig: rows of numbers, their places, and what is known of each lens.
import { h, section, table } from "../dom.js";
import { NONE, count, isNumber } from "../numbers.js";
import { coverage } from "./coverage.js";
import { findingList } from "./findings.js";
import { parameters } from "./parameters.js";
import { uncertainty } from "./uncertainty.js";
import { plusMinus } from "./verdict.js";

const LISTED = 8;  // cameras that have their own entry in the contents, and stand open

export const linkTo = (data, camera) =>
  h("a", { href: `#camera-${camera}` }, data.cameras[camera].name);

// Advice in the words of the terminal.
export function next(data) {
  if (!data.next) return null;
  const what = data.kind === "handeye" ? "pose" : "picture";
  return section("next", `The next ${what} to take`, { wide: true },
    h("p", { class: "lead" }, data.next.charAt(0).toUpperCase() + data.next.slice(1)));
}

function placesTable(data) {
  const placed = data.cameras.map((camera, index) => ({ camera, index }))
    .filter(({ camera }) => camera.place);
  if (!placed.length) return null;
  const from = isNumber(data.reference) ? data.cameras[data.reference].name : "the rig";
  return [h("h3", null, `Places, from ${from}`),
    table(["", "x [mm]", "y [mm]", "z [mm]", "rotation x [°]", "y [°]", "z [°]"],
      placed.map(({ camera, index }) => [linkTo(data, index),
        ...camera.place.map((text) => plusMinus(text))]),
      { numeric: [1, 2, 3, 4, 5, 6], label: "Places of the cameras" }),
    h("p", { class: "read" }, h("b", null, "How to read it: "),
      "the pose takes points in the frame of ", from, " to that of the camera: translation, and ",
      "rotation as its axis times the angle, with one standard deviation of the joint covariance.")];
}

export function rigCameras(data) {
  const rows = data.cameras.filter((camera) => camera.model);
  if (!rows.length) return null;
  const known = data.cameras.some((camera) => isNumber(camera.num_views));
  const cells = (camera) => (known ? [String(camera.num_views), String(camera.num_corners),
    camera.rms_px, camera.excess] : []);
  return section("cameras", "Cameras", { wide: true },
    table(["camera", "model", ...(known ? ["views", "corners", "rms [px]", "excess"] : [])],
      data.cameras.map((camera, index) => [camera.parameters ? linkTo(data, index) : camera.name,
        camera.model ?? NONE, ...cells(camera)]),
      { numeric: [2, 3, 4, 5], label: "Cameras of the rig" }),
    known ? h("p", { class: "read" }, h("b", null, "How to read it: "),
      "excess is by how much the rig moves the corners of a camera from where its own poses have ",
      "them, beyond what noise does, over their noise. Below 0.5 it agrees with the others.") : null,
    placesTable(data));
}

// A section of a camera's own page, inside of another section.
function part(node, index) {
  if (!node) return null;
  node.id = `${node.id}-${index}`;
  node.className = node.classList.contains("wide") ? "part wide" : "part";
  const head = node.querySelector("h2");
  head.replaceWith(h("h3", null, head.textContent));
  return node;
}

function lens(camera, index, isListed) {
  const own = camera.findings ?? [];
  const content = h("div", { class: "cards" },
    [parameters, coverage, uncertainty].map((make) => part(make(camera), index)));
  return section(`camera-${index}`, `Camera ${camera.name}`,
    { wide: true, "data-unlisted": isListed ? null : "1" },
    isListed ? content : h("details", null, h("summary", null, `Lens ${camera.model}`), content),
    own.length ? h("details", null,
      h("summary", null, `${count(own.length, "finding")} of its own calibration`),
      findingList(own)) : null);
}

export function rigLenses(data) {
  const isListed = data.cameras.length <= LISTED;
  return data.cameras.map((camera, index) =>
    (camera.parameters ? lens(camera, index, isListed) : null));
}
