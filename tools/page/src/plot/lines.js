// Charts with axes by uPlot: it draws on a canvas, so it is drawn again for another width or
// another colour scheme.
import uPlot from "uplot";
import { h } from "../dom.js";
import { onThemeChange, themeColour } from "../colour.js";

const HEIGHT = 260;

function axis(label, values) {
  const grid = { stroke: themeColour("--line"), width: 1 };
  return { label, labelSize: 22, labelFont: "12px system-ui, sans-serif", size: 46,
           font: "12px system-ui, sans-serif", stroke: themeColour("--soft"), grid, ticks: grid,
           values };
}

// "build" gives { x, y (labels), series, data, scales } and is called for each drawing, because
// colours change. Returns the element.
export function lineChart(build) {
  const frame = h("div", { class: "plot" });
  let plot = null;
  const draw = () => {
    const width = Math.floor(frame.clientWidth);
    if (!width) return;
    plot?.destroy();
    const { x, y, series, data, scales, bands } = build();
    plot = new uPlot({
      width, height: HEIGHT, scales: { x: { time: false }, ...scales }, bands,
      axes: [axis(x.label, x.values), { ...axis(y.label, y.values), size: 56 }],
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
