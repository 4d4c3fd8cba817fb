// A scene of lines and faces to turn around, painted from far to near on a plain 2D canvas.
// A scene here has at most some thousand faces and no textures, so the painter's order is fast
// enough and a 3D library (ogl: 30 kB, WebGL) would gain nothing. WebGL contexts are also missing
// on many remote desktops, and their canvases print empty.
import { h } from "../dom.js";
import { onThemeChange, themeColour } from "../colour.js";
import { quantile } from "../numbers.js";

const START = { yaw: 0.6, pitch: 0.5, zoom: 1 };
const FOCAL = 1.6;  // of the drawing, in half heights
const FILLED = 0.94;  // share of the canvas that the scene fills at first

// Turns a point of the scene into [right, up, depth] for the angles.
function turner({ yaw, pitch }, centre) {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return ([x, y, z]) => {
    const [a, b, c] = [x - centre[0], y - centre[1], z - centre[2]];
    const near = cp * (cy * a + sy * b) + sp * c;
    return [-sy * a + cy * b, cp * c - sp * (cy * a + sy * b), -near];
  };
}

function projector(state, scene, width, height) {
  const turn = turner(state, scene.centre);
  const away = 1.9 * scene.radius / (state.zoom * (state.fit || 1));
  const scale = FOCAL * Math.min(width, height) / 2;
  return (point) => {
    const [right, up, depth] = turn(point);
    const z = depth + away;
    return z > 0.02 * scene.radius
      ? [width / 2 + scale * right / z, height / 2 - scale * up / z, z] : null;
  };
}

// How much closer to come at the present angles for the scene to fill the canvas: by bisection,
// because a scene that is long in the direction of sight has points beside the eye when it is near.
function fitOf(state, width, height) {
  const pointsOf = (items) => items.flatMap((item) => item.faces.flatMap((face) => face.points));
  // A camera far from all others may stay outside, unless it is one of a rig.
  const all = pointsOf(state.scene.items);
  const fixed = pointsOf(state.scene.items.filter((item) => item.view === undefined));
  const shareAt = (fit) => {
    const project = projector({ ...state, zoom: 1, fit }, state.scene, width, height);
    const shares = (points) => points.map(project).map((at) => (at
      ? Math.max(Math.abs(at[0] / width - 0.5), Math.abs(at[1] / height - 0.5)) * 2 : 2));
    return Math.max(quantile(shares(all), state.scene.whole ? 1 : 0.99), ...shares(fixed).slice(0, 1e4));
  };
  let [low, high] = [0.3, 3];
  for (let i = 0; i < 8; ++i) {
    const middle = Math.sqrt(low * high);
    if (shareAt(middle) > FILLED) high = middle;
    else low = middle;
  }
  return low;
}

function trace(context, points, closed) {
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (closed) context.closePath();
}

// Paints one item; its faces share its place in the order.
function paint(context, faces) {
  for (const { at, fill, stroke, width, closed } of faces) {
    trace(context, at, closed);
    if (fill) {
      context.fillStyle = fill;
      context.fill();
    }
    if (stroke) {
      context.strokeStyle = stroke;
      context.lineWidth = width ?? 1;
      context.stroke();
    }
  }
}

// Names of items, above all of them, with a margin in the colour of the ground.
function write(context, placed, colours) {
  context.font = "600 13px system-ui, sans-serif";
  for (const { item: { label }, middle } of placed) {
    if (!label || !middle) continue;
    context.strokeStyle = colours("--page");
    context.lineWidth = 4;
    context.strokeText(label, middle[0] + 8, middle[1] - 8);
    context.fillStyle = colours("--text");
    context.fillText(label, middle[0] + 8, middle[1] - 8);
  }
}

// The items of the scene on the screen, the farthest first.
function arrange(scene, project, colours) {
  return scene.items.map((item) => {
    const middle = project(item.middle);
    const faces = item.faces.map((face) => ({
      ...face, at: face.points.map(project), fill: colours(face.fill), stroke: colours(face.stroke),
    })).filter(({ at }) => at.every(Boolean));
    return { item, depth: middle?.[2] ?? -1, middle, faces };
  }).sort((a, b) => b.depth - a.depth);
}

