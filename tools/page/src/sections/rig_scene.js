// The rig in 3D, with the boards where its instants show them.
import { chart, h, key, section } from "../dom.js";
import { count } from "../numbers.js";
import { orbit } from "../plot/orbit.js";
import { buildRigScene, enlargementOf } from "../plot/scene_items.js";

// One canvas with its heading.
function orbitOf(data, title, alone) {
  const scene = buildRigScene(data, alone);
  const view = orbit(scene, {
    label: `${title} in 3D`,
    pick: (index) => document.getElementById(`camera-${index}`).scrollIntoView(),
    nameOf: (index) => data.cameras[index].name,
  });
  return { ...view, marks: scene.items.length, part: h("div", null, h("h3", null, title), view.node) };
}

export function rigScene(data) {
  const cameras = data.cameras.filter((camera) => camera.rig_from_camera);
  if (cameras.length < 2) return null;
  const instants = (data.instants ?? []).filter((instant) => instant.rig_from_world).length;
  const factor = enlargementOf(cameras);
  const views = [instants ? orbitOf(data, "With the boards", false) : null,
    orbitOf(data, "The cameras alone", true)].filter(Boolean);
  const button = (words, ...angles) => h("button", { type: "button",
    click: () => views.forEach((view) => view.look(...angles)) }, words);
  return section("scene", "The rig", { wide: true }, chart({
    name: "rig", marks: views.reduce((sum, view) => sum + view.marks, 0),
    label: `${count(cameras.length, "camera")} in 3D`,
    read: (factor ? "ellipsoids are one standard deviation of a camera's centre in the frame of " +
      `the reference, which is exact by definition; they are drawn ${factor} × as large. ` : "") +
      (instants ? "Boards stand where the cameras saw them: good are many places and tilts, near " +
        "and far. " : "") + "Drag to turn, wheel or two fingers to come closer, arrow keys and " +
      "+ - after a click; click a camera for its lens.",
  }, h("div", { class: "grid two" }, views.map((view) => view.part)),
  h("p", { class: "controls" }, button("From the side", 0.6, 0.35), button("From above", 0, 1.57)),
  h("p", { class: "legend" }, key("line-camera", "camera"),
    factor ? key("line-rejected", `1 sd of its centre, ${factor} ×`) : null,
    instants ? key("square-veil", "board") : null)));
}
