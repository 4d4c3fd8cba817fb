// A camera on a robot: both places, the robot's noise, its deviation of each pose, the inputs.
import { h, section, table } from "../dom.js";
import { NONE, count, digits, isNumber } from "../numbers.js";
import { rowTable } from "./made.js";
import { pictureBars } from "./rms.js";
import { plusMinus } from "./verdict.js";

const DEGREE = Math.PI / 180;
const read = (...words) => h("p", { class: "read" }, h("b", null, "How to read it: "), ...words);

const COORDINATES = ["x [mm]", "y [mm]", "z [mm]", "rotation x [°]", "rotation y [°]",
  "rotation z [°]"];

export function handeyePlaces(data) {
  if (!data.robot) return null;
  const { text, axes, clocks } = data.robot;
  return section("places", "Camera, board and robot", null,
    table(["", ...data.places.map(({ title }) => title)], COORDINATES.map((name, i) =>
      [name, ...data.places.map(({ texts }) => plusMinus(texts[i]))]),
    { numeric: [1, 2], label: "Places of camera and board" }),
    rowTable([["robot", text], ["axes", axes], ["clocks", clocks]].filter(([, words]) => words)
      .map(([name, words]) => [name, plusMinus(words)])),
    read("the pose takes points in the frame of camera or board to that of hand or base: ",
      "translation, and rotation as its axis times the angle, with one standard deviation of noise ",
      "of corners, robot and lens. The robot's noise is estimated from the pictures: where it is ",
      "large, the robot, not the camera, limits the answer."));
}

// The word for a pose that is not used, and its place in the table.
const STATES = { rejected: ["rejected", 0], used: ["", 1], given: ["", 1], unusable: ["no pose", 2] };

// Poses that contradict, then the worst first.
function rowsOf(data) {
  return data.poses.map((pose, index) => ({ pose, index })).sort((a, b) =>
    STATES[a.pose.state][1] - STATES[b.pose.state][1] || (b.pose.score ?? 0) - (a.pose.score ?? 0));
}

function poseRows(data) {
  const hasPixels = data.poses.some((pose) => isNumber(pose.rms_px));
  const hasFits = Boolean(data.robot);
  const kept = (cells) => (hasFits ? cells.slice(hasPixels ? 0 : 1) : []);
  const heads = ["pose", ...kept(["residual [px]", "robot off by [mm]", "[°]", "[sd]"])];
  return h("div", { class: "long" }, table(heads, rowsOf(data).map(({ pose, index }) => {
    const [words] = STATES[pose.state];
    return [h("span", { id: `pose-${index}` }, pose.image, " ",
      words ? h("span", { class: "tag warn" }, words) : null),
    ...kept(pose.texts ?? Array(4).fill(NONE))];
  }), { numeric: kept([1, 2, 3, 4]).map((_, i) => i + 1), label: "Poses of the robot" }));
}

// One chart of the robot's deviation, beside what its noise in three axes is.
function deviation(data, name, title, unit, of, sigma) {
  const values = data.poses.map(of);
  const level = Math.sqrt(3) * sigma;
  return pictureBars({
    name, title, x: "pose", y: `deviation [${unit}]`, values, level,
    label: `${title} of ${count(values.filter(isNumber).length, "pose")}`,
    read: `one bar a pose, in the order given; dashed is the robot's noise of all three axes, ` +
      `${digits(level)} ${unit}. Bars of more than twice that are worth a look: was the robot at ` +
      "rest, did the board move, is it the pose of that picture?",
  });
}

export function handeyePoses(data) {
  if (!data.robot && data.poses.every(({ state }) => state === "given")) return null;
  const some = (value, factor) => (isNumber(value) ? value * factor : null);
  return section("poses", "Poses", { wide: true },
    !data.robot ? null : h("div", { class: "grid two" },
      deviation(data, "robot-position", "Position of the robot", "mm",
        (pose) => some(pose.error_m, 1e3), 1e3 * data.robot.sigma_m),
      deviation(data, "robot-rotation", "Rotation of the robot", "°",
        (pose) => some(pose.error_rad, 1 / DEGREE), data.robot.sigma_rad / DEGREE)),
    poseRows(data), read(
      !data.robot ? "" : "by how much the pose that the robot says differs from that which the camera " +
        "sees, the worst first; sd is both together in standard deviations of the robot's noise, 1 is " +
        "usual. ",
      "Rejected poses of the robot contradict the others; no pose: of the board in that picture, or of " +
        "the robot at its time."));
}

export const handeyeInputs = (data) =>
  section("inputs", "Inputs", { wide: true }, rowTable(data.inputs));
