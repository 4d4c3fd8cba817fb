// The head of the page: what it is, the verdict in a sentence, and the numbers that matter.
import { isCalibration } from "../data.js";
import { h } from "../dom.js";
import { count, digits, isNumber, median, percent, px } from "../numbers.js";
import { isAnswer } from "./view_parts.js";

const LEVELS = {
  ok: ["✓", "OK"],
  warnings: ["!", "OK, with warnings"],
  ambiguous: ["?", "Ambiguous"],
  no_answer: ["✕", "No answer"],
};

const LEVELS_OF = {
  difference: { ok: ["✓", "Consistent"], warnings: ["!", "They differ"] },
  fleet: { ok: ["✓", "No unit fails"], warnings: ["!", "Units fail"] },
};

const STATUS = {
  ambiguous: "A single view fits two poses. Both are given, with odds. A further view decides.",
  focal_not_observable: "The pictures do not determine the focal length. Take views with the " +
    "board tilted by 30 degrees or more.",
  not_observable: "The pictures do not determine all parameters. A finding names them.",
  degenerate: "The corners lie on a line, repeat each other, or are too few.",
  no_consensus: "Too many corners are wrong. Check that the board in the pictures is the one " +
    "that was named, with its true size.",
  not_converged: "The solver found no minimum. Check the pictures and the board.",
};

function tile(term, value, note) {
  return h("div", { class: "tile" }, h("dt", null, term), h("dd", null, value),
    note ? h("dd", { class: "note" }, note) : null);
}

function focalTile(data) {
  const focal = data.parameters?.find((p) => ["f", "fx"].includes(p.name));
  if (!focal) return null;
  if (!isNumber(focal.value)) return tile("Focal length", "not determined", null);
  const sd = focal.sigma === 0 ? "held, not estimated"
    : isNumber(focal.sigma) ? "± 1 standard deviation" : null;
  return tile(`Focal length (${focal.name})`,
    `${plusMinus(focal.text)}\u00a0${focal.unit ?? ""}`, sd);
}

// "902.496 +- 0.012" with the sign that print uses.
export const plusMinus = (text) => text?.replace(/\+- /g, "±\u00a0").replace(/^-/, "−") ?? "";

function projectionTile(data) {
  const regions = data.projection?.filter((map) => isNumber(map.region_px)) ?? [];
  if (!regions.length) return null;
  const worst = regions.reduce((a, b) => (a.region_px >= b.region_px ? a : b));
  return tile("Projection known to", px(worst.region_px), "sd where corners were");
}

// Answers of tagcal pose: each view has its own.
function poseTiles({ views }) {
  const ambiguous = views.filter((view) => view.status === "ambiguous").length;
  const known = views.map((view) => view.rms_px).filter(isNumber);
  return [
    tile("Pictures", String(views.length),
      `${views.filter(isAnswer).length} with a pose${ambiguous ? `, ${ambiguous} ambiguous` : ""}`),
    known.length ? tile("Residuals", px(median(known)), "RMS per corner, median picture") : null,
    known.length ? tile("Worst picture", px(Math.max(...known)), "RMS per corner") : null,
  ].filter(Boolean);
}

// The rig in numbers; a pair that disagrees most says how well its cameras agree.
function rigTiles(data) {
  const { cameras = [], pairs = [], instants } = data;
  const nameOf = (pair) => `${cameras[pair.a].name} \u2013 ${cameras[pair.b].name}`;
  const rejected = instants?.filter(({ state }) => state === "rejected").length;
  const worst = pairs.filter((pair) => isNumber(pair.disagreement_sd))
    .sort((a, b) => b.disagreement_sd - a.disagreement_sd)[0];
  return [
    tile("Cameras", String(cameras.length),
      isNumber(data.reference) ? `reference: ${cameras[data.reference].name}` : null),
    isNumber(data.num_instants)
      ? tile("Instants", `${data.num_instants} of ${data.num_paired}`,
        rejected ? `${rejected} with rejected pictures` : "none rejected") : null,
    isNumber(data.rms_px) ? tile("Residuals", px(data.rms_px), "RMS per corner") : null,
    pairs.length === 1 ? tile("Baseline", plusMinus(pairs[0].baseline), nameOf(pairs[0])) : null,
    worst ? tile("Largest disagreement", worst.disagreement, nameOf(worst)) : null,
  ].filter(Boolean);
}

