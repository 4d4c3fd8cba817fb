// Views of the data that several sections need.
import { isNumber } from "./numbers.js";

export const isCalibration = (data) => data.kind === "calibration" || !data.kind;

// One corner by its row in the columns.
function cornerAt(columns, row) {
  const du = columns.du?.[row];
  const dv = columns.dv?.[row];
  const has = isNumber(du) && isNumber(dv);
  return {
    row, view: columns.view[row], u: columns.u[row], v: columns.v[row],
    du: has ? du : null, dv: has ? dv : null, has,
    size: has ? Math.hypot(du, dv) : NaN,
    rejected: Boolean(columns.rejected?.[row]),
    tag: columns.tag?.[row], corner: columns.corner?.[row],
    sd: isNumber(columns.sd_px?.[row]) ? columns.sd_px[row] : null,
  };
}

let known = null;

// All corners as rows.
export function corners(data) {
  if (known?.data !== data) {
    const rows = data.corners?.u?.map((_, row) => cornerAt(data.corners, row)) ?? [];
    const byView = new Map();
    for (const corner of rows) {
      if (!byView.has(corner.view)) byView.set(corner.view, []);
      byView.get(corner.view).push(corner);
    }
    known = { data, rows, byView };
  }
  return known.rows;
}

// Corners that the calibration used and whose residual is known.
export const usedCorners = (data) =>
  corners(data).filter((corner) => !corner.rejected && corner.has);

export function cornersOfView(data, view) {
  corners(data);
  return known.byView.get(view) ?? [];
}

export const imageSize = (data) => data.image_size ?? null;

// The principal point where it is known, else the middle of the image.
export function centreOf(data) {
  const value = (name) => data.parameters?.find((p) => p.name === name)?.value;
  const [width, height] = data.image_size;
  return [value("cx") ?? (width - 1) / 2, value("cy") ?? (height - 1) / 2];
}
