// What was found out about the data, and what to do: one entry a finding, the gravest first.
import { isCalibration } from "../data.js";
import { h, section } from "../dom.js";
import { isNumber } from "../numbers.js";

const GRAVE = { error: ["✕", "Error", 0], warning: ["!", "Warning", 1], note: ["i", "Note", 2],
                info: ["i", "Note", 2] };
const MANY = 3;  // findings of one kind that are listed each by itself
const rankOf = (finding) => (GRAVE[finding.severity] ?? GRAVE.warning)[2];

// Options such as --board-warp in one piece.
export const withOptions = (text) => String(text ?? "").split(/(--[a-z][a-z-]*)/).map((part, i) =>
  (i % 2 ? h("code", { class: "option" }, part) : part));

function entry(finding, others) {
  const [mark, word] = GRAVE[finding.severity] ?? GRAVE.warning;
  return h("li", { class: word.toLowerCase() },
    h("span", { class: "mark", "aria-hidden": "true" }, mark),
    h("div", null, h("p", null, h("b", null, `${word}: `), withOptions(finding.sentence)),
      finding.code ? h("p", { class: "code" }, finding.code) : null,
      others.length ? h("details", null, h("summary", null, `${others.length} more of this kind`),
        others.map((other) => h("p", null, withOptions(other.sentence)))) : null));
}

// Findings of one code and severity, in the order of the first of each.
function groupsOf(findings) {
  const groups = new Map();
  for (const finding of findings) {
    const kind = `${finding.severity} ${finding.code}`;
    if (!finding.code) groups.set(finding, [finding]);
    else if (groups.has(kind)) groups.get(kind).push(finding);
    else groups.set(kind, [finding]);
  }
  return [...groups.values()];
}

// The gravest first. Many of one kind (a note for each picture) fold up behind the first of them.
export function findingList(findings) {
  const sorted = [...findings].sort((a, b) => rankOf(a) - rankOf(b));
  return h("ul", { class: "findings", "data-marks": findings.length }, groupsOf(sorted).map((group) =>
    (group.length > MANY ? entry(group[0], group.slice(1)) : group.map((one) => entry(one, [])))));
}

// Findings of single views (poses), with the name of the picture.
const ofViews = (data) => (data.views ?? []).flatMap((view) => (view.findings ?? []).map(
  (finding) => ({ ...finding, sentence: `${view.image}: ${finding.sentence}` })));

export function findings(data) {
  const found = [...(data.findings ?? []), ...ofViews(data)];
  const notes = data.notes ?? [];
  const isChecked = ["rig", "handeye"].includes(data.kind) || (isCalibration(data) && data.model);
  if (!found.length && !notes.length && !isChecked) return null;
  return section("findings", "Findings", { wide: true },
    found.length ? findingList(found)
      : isChecked ? h("p", null, isNumber(data.seconds)
        ? "No check of the data raised a warning." : "The file holds no warning.")
        : null,
    data.halves?.sentence && !data.halves.disagree
      ? h("p", { class: "note" }, data.halves.sentence) : null,
    notes.length ? [h("h3", null, "About this page"),
      h("ul", { class: "notes" }, notes.map((note) => h("li", null, withOptions(note))))] : null);
}
