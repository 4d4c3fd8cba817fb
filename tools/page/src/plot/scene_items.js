// The items of the 3D scene: boards with their squares, and cameras as pyramids.
import { quantile } from "../numbers.js";
import { isAnswer } from "../sections/view_parts.js";

export const apply = (pose, [x, y, z]) =>
  [0, 1, 2].map((i) => pose[i][0] * x + pose[i][1] * y + pose[i][2] * z + pose[i][3]);

// The inverse of a rigid pose.
function inverse(pose) {
  const rotated = [0, 1, 2].map((i) => [0, 1, 2].map((j) => pose[j][i]));
  return rotated.map((row) =>
    [...row, -(row[0] * pose[0][3] + row[1] * pose[1][3] + row[2] * pose[2][3])]);
}

export const compose = (a, b) => [0, 1, 2].map((i) => [0, 1, 2, 3].map((j) =>
  a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + (j === 3 ? a[i][3] : 0)));

export const middleOf = (points) => [0, 1, 2].map((i) =>
  points.reduce((sum, point) => sum + point[i], 0) / points.length);

// Camera axes (x right, y down, z forward) to a scene with z up.
const UPRIGHT = [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]];

export function boardItem(board, pose, squares, fill = "--board") {
  const outline = board.outline.map((point) => apply(pose, point));
  return { middle: middleOf(outline), faces: [
    { points: outline, closed: true, fill, stroke: "--soft" },
    ...(squares ? (board.squares ?? []).map((square) => ({
      points: square.map((point) => apply(pose, point)), closed: true, fill: "--square" })) : [])] };
}

// A camera as a pyramid of this depth, with the side of its image's top marked by a triangle.
export function cameraItem(worldFromCamera, depth, [width, height], colour, view) {
  const [x, y] = [0.6 * depth, 0.6 * depth * height / width];
  const at = (point) => apply(worldFromCamera, point);
  const tip = at([0, 0, 0]);
  const [a, b, c, d] = [at([-x, -y, depth]), at([x, -y, depth]), at([x, y, depth]),
    at([-x, y, depth])];
  const up = [at([-0.4 * x, -1.15 * y, depth]), at([0, -1.6 * y, depth]),
    at([0.4 * x, -1.15 * y, depth])];
  const line = (points) => ({ points, stroke: colour, width: 1.2 });
  return { view, middle: tip, faces: [
    { points: [a, b, c, d], closed: true, fill: `${colour}-band`, stroke: colour, width: 1.2 },
    line([tip, a]), line([tip, b]), line([tip, c]), line([tip, d]),
    { points: up, closed: true, fill: colour }] };
}

export function extentOf(points) {
  const centre = [0, 1, 2].map((i) => {
    const values = points.map((point) => point[i]);
    return (quantile(values, 0.02) + quantile(values, 0.98)) / 2;
  });
  const distances = points.map((point) => Math.hypot(...point.map((x, i) => x - centre[i])));
  return { centre, radius: Math.max(1e-6, quantile(distances, 0.97)) };
}

const boardPoints = (data, pose) => data.boards.flatMap((board) =>
  board.outline.map((point) => apply(compose(pose, board.world_from_board), point)));

export const IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]];
const colourOf = (view) => (isAnswer(view) ? "--blue" : "--vermilion");

// The boards stand still, one pyramid a picture.
function worldScene(data, posed) {
  const cameras = posed.map(({ view, index }) =>
    ({ view, index, pose: inverse(view.camera_from_world) }));
  const centres = cameras.map(({ pose }) => pose.map((row) => row[3]));
  const boards = boardPoints(data, IDENTITY);
  const target = middleOf(boards);
  const away = quantile(centres.map((c) => Math.hypot(...c.map((x, i) => x - target[i]))), 0.5);
  const size = Math.max(...data.boards.map((board) => extentOf(board.outline).radius));
  const depth = (posed.length > 60 ? 0.5 : 1) * Math.min(0.11 * away, 0.35 * size);
  return { ...extentOf([...boards, ...centres]), items: [
    ...data.boards.map((board) => boardItem(board, board.world_from_board, true)),
    ...cameras.map(({ view, index, pose }) =>
      cameraItem(pose, depth, data.image_size ?? [4, 3], colourOf(view), index))] };
}

// The camera stands still, the boards where each picture shows them.
function cameraScene(data, posed) {
  const poses = posed.map(({ view }) => compose(UPRIGHT, view.camera_from_world));
  const points = poses.flatMap((pose) => boardPoints(data, pose));
  const extent = extentOf([...points, [0, 0, 0]]);
  return { ...extent, items: [
    cameraItem(UPRIGHT, 0.2 * extent.radius, data.image_size ?? [4, 3], "--blue", undefined),
    ...poses.flatMap((pose, i) => data.boards.map((board) => ({
      ...boardItem(board, compose(pose, board.world_from_board), posed.length === 1,
        posed.length > 8 ? "--veil" : "--blue-band"),
      view: posed[i].index })))] };
}

