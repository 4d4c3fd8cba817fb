// Elements of the page. Texts become text nodes, never markup: a picture named "<script>" shows
// as text.

const SVG_NAMESPACE = "http://www.w3.org/2000/svg";

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") node.addEventListener(name, value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(2).filter((child) => child !== null && child !== undefined));
  return node;
}

// An HTML element; functions among the attributes are listeners, null children are left out.
export function h(tag, attributes, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

// An SVG element.
export function s(tag, attributes, ...children) {
  return fill(document.createElementNS(SVG_NAMESPACE, tag), attributes, children);
}

// A section of the page with a heading; "wide" takes the whole width.
export function section(id, title, attributes, ...children) {
  const { wide, ...rest } = attributes ?? {};
  return h("section", { id, class: wide ? "card wide" : "card", ...rest },
    h("h2", null, title), children);
}

// One chart: its body, the line on how to read it, and what a test or a screen reader needs.
export function chart({ name, marks, label, read, title }, ...body) {
  return h("figure", { class: "chart", "data-chart": name, "data-marks": marks },
    title ? h("h3", null, title) : null,
    h("div", { class: "chart-body", role: "group", "aria-label": label }, body),
    h("figcaption", null, h("b", null, "How to read it: "), read));
}

// A table with heads; cells may be nodes. Columns named in "numeric" are aligned to the right.
export function table(heads, rows, { numeric = [], label, kind } = {}) {
  const style = (column) => (numeric.includes(column) ? "number" : null);
  return h("div", { class: "table-frame" }, h("table", { "aria-label": label, class: kind },
    h("thead", null, h("tr", null,
      heads.map((head, column) => h("th", { scope: "col", class: style(column) }, head)))),
    h("tbody", null, rows.map((row) => h("tr", { class: row.class },
      (row.cells ?? row).map((cell, column) => h("td", { class: style(column) }, cell)))))));
}

// A coloured mark with a word of what it stands for, for legends.
export function key(kind, words) {
  return h("span", { class: "key" },
    h("i", { class: `swatch ${kind}`, "aria-hidden": "true" }), words);
}
