// Charts with axes by uPlot: it draws on a canvas, so it is drawn again for another width or
// another colour scheme.
import uPlot from "uplot";
import { h } from "../dom.js";
import { onThemeChange, themeColour } from "../colour.js";
import { digits } from "../numbers.js";

const HEIGHT = 260;
const PRINTED = { half: 400, whole: 680, height: 190 };  // on paper; "half" beside another chart

// Numbers at an axis, with the decimals that their step needs.
function tickTexts(_, ticks) {
  const step = Math.abs(ticks[1] - ticks[0]) || Math.abs(ticks[0]) || 1;
  let decimals = 0;
  while (decimals < 7 && Math.abs(Number(step.toFixed(decimals)) - step) > 0.01 * step) ++decimals;
  return ticks.map((x) => (decimals > 5 ? digits(x, 1) : x.toFixed(decimals).replace("-", "−")));
}

function axis({ label, values = tickTexts, incrs }) {
  const grid = { stroke: themeColour("--line"), width: 1 };
  return { label, labelSize: 22, labelFont: "12px system-ui, sans-serif", size: 46,
           font: "12px system-ui, sans-serif", stroke: themeColour("--soft"), grid, ticks: grid,
           values, incrs };
}

// Room for the longest number at the axis, its tick and a gap.
const widthOfTexts = (_, texts) =>
  22 + 7 * Math.max(4, ...(texts ?? []).map((text) => text?.length ?? 0));

const isPrinting = () => document.documentElement.classList.contains("printing");

function widthOf(frame) {
  if (!isPrinting()) return frame.clientWidth;
  return frame.closest(".two") ? PRINTED.half : PRINTED.whole;
}

// "build" gives { x, y (labels), series, data, scales } and is called for each drawing, because
// colours change. Returns the element.
export function lineChart(build) {
  const frame = h("div", { class: "plot" });
  let plot = null;
  const draw = () => {
    const width = widthOf(frame);
    if (!width) return;
    plot?.destroy();
    const { x, y, series, data, scales, bands } = build();
    plot = new uPlot({
      width, height: isPrinting() ? PRINTED.height : HEIGHT, scales: { x: { time: false }, ...scales }, bands,
      axes: [axis(x), { ...axis(y), size: widthOfTexts }],
      series: [{ label: x.label, value: x.value }, ...series],
      legend: { show: false }, cursor: { show: false },
    }, data, frame);
  };
  let width = 0;
  new ResizeObserver(() => {
    if (frame.clientWidth === width) return;
    width = frame.clientWidth;
    draw();
  }).observe(frame);
  onThemeChange(draw);
  return frame;
}

export const bars = (share = 0.95) => uPlot.paths.bars({ size: [share, Infinity], gap: 0 });
export const spline = () => uPlot.paths.spline();
