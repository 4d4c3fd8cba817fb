// Zoom and move in an SVG: wheel, drag, one and two fingers.
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
  listenToPointers(node, { at, zoomBy, moveBy, isZoomed });
}

// One pointer moves a picture that is zoomed, two zoom it about their middle.
function listenToPointers(node, { at, zoomBy, moveBy, isZoomed }) {
  const pointers = new Map();
  const pair = () => {
    const [a, b] = [...pointers.values()];
    const box = node.getBoundingClientRect();
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2],
             spread: Math.hypot((a[0] - b[0]) * box.width, (a[1] - b[1]) * box.height) };
  };
  node.addEventListener("pointerdown", (event) => {
    pointers.set(event.pointerId, at(event));
    node.setPointerCapture(event.pointerId);
  });
  node.addEventListener("pointermove", (event) => {
    const from = pointers.get(event.pointerId);
    if (!from) return;
    const before = pointers.size === 2 ? pair() : null;
    pointers.set(event.pointerId, at(event));
    if (before) {
      const { middle, spread } = pair();
      zoomBy(spread / Math.max(1, before.spread), middle);
      moveBy(before.middle[0] - middle[0], before.middle[1] - middle[1]);
    } else if (isZoomed()) {
      const to = pointers.get(event.pointerId);
      moveBy(from[0] - to[0], from[1] - to[1]);
    }
  });
  for (const end of ["pointerup", "pointercancel"]) {
    node.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
}