const MOST_BOARDS = 60;  // that are drawn about a rig
const ENLARGED = 100;    // times, of ellipsoids, unless they hide the cameras or are not seen

const centreOfCamera = (camera) => camera.rig_from_camera.map((row) => row[3]).slice(0, 3);
const distanceOf = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
export const spread = (list, most) => (list.length <= most ? list
  : Array.from({ length: most }, (_, i) => list[Math.floor(i * list.length / most)]));

// The largest distance of two cameras, and the smallest of one from its nearest.
function spansOf(centres) {
  const all = centres.map((a) => centres.map((b) => distanceOf(a, b)));
  const nearest = all.flatMap((row) => Math.min(...row.filter((x) => x > 0)));
  return { largest: Math.max(...all.flat()), nearest: Math.min(...nearest) };
}

// How many times the ellipsoids of the cameras' centres are enlarged: 100, or another power of ten
// if they would be larger than half of the rig or smaller than a hundredth. 0: there are none.
export function enlargementOf(cameras) {
  const axes = cameras.flatMap((camera) => camera.centre_axes_m ?? []);
  const longest = Math.max(0, ...axes.map((axis) => Math.hypot(...axis)));
  const { largest } = spansOf(cameras.map(centreOfCamera));
  if (!(longest > 0) || !(largest > 0)) return 0;
  let factor = ENLARGED;
  while (factor > 1 && longest * factor > 0.5 * largest) factor /= 10;
  while (factor < 1e6 && longest * factor < 0.01 * largest) factor *= 10;
  return factor;
}

// The three ellipses in the planes of the axes.
function ellipsoidItem(camera, factor) {
  const centre = apply(UPRIGHT, centreOfCamera(camera));
  const axes = camera.centre_axes_m.map((axis) => apply(UPRIGHT, axis.map((x) => factor * x)));
  const ellipse = (a, b) => Array.from({ length: 32 }, (_, k) => centre.map((x, i) =>
    x + Math.cos(Math.PI * k / 16) * a[i] + Math.sin(Math.PI * k / 16) * b[i]));
  return { middle: centre, faces: [[0, 1], [1, 2], [2, 0]].map(([i, j]) => (
    { points: ellipse(axes[i], axes[j]), closed: true, fill: "--vermilion-band",
      stroke: "--vermilion", width: 1.2 })) };
}

// A rig with its cameras' ellipsoids; "alone" without the boards of its instants.
export function buildRigScene(data, alone) {
  const cameras = data.cameras.map((camera, index) => ({ camera, index }))
    .filter(({ camera }) => camera.rig_from_camera);
  const factor = enlargementOf(cameras.map(({ camera }) => camera));
  const centres = cameras.map(({ camera }) => apply(UPRIGHT, centreOfCamera(camera)));
  const used = (data.instants ?? []).filter((instant) => instant.rig_from_world);
  const poses = alone ? [] : spread(used, MOST_BOARDS)
    .map((instant) => compose(UPRIGHT, instant.rig_from_world));
  const boards = poses.flatMap((pose) => boardPoints(data, pose));
  const { largest, nearest } = spansOf(centres);
  const { radius } = extentOf([...boards, ...centres]);
  const depth = alone || !poses.length ? Math.min(0.3 * largest, 0.7 * nearest)
    : Math.min(0.2 * radius, Math.max(0.07 * radius, 0.4 * nearest));
  const pyramids = cameras.map(({ camera, index }) => cameraItem(
    compose(UPRIGHT, camera.rig_from_camera), depth, camera.image_size, "--blue", index));
  const corners = pyramids.flatMap((item) => item.faces.flatMap((face) => face.points));
  return { ...extentOf([...boards, ...corners]), whole: true, items: [
    ...pyramids,
    ...cameras.filter(({ camera }) => factor && camera.centre_axes_m)
      .map(({ camera }) => ellipsoidItem(camera, factor)),
    ...poses.flatMap((pose) => data.boards.map((board) => boardItem(board,
      compose(pose, board.world_from_board), poses.length === 1,
      poses.length > 8 ? "--veil" : "--blue-band")))] };
}

// How far the cameras were from the middle of the nearest board and how much they were tilted
// against it, in degrees.
export function distancesAndTilts(data) {
  return data.views.filter((view) => view.camera_from_world).map((view) => data.boards
    .map((board) => {
      const pose = compose(view.camera_from_world, board.world_from_board);
      return { distance: Math.hypot(...apply(pose, middleOf(board.outline))),
               tilt: Math.acos(Math.min(1, Math.abs(pose[2][2]))) * 180 / Math.PI };
    }).reduce((a, b) => (a.distance <= b.distance ? a : b)));
}

export function buildScene(data, still) {
  const posed = data.views.map((view, index) => ({ view, index }))
    .filter(({ view }) => view.camera_from_world);
  return still === "camera" ? cameraScene(data, posed) : worldScene(data, posed);
}
