// What was found out about the data, and what to do: one entry a finding, the gravest first.
import { h, section } from "../dom.js";

const GRAVE = { error: ["✕", "Error", 0], warning: ["!", "Warning", 1], note: ["i", "Note", 2],
                info: ["i", "Note", 2] };
const rankOf = (finding) => (GRAVE[finding.severity] ?? GRAVE.warning)[2];

export function findingList(findings) {
  const sorted = [...findings].sort((a, b) => rankOf(a) - rankOf(b));
  return h("ul", { class: "findings", "data-marks": findings.length }, sorted.map((finding) => {
    const [mark, word] = GRAVE[finding.severity] ?? GRAVE.warning;
    return h("li", { class: word.toLowerCase() },
      h("span", { class: "mark", "aria-hidden": "true" }, mark),
      h("div", null, h("p", null, h("b", null, `${word}: `), finding.sentence),
        finding.code ? h("p", { class: "code" }, finding.code) : null));
  }));
}

export function findings(data) {
  const found = data.findings ?? [];
  const notes = data.notes ?? [];
  if (!found.length && !notes.length && !data.model) return null;
  return section("findings", "Findings", null,
    found.length ? findingList(found)
      : h("p", null, "No check of the data raised a warning."),
    data.halves?.sentence && !data.halves.disagree
      ? h("p", { class: "note" }, data.halves.sentence) : null,
    notes.length ? [h("h3", null, "Not shown on this page"),
      h("ul", { class: "notes" }, notes.map((note) => h("li", null, note)))] : null);
}
