// The items of a robot in 3D: its base, the poses of its hand, cameras and boards.
import { IDENTITY, apply, boardItem, cameraItem, compose, extentOf, middleOf, spread } from
  "./scene_items.js";

const MOST_HANDS = 60;  // that are drawn, besides those that contradict
const AXES = ["--vermilion", "--green", "--blue"];
const COLOURS = { rejected: "--vermilion", next: "--orange" };

const centreOf = (pose) => pose.map((row) => row[3]);

// The axes of a frame, x y z.
const axes = (pose, length) => AXES.map((stroke, i) => ({ stroke, width: 2,
  points: [centreOf(pose), apply(pose, [0, 1, 2].map((k) => (k === i ? length : 0)))] }));

// A square about the origin of a frame, across its z axis, and the frame's axes.
function frameItem(pose, length, colour, more) {
  const points = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    .map(([x, y]) => apply(pose, [0.4 * length * x, 0.4 * length * y, 0]));
  return { middle: centreOf(pose), ...more, faces: [
    { points, closed: true, fill: `${colour}-band`, stroke: colour }, ...axes(pose, length)] };
}

// The poses to draw, with their index: all that contradict, and the one to take next.
function handsOf(data) {
  const known = data.poses.map(({ state, base_from_hand: hand }, index) => ({ state, hand, index }))
    .filter(({ hand }) => hand);
  const rejected = known.filter(({ state }) => state === "rejected");
  const others = spread(known.filter(({ state }) => state !== "rejected"), MOST_HANDS);
  return [...others, ...rejected, ...(data.next_hand ? [{ state: "next", hand: data.next_hand }] : [])];
}

// The boards in the frame of their holder; without a known one the axes of its frame.
const boardItems = (data, pose, length, veil, more) => (data.boards.length
  ? data.boards.map((board) => ({ ...boardItem(board, compose(pose, board.world_from_board), !veil,
    veil ?? "--board"), ...more }))
  : [frameItem(pose, length, "--blue", more)]);

const boardPoints = (data, pose) => (data.boards.length ? data.boards.flatMap((board) =>
  board.outline.map((point) => apply(compose(pose, board.world_from_board), point))) : [centreOf(pose)]);

// What a pose of the hand carries: the camera, or the board.
function carried(data, { state, hand, index }, length) {
  const colour = COLOURS[state] ?? "--blue";
  if (data.mount === "hand") {
    const pose = compose(hand, data.mount_from_camera);
    return [cameraItem(pose, length, data.image_size ?? [4, 3], colour, index),
      { middle: middleOf([centreOf(hand), centreOf(pose)]), faces: [
        { points: [centreOf(hand), centreOf(pose)], stroke: "--soft" }] }];
  }
  return boardItems(data, compose(hand, data.holder_from_board), length, `${colour}-band`,
    { view: index });
}

// What stands still beside the base: the board, or the camera.
function atRest(data, length) {
  if (data.mount === "hand")
    return boardItems(data, data.holder_from_board, length, null, { label: "board" });
  return [{ ...cameraItem(data.mount_from_camera, length, data.image_size ?? [4, 3], "--blue"),
            label: "camera" }];
}

// Everything in the frame of the base. Without places of camera and board the hand alone.
export function buildHandeyeScene(data) {
  const hands = handsOf(data);
  const hasPlaces = Boolean(data.mount_from_camera);
  const boards = !hasPlaces ? [] : data.mount === "hand" ? boardPoints(data, data.holder_from_board)
    : [centreOf(data.mount_from_camera), ...hands.flatMap(({ hand }) =>
      boardPoints(data, compose(hand, data.holder_from_board)))];
  const points = [[0, 0, 0], ...hands.map(({ hand }) => centreOf(hand)), ...boards];
  const length = (hands.length > 30 ? 0.05 : 0.08) * extentOf(points).radius;
  const items = [
    frameItem(IDENTITY, 2 * length, "--blue", { label: "base" }),
    ...hands.map((one) => frameItem(one.hand, 0.7 * length, COLOURS[one.state] ?? "--blue",
      { view: one.index, label: one.state === "next" ? "next" : undefined })),
    ...(hasPlaces ? [...atRest(data, length), ...hands.flatMap((one) => carried(data, one, length))] : [])];
  return { ...extentOf(points), whole: true, items };
}
