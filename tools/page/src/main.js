// The page of tagcal report: reads the data that stand in the page and shows a section for each
// part of them. Each section returns its element, or null if there is nothing to show.
import { h } from "./dom.js";
import { isCalibration } from "./data.js";
import { hatchPattern } from "./plot/frame.js";
import { advice } from "./sections/advice.js";
import { coverage } from "./sections/coverage.js";
import { difference } from "./sections/difference.js";
import { findings } from "./sections/findings.js";
import { fleetCharts, fleetDrifts, fleetPopulation, fleetWorst } from "./sections/fleet.js";
import { formats } from "./sections/formats.js";
import { handeyeInputs, handeyePlaces, handeyePoses } from "./sections/handeye.js";
import { handeyeScene } from "./sections/handeye_scene.js";
import { ladder } from "./sections/ladder.js";
import { madeBy } from "./sections/made.js";
import { parameters } from "./sections/parameters.js";
import { residuals } from "./sections/residuals.js";
import { next, rigCameras, rigLenses } from "./sections/rig.js";
import { rigDepth, rigPairs } from "./sections/rig_pairs.js";
import { rigRectified } from "./sections/rig_rectified.js";
import { rigScene } from "./sections/rig_scene.js";
import { rigTimeline } from "./sections/rig_timeline.js";
import { scene } from "./sections/scene.js";
import { uncertainty } from "./sections/uncertainty.js";
import { verdict } from "./sections/verdict.js";
import { views } from "./sections/views.js";
import { warp } from "./sections/warp.js";

const CALIBRATION = [findings, parameters, coverage, advice, residuals, uncertainty, views, scene,
  warp, ladder, formats, madeBy];
const SECTIONS = {
  calibration: CALIBRATION,
  poses: [findings, views, scene, residuals, formats, madeBy],
  rig: [findings, next, rigCameras, rigScene, rigPairs, rigDepth, rigRectified, rigTimeline,
    rigLenses, formats, madeBy],
  handeye: [findings, handeyePlaces, handeyeScene, next, handeyePoses, formats, handeyeInputs,
    madeBy],
  difference: [findings, difference, formats, madeBy],
  fleet: [findings, fleetPopulation, fleetWorst, fleetDrifts, fleetCharts, madeBy],
};

// A section that fails must not take the others with it: it says so in its place.
function safely(make, data) {
  try {
    return make(data);
  } catch (error) {
    console.error(error);
    return h("section", { class: "card failed" },
      h("p", null, `The section "${make.name}" cannot be shown: ${error.message}`));
  }
}

function contents(sections) {
  return h("nav", { "aria-label": "Sections" }, sections.map((node) =>
    node.id && !node.dataset.unlisted ? h("a", { href: `#${node.id}` }, node.querySelector("h2")?.textContent ?? "") : null));
}

function build(data) {
  const sections = (SECTIONS[data.kind] ?? CALIBRATION).flatMap((make) => safely(make, data))
    .filter(Boolean);
  document.title = data.title ? `${data.title} - tagcal report` : "tagcal report";
  document.body.append(hatchPattern(), h("main", null, safely(verdict, data), contents(sections),
    h("div", { class: "cards" }, sections)));
  if (!isCalibration(data)) document.body.classList.add(data.kind);
}

build(JSON.parse(document.getElementById("data").textContent));
document.documentElement.dataset.ready = "1";
