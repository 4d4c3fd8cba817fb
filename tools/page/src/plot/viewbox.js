// Zoom and move in an SVG: wheel, drag, and the keys + - 0.
const MAX_ZOOM = 40;

export function zoomable(node, [width, height]) {
  let zoom = 1;
  let corner = [-0.5, -0.5];
  const show = () => {
    const limit = (x, size) => Math.min(size - size / zoom - 0.5, Math.max(-0.5, x));
    corner = [limit(corner[0], width), limit(corner[1], height)];
    node.setAttribute("viewBox", [...corner, width / zoom, height / zoom].join(" "));
    node.style.setProperty("--px", width / zoom / (node.clientWidth || 600));
    node.dataset.zoom = zoom.toFixed(2);
  };
  const at = (event) => {
    const box = node.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const zoomBy = (factor, [x, y] = [0.5, 0.5]) => {
    const next = Math.min(MAX_ZOOM, Math.max(1, zoom * factor));
    corner = [corner[0] + x * width * (1 / zoom - 1 / next),
              corner[1] + y * height * (1 / zoom - 1 / next)];
    zoom = next;
    show();
  };
  const moveBy = (x, y) => {
    corner = [corner[0] + x * width / zoom, corner[1] + y * height / zoom];
    show();
  };
  listen(node, { at, zoomBy, moveBy, isZoomed: () => zoom > 1 });
  const reset = () => {
    zoom = 1;
    show();
  };
  return { zoomBy, reset };
}

function listen(node, { at, zoomBy, moveBy, isZoomed }) {
  node.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(Math.exp(-event.deltaY / 400), at(event));
  }, { passive: false });
  node.addEventListener("dblclick", (event) => zoomBy(3, at(event)));
  let from = null;
  node.addEventListener("pointerdown", (event) => {
    if (!isZoomed()) return;
    from = at(event);
    node.setPointerCapture(event.pointerId);
  });
  node.addEventListener("pointermove", (event) => {
    if (!from) return;
    const to = at(event);
    moveBy(from[0] - to[0], from[1] - to[1]);
    from = to;
  });
  for (const end of ["pointerup", "pointercancel"]) {
    node.addEventListener(end, () => { from = null; });
  }
}
