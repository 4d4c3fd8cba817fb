// Bars of one number a picture, in the order in which the pictures were given.
import { chart } from "../dom.js";
import { themeColour } from "../colour.js";
import { isNumber, median, px } from "../numbers.js";
import { bars, lineChart } from "../plot/lines.js";

const MANY = 1.5;  // times the median from which on a picture is worth a look

// The bars with a dashed line at `level`.
export function pictureBars({ name, title, x, y, values, level, label, read }) {
  const plot = lineChart(() => ({
    x: { label: x, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] },
    y: { label: y },
    scales: { x: { time: false, range: [0.3, values.length + 0.7] },
              y: { range: (_, low, high) => [0, 1.08 * high] } },
    series: [
      { paths: bars(0.8), fill: themeColour("--sky"), points: { show: false } },
      { stroke: themeColour("--vermilion"), width: 2, dash: [6, 4], points: { show: false } },
    ],
    data: [values.map((_, i) => i + 1), values, values.map(() => level)],
  }));
  return chart({ name, title, marks: values.filter(isNumber).length, label, read }, plot);
}

export function rmsChart(data) {
  const values = data.views.map((view) => (isNumber(view.rms_px) ? view.rms_px : null));
  const known = values.filter(isNumber);
  if (known.length < 3) return null;
  const middle = median(known);
  const large = data.views.filter((view) => view.rms_px > MANY * middle);
  const exceed = large.length === 1 ? "exceeds" : "exceed";
  const words = large.length
    ? `${large.length} of ${values.length} ${exceed} ${MANY} times the median ` +
      `(${px(middle)}): ` +
      `${large.slice(0, 3).map((view) => view.image).join(", ")}${large.length > 3 ? ", .." : ""}.`
    : `None exceeds ${MANY} times the median (${px(middle)}, dashed).`;
  return pictureBars({
    name: "rms", x: "picture", y: "RMS residual [px]", values, level: middle,
    label: `RMS residual of ${known.length} pictures`,
    read: `one bar per picture, in the order given. ${words}`,
  });
}
