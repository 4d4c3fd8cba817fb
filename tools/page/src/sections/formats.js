// The numbers in the formats of other programs, to copy.
import { h, section } from "../dom.js";

// The clipboard needs a secure page in some browsers; a file opened from disk may not count.
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = h("textarea", { class: "off-screen", readonly: true });
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

function entry({ name, text }, open) {
  const button = h("button", { type: "button", class: "copy", "aria-live": "polite" }, "Copy");
  const shown = h("pre", { tabindex: "0", "aria-label": name }, text);
  button.addEventListener("click", async () => {
    const done = await copy(text);
    if (!done) getSelection().selectAllChildren(shown);
    button.textContent = done ? "Copied" : "Selected: press Ctrl+C";
    setTimeout(() => { button.textContent = "Copy"; }, 2500);
  });
  return h("details", { open }, h("summary", null, name),
    h("div", { class: "format" }, button, shown));
}

// Paper cannot be clicked: everything is open on it, and as it was afterwards.
function openForPrint(entries) {
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = entries.filter((node) => !node.open);
    for (const node of closed) node.open = true;
  });
  addEventListener("afterprint", () => { for (const node of closed) node.open = false; });
  return entries;
}

const NOTES = {
  camera: "The same camera as each program writes it. Conventions (where pixel 0 lies, order of " +
    "coefficients) are converted.",
  handeye: "The camera's place for ROS, quaternions as x y z w; and the whole answer with its " +
    "covariance.",
};

export function formats(data) {
  const list = data.formats ?? [];
  if (!list.length) return null;
  return section("formats", "The numbers, to copy", { wide: true, "data-marks": list.length },
    h("p", { class: "note" }, NOTES[data.kind] ?? NOTES.camera),
    h("div", { class: "formats" },
      openForPrint(list.map((format, i) => entry(format, i === 0)))));
}