// The robot in numbers; without an answer only how many poses there are.
function handeyeTiles({ poses, robot, rms_px: rms, known_to: known }) {
  const number = (state) => poses.filter((pose) => pose.state === state).length;
  const without = [[number("rejected"), "rejected"], [number("unusable"), "without a pose"]]
    .filter(([n]) => n).map(([n, words]) => `${n} ${words}`).join(", ");
  return [
    tile("Poses", robot ? `${number("used")} of ${poses.length}` : String(poses.length),
      without || (robot ? "none rejected" : null)),
    isNumber(rms) ? tile("Residuals", px(rms), "RMS per corner") : null,
    robot ? tile("Robot's position", `${robot.mm}\u00a0mm`, "sd per axis, estimated") : null,
    robot ? tile("Robot's rotation", `${robot.deg}\u00a0°`, "sd per axis, estimated") : null,
    known ? tile("Camera known to", known, "sd of its place, worst direction") : null,
  ].filter(Boolean);
}

function tiles(data) {
  if (data.kind === "handeye") return handeyeTiles(data);
  if (data.kind === "rig") return rigTiles(data);
  if (data.kind === "poses" && data.views?.length) return poseTiles(data);
  const rejected = data.num_rejected ? `${count(data.num_rejected, "corner")} rejected` : null;
  return [
    data.model ? tile("Lens model", data.model, data.chosen ? "chosen by tagcal" : null) : null,
    focalTile(data),
    projectionTile(data),
    isNumber(data.rms_px) ? tile("Residuals", px(data.rms_px), "RMS per corner") : null,
    isNumber(data.noise_px)
      ? tile("Corner noise", px(data.noise_px), "sd per coordinate") : null,
    isCalibration(data) && isNumber(data.seen?.share)
      ? tile("Image covered", percent(data.seen.share), "lies among the corners") : null,
    isNumber(data.num_pictures)
      ? tile("Pictures", String(data.num_pictures),
        [isNumber(data.num_corners) ? count(data.num_corners, "corner") : null, rejected]
          .filter(Boolean).join(", ")) : null,
    isNumber(data.halves?.ratio)
      ? tile("Cross-check", `${digits(data.halves.ratio)} ×`,
        data.halves.disagree ? "two halves of the pictures disagree"
          : "two halves differ by this times their noise") : null,
  ].filter(Boolean);
}

export function verdict(data) {
  const { level = "ok", sentence = "" } = data.verdict ?? data.difference?.verdict ?? {};
  const [mark, word] = (LEVELS_OF[data.kind] ?? LEVELS)[level] ?? LEVELS.warnings;
  const said = data.findings?.some(({ severity }) => severity === "error");
  const advice = said ? null : STATUS[data.status];
  const shown = tiles(data);
  return h("header", { class: `verdict ${level}`, "data-level": level },
    h("p", { class: "kind" }, kindOf(data)),
    h("h1", null, data.title ?? "tagcal report"),
    h("p", { class: "sentence" },
      h("span", { class: "badge" }, h("span", { "aria-hidden": "true" }, mark),
        ` ${counted(sentence) ?? word}`),
      withoutWord(sentence, word)),
    data.noise_sentence ? h("p", { class: "note" }, `Noise: ${data.noise_sentence}`) : null,
    advice ? h("p", { class: "advice" }, advice) : null,
    shown.length ? h("dl", { class: "tiles" }, shown) : null);
}

const KINDS = { calibration: "Camera calibration", rig: "Cameras on one body", poses: "Camera poses",
                difference: "Difference of two calibrations", fleet: "Cameras of one make",
                handeye: "A camera on a robot" };
const kindOf = (data) => KINDS[data.kind] ?? KINDS.calibration;

// "OK, 5 warnings", where the sentence counts them.
const counted = (sentence) => /^OK, \d+ [a-z]+(?=:)/.exec(sentence)?.[0];

// The sentence without the word that the badge already says ("OK: ..", "NO ANSWER: ..").
function withoutWord(sentence, word) {
  const at = sentence.indexOf(":");
  const start = sentence.slice(0, Math.max(0, at)).toLowerCase();
  const repeats = at > 0 &&
    (word.toLowerCase().startsWith(start) || /^(ok|no answer|valid|changed|cannot tell)/.test(start));
  return repeats ? sentence.slice(at + 1).trim() : sentence;
}
