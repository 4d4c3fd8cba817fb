// What was found out about the data, and what to do: one entry a finding, the gravest first.
import { isCalibration } from "../data.js";
import { h, section } from "../dom.js";
import { isNumber } from "../numbers.js";

const GRAVE = { error: ["✕", "Error", 0], warning: ["!", "Warning", 1], note: ["i", "Note", 2],
                info: ["i", "Note", 2] };
const rankOf = (finding) => (GRAVE[finding.severity] ?? GRAVE.warning)[2];

// Options such as --board-warp in one piece.
const withOptions = (text) => String(text ?? "").split(/(--[a-z][a-z-]*)/).map((part, i) =>
  (i % 2 ? h("code", { class: "option" }, part) : part));

export function findingList(findings) {
  const sorted = [...findings].sort((a, b) => rankOf(a) - rankOf(b));
  return h("ul", { class: "findings", "data-marks": findings.length }, sorted.map((finding) => {
    const [mark, word] = GRAVE[finding.severity] ?? GRAVE.warning;
    return h("li", { class: word.toLowerCase() },
      h("span", { class: "mark", "aria-hidden": "true" }, mark),
      h("div", null, h("p", null, h("b", null, `${word}: `), withOptions(finding.sentence)),
        finding.code ? h("p", { class: "code" }, finding.code) : null));
  }));
}

// Findings of single views (poses), with the name of the picture.
const ofViews = (data) => (data.views ?? []).flatMap((view) => (view.findings ?? []).map(
  (finding) => ({ ...finding, sentence: `${view.image}: ${finding.sentence}` })));

export function findings(data) {
  const found = [...(data.findings ?? []), ...ofViews(data)];
  const notes = data.notes ?? [];
  if (!found.length && !notes.length && !(isCalibration(data) && data.model)) return null;
  return section("findings", "Findings", { wide: true },
    found.length ? findingList(found)
      : isCalibration(data) ? h("p", null, isNumber(data.num_corners)
        ? "No check of the data raised a warning." : "The file of the camera holds no warning.")
        : null,
    data.halves?.sentence && !data.halves.disagree
      ? h("p", { class: "note" }, data.halves.sentence) : null,
    notes.length ? [h("h3", null, "About this page"),
      h("ul", { class: "notes" }, notes.map((note) => h("li", null, withOptions(note))))] : null);
}
