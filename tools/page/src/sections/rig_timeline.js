// The instants of a rig: which cameras have a picture, which instants were used or rejected.
import { chart, h, key, s, section } from "../dom.js";
import { count, digits, isNumber, range } from "../numbers.js";
import { linkTo } from "./rig.js";
import { plusMinus } from "./verdict.js";

const KINDS = { used: "used", rejected: "rejected", unused: "unused" };
const NAMED = 12;  // rejected instants that are named

// Upright marks as one path in a box of 1 x 1.
const marks = (places, kind) => (places.length ? s("path", {
  d: places.map((x) => `M${x.toFixed(5)} ${kind === "rejected" ? 0 : 0.15}` +
    `V${kind === "rejected" ? 1 : 0.85}`).join(""),
  class: `instant ${kind}` }) : null);

// Where the instants are in the box: by their times if all have one, else by number.
function placesOf(instants) {
  const times = instants.map((instant) => instant.time_s);
  const hasTimes = times.every(isNumber) && new Set(times).size > 1;
  const values = hasTimes ? times : instants.map((_, i) => i);
  const { low, high } = range(values);
  return { hasTimes, low, high,
    places: values.map((x) => 0.005 + 0.99 * (high > low ? (x - low) / (high - low) : 0.5)) };
}

function row(data, camera, index, places) {
  const clock = data.clocks?.find((offset) => offset.camera === index);
  const of = (kind) => places.filter((_, i) => data.instants[i].state === kind &&
    data.instants[i].cameras.includes(index));
  return h("div", { class: "timeline-row" },
    h("span", { class: "timeline-name" }, camera.parameters ? linkTo(data, index) : camera.name,
      clock ? h("span", { class: "note" }, ` ${plusMinus(clock.text)} late` +
        (clock.corrected ? ", corrected" : "")) : null),
    s("svg", { viewBox: "0 0 1 1", preserveAspectRatio: "none", class: "timeline" },
      Object.keys(KINDS).map((kind) => marks(of(kind), KINDS[kind]))));
}

function rejectedText(data) {
  const names = data.instants.filter(({ state }) => state === "rejected")
    .map(({ name, num_used: used, cameras }) => `${name} (${used} of ${cameras.length} used)`);
  if (!names.length) return "No instant does here.";
  return `Here these do: ${names.slice(0, NAMED).join("; ")}${names.length > NAMED ? "; .." : ""}.`;
}

export function rigTimeline(data) {
  const instants = data.instants ?? [];
  if (!instants.length) return null;
  const { hasTimes, low, high, places } = placesOf(instants);
  const number = (kind) => instants.filter(({ state }) => state === kind).length;
  const tick = (x) => (hasTimes ? `${digits(x - low, 3)} s` : String(x + 1));
  return section("instants", "Instants", { wide: true }, chart({
    name: "instants", marks: instants.length,
    label: `${count(instants.length, "instant")} of ${count(data.cameras.length, "camera")}`,
    read: "one row a camera, one mark for each of its pictures with the board" +
      (hasTimes ? ", at its time" : ", in order") + ". Where marks are " +
      "strong and long, pictures of one instant contradict one another, and not all are used: the " +
      `board moved, or one belongs to another instant. ${rejectedText(data)} ` +
      (number("unused") ? "Unused instants connect no two cameras. " : "") + (data.clocks?.length
        ? "An offset beside a name is how much later that camera took its pictures." : ""),
  }, data.cameras.map((camera, index) => row(data, camera, index, places)),
  h("div", { class: "timeline-row" }, h("span", { class: "timeline-name note" },
    hasTimes ? "time" : "number"), h("div", { class: "timeline-ticks note" },
    h("span", null, tick(low)), h("span", null, tick(high)))),
  h("p", { class: "legend" }, key("instant-used", `${number("used")} used`),
    number("rejected") ? key("instant-rejected", `${number("rejected")} contradict`) : null,
    number("unused") ? key("instant-unused", `${number("unused")} unused`) : null)));
}
