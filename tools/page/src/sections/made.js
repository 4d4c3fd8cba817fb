// How this page was made: the command, the date and the versions.
import { h, section } from "../dom.js";
import { withOptions } from "./findings.js";

// A table of names and texts.
export const rowTable = (rows) => h("table", { class: "made" }, h("tbody", null,
  rows.map(([name, value]) => h("tr", null, h("th", { scope: "row" }, name), h("td", null, value)))));

export function madeBy(data) {
  const made = data.made_by;
  if (!made) return null;
  const libraries = Object.entries(made.libraries ?? {})
    .map(([name, version]) => `${name} ${version}`).join(", ");
  const rows = [
    ["command", h("code", null, withOptions(made.command))],
    ["tagcal", made.version], ["date", made.date], ["with", libraries],
    ["time", typeof data.seconds === "number" ? `${data.seconds.toFixed(2)} s` : null],
  ].filter(([, value]) => value);
  return section("made-by", "Made by", { wide: true },
    rowTable(rows),
    h("p", { class: "note" }, "This file needs no network. It holds all that it shows."));
}
