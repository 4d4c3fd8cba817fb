// Lines of equal value in a grid: marching squares with linear interpolation.
import { isNumber } from "../numbers.js";

// The corners of a cell around, and the four edges between them.
const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]];

function crossingsOfCell(values, level) {
  const crossings = [];
  for (let k = 0; k < 4; ++k) {
    const [a, b] = [values[k], values[(k + 1) % 4]];
    if (a < level === b < level) continue;
    const share = (level - a) / (b - a);
    const [from, to] = [CORNERS[k], CORNERS[(k + 1) % 4]];
    crossings.push([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]);
  }
  return crossings;
}

// Segments [[column, row], [column, row]] along which the grid has this value. Cells beside a
// node without a value have none. A saddle is cut into two segments by the order of its edges.
export function contourSegments(grid, level) {
  const segments = [];
  for (let row = 0; row + 1 < grid.length; ++row) {
    for (let column = 0; column + 1 < grid[row].length; ++column) {
      const values = CORNERS.map(([i, j]) => grid[row + j][column + i]);
      if (!values.every(isNumber)) continue;
      const ends = crossingsOfCell(values, level).map(([x, y]) => [column + x, row + y]);
      for (let k = 0; k + 1 < ends.length; k += 2) segments.push([ends[k], ends[k + 1]]);
    }
  }
  return segments;
}
