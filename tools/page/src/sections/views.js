// The pictures as thumbnails with their corners drawn over them, the worst first.
import { chart, h, key, section } from "../dom.js";
import { cornersOfView } from "../data.js";
import { count } from "../numbers.js";
import { crosses, dots, imageFrame } from "../plot/frame.js";
import { rmsChart } from "./rms.js";
import { captionOf, isAnswer, picture } from "./view_parts.js";
import { openView } from "./viewer.js";

const FIRST = 24;  // shown before "show all"

const ORDERS = {
  residual: ["largest residual first", (a, b) => (b.view.rms_px ?? -1) - (a.view.rms_px ?? -1)],
  rejected: ["most rejected corners first",
    (a, b) => (b.view.num_rejected ?? 0) - (a.view.num_rejected ?? 0)],
  name: ["as they were given", (a, b) => a.index - b.index],
};

function card(data, entry, order) {
  const { view, index } = entry;
  const seen = cornersOfView(data, index);
  const size = data.image_size ?? view.thumbnail_size ?? [4, 3];
  const at = (rejected) => seen.filter((corner) => corner.rejected === rejected)
    .map(({ u, v }) => [u, v]);
  const open = () => openView(data, order(), index);
  return h("button", { type: "button", class: `view ${isAnswer(view) ? "" : "off"}`, click: open,
                       "data-view": index, "data-corners": seen.length,
                       "aria-label": `${view.image}, ${captionOf(view)}: enlarge` },
    !view.thumbnail && !seen.length ? null : imageFrame(size, picture(view, size),
      dots(at(false), "halo-dot"), dots(at(false), "used"),
      crosses(at(true), size[0] / 60, "rejected halo"),
      crosses(at(true), size[0] / 60, "rejected")),
    h("span", { class: "name" }, view.image),
    h("span", { class: "note" }, captionOf(view)),
    view.status === "ok" ? null : h("span", { class: "tag warn" }, view.status),
    view.thumbnail ? null : h("span", { class: "note" }, view.sentence ?? "picture not shown"));
}

// The cards with a choice of their order; draws again when the order changes.
function gallery(data, entries) {
  const state = { order: "residual", all: entries.length <= FIRST };
  const cards = h("div", { class: "views" });
  const more = h("p", { class: "more" }, `The first ${FIRST} of ${entries.length} pictures. `,
    h("button", { type: "button", click: () => { state.all = true; draw(); } }, "Show all"));
  const sorted = () => [...entries].sort(ORDERS[state.order][1]);
  const draw = () => {
    const order = () => sorted().map(({ index }) => index);
    cards.replaceChildren(...sorted().slice(0, state.all ? entries.length : FIRST)
      .map((entry) => card(data, entry, order)));
    cards.dataset.shown = cards.childElementCount;
    more.hidden = state.all;
  };
  const choice = h("select", { change: () => { state.order = choice.value; draw(); } },
    Object.entries(ORDERS).map(([name, [words]]) => h("option", { value: name }, words)));
  draw();
  return [h("p", { class: "controls" }, h("label", null, "Order: ", choice)), cards, more];
}

export function views(data) {
  const entries = (data.views ?? []).map((view, index) => ({ view, index }));
  if (!entries.length) return null;
  const rejected = data.corners?.rejected?.some(Boolean);
  const ambiguous = entries.some(({ view }) => view.status === "ambiguous");
  return section("views", "Pictures", { wide: true }, rmsChart(data),
    chart({
      name: "views", marks: entries.length,
      label: `${count(entries.length, "picture")} with their corners`,
      read: !entries.some(({ view }) => view.thumbnail) ? "click a picture for its numbers."
        : "look at the first ones for blur, a hand over the board or a wrong corner. " +
          "Click a picture to enlarge it and to see each residual." +
          (ambiguous ? " An ambiguous picture fits two poses: it shows both, with odds." : ""),
    }, gallery(data, entries), !data.corners?.u?.length ? null : h("p", { class: "legend" },
      key("dot-used", "corner, as detected"),
      rejected ? key("cross-rejected", "rejected corner") : null)));
}