// A canvas that shows a scene: { node, look(yaw, pitch), show(scene) }. "pick" is called with the
// item.view of a camera that is clicked; "nameOf" gives the words shown while the mouse is on it.
export function orbit(scene, { label, pick, nameOf }) {
  const canvas = h("canvas", { class: "orbit", tabindex: "0", role: "img", "aria-label": label });
  const state = { ...START, fit: 0, scene, placed: [] };  // fit 0: not yet known
  const draw = () => {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    const ratio = Math.max(2, devicePixelRatio);  // 2 at least, for print
    state.fit ||= fitOf(state, width, height);
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.lineJoin = "round";
    const colours = (name) => (name ? themeColour(name) : null);
    const cache = new Map();
    const cached = (name) => cache.get(name) ?? cache.set(name, colours(name)).get(name);
    state.placed = arrange(state.scene, projector(state, state.scene, width, height), cached);
    for (const { faces } of state.placed) paint(context, faces);
    write(context, state.placed, cached);
    Object.assign(canvas.dataset, { yaw: state.yaw.toFixed(3), pitch: state.pitch.toFixed(3),
                                    zoom: state.zoom.toFixed(3), items: state.placed.length });
  };
  const turn = (yaw, pitch) => {
    state.yaw += yaw;
    state.pitch = Math.max(-1.57, Math.min(1.57, state.pitch + pitch));
    draw();
  };
  const zoom = (factor) => {
    state.zoom = Math.max(0.3, Math.min(12, state.zoom * factor));
    draw();
  };
  const at = (x, y) => viewAt(state.placed, x, y);
  listen(canvas, { turn, zoom,
    click: (x, y) => { if (at(x, y) !== null) pick(at(x, y)); },
    hover: (x, y) => {
      const view = at(x, y);
      canvas.title = view === null ? "" : nameOf(view);
      canvas.classList.toggle("on-item", view !== null);
    } });
  new ResizeObserver(() => { state.fit = 0; draw(); }).observe(canvas);
  onThemeChange(draw);
  return { node: canvas,
    look: (yaw, pitch) => { Object.assign(state, { yaw, pitch, zoom: 1, fit: 0 }); draw(); },
    show: (other) => { Object.assign(state, START, { scene: other, fit: 0 }); draw(); } };
}

// The view whose item is nearest to a place on the screen, or null if none is near.
function viewAt(placed, x, y) {
  let best = null;
  for (const { item, middle } of placed) {
    if (item.view === undefined || !middle) continue;
    const distance = Math.hypot(middle[0] - x, middle[1] - y);
    if (distance < (best?.distance ?? 18)) best = { distance, view: item.view };
  }
  return best ? best.view : null;
}

const KEYS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1],
               ArrowDown: [0, -0.1] };

function listen(canvas, { turn, zoom, click, hover }) {
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey) return;
    if (KEYS[event.key]) turn(...KEYS[event.key]);
    else if (event.key === "+") zoom(1.2);
    else if (event.key === "-") zoom(1 / 1.2);
    else return;
    event.preventDefault();
  });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;  // the page scrolls until the scene is clicked
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 500));
  }, { passive: false });
  listenToPointers(canvas, { turn, zoom, click, hover });
}

// One pointer turns, two come closer; one that does not move is a click.
function listenToPointers(canvas, { turn, zoom, click, hover }) {
  const pointers = new Map();
  let moved = 0;
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  };
  canvas.addEventListener("pointerdown", (event) => {
    pointers.set(event.pointerId, event);
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) {
      hover(event.offsetX, event.offsetY);
      return;
    }
    const before = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, event);
    const [dx, dy] = [event.clientX - last.clientX, event.clientY - last.clientY];
    moved += Math.abs(dx) + Math.abs(dy);
    if (pointers.size === 2) zoom(spread() / Math.max(1, before));
    else turn(-dx * 0.008, dy * 0.008);
  });
  canvas.addEventListener("pointerup", (event) => {
    pointers.delete(event.pointerId);
    if (moved < 4) click(event.offsetX, event.offsetY);
  });
  canvas.addEventListener("pointercancel", (event) => pointers.delete(event.pointerId));
}
