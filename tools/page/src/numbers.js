// Numbers as a person reads them: digits by their uncertainty, with a unit.

const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";
export const NONE = "–";

export const isNumber = (x) => typeof x === "number" && Number.isFinite(x);

function power(exponent) {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPT[digit]).join("");
  return `10${exponent < 0 ? "⁻" : ""}${digits}`;
}

// A typographic minus, which is as wide as a plus.
const minus = (text) => text.replace("-", "−");

// x with n significant digits; very small and very large ones as 1.2 × 10⁻⁵.
export function digits(x, n = 2) {
  if (!isNumber(x)) return NONE;
  if (x === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(Number(x.toPrecision(n)))));
  if (exponent < -4 || exponent >= 5) {
    return minus(`${(x / 10 ** exponent).toFixed(Math.max(0, n - 1))} × ${power(exponent)}`);
  }
  return minus(x.toFixed(Math.max(0, n - 1 - exponent)));
}

// A length in pixels, with a space that does not break.
export const px = (x, n = 2) => (isNumber(x) ? `${digits(x, n)} px` : NONE);

// x with as many decimals as two digits of its standard deviation need.
export function bySigma(x, sigma) {
  if (!isNumber(x)) return NONE;
  if (!isNumber(sigma) || sigma <= 0) return minus(String(Number(x.toPrecision(6))));
  const exponent = Math.floor(Math.log10(Number(sigma.toPrecision(2))));
  return minus(x.toFixed(Math.min(12, Math.max(0, 1 - exponent))));
}

export function percent(share) {
  if (!isNumber(share)) return NONE;
  return `${digits(100 * share, share > 0.995 || share < 0.1 ? 2 : 2).replace(/^100.*/, "100")} %`;
}

export const distance = (metres) => (isNumber(metres) ? `${digits(metres, 3)} m` : "infinity");

export const distanceTitle = (metres) =>
  (isNumber(metres) ? `At ${distance(metres)}` : "Far away (infinity)");

// "1 picture", "2 pictures".
export function count(n, one, many = `${one}s`) {
  const text = n >= 10000 ? n.toLocaleString("en").replace(/,/g, " ") : String(n);
  return `${text} ${n === 1 ? one : many}`;
}

// The largest of 1, 2, 5 times a power of ten that is at most x.
export function niceBelow(x) {
  const base = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].find((step) => step * base <= x * (1 + 1e-9)) * base;
}

export const median = (values) => quantile(values, 0.5);

export function quantile(values, share) {
  const sorted = values.filter(isNumber).sort((a, b) => a - b);
  if (!sorted.length) return NaN;
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

export function range(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const x of values) {
    if (!isNumber(x)) continue;
    low = Math.min(low, x);
    high = Math.max(high, x);
  }
  return { low, high };
}
