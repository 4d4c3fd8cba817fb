// Colour maps that stay readable for colour-blind people and in grey (matplotlib's viridis and
// cividis, each of ten stops), and the page's own colours, which follow light, dark and print.

const stops = (hex) => hex.split(" ").map((colour) =>
  [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)));

export const VIRIDIS = stops(
  "#440154 #482878 #3e4989 #31688e #26828e #1f9e89 #35b779 #6ece58 #b5de2b #fde725");
export const CIVIDIS = stops(
  "#00224e #123570 #3b496c #575d6d #707173 #8a8678 #a59c74 #c3b369 #e1cc55 #fee838");

// The colour at share 0..1 of a map, as [r, g, b].
export function colourAt(map, share) {
  const x = Math.min(1, Math.max(0, share)) * (map.length - 1);
  const low = Math.min(map.length - 2, Math.floor(x));
  return map[low].map((from, i) => Math.round(from + (x - low) * (map[low + 1][i] - from)));
}

export const css = (rgb) => `rgb(${rgb.join(",")})`;

export const gradient = (map) =>
  `linear-gradient(to right, ${map.map((stop) => css(stop)).join(", ")})`;

// A colour of style.css, for canvases: "--blue".
export const themeColour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Calls draw when the colours change: light, dark, and print, which is always light.
export function onThemeChange(draw) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  addEventListener("beforeprint", () => {
    document.documentElement.classList.add("printing");
    draw();
  });
  addEventListener("afterprint", () => {
    document.documentElement.classList.remove("printing");
    draw();
  });
}
