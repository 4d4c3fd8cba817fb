// The lens models that were tried, from the smallest on.
import { chart, h, section } from "../dom.js";
import { NONE, digits, isNumber, percent, px } from "../numbers.js";

// A bar from 0 to share of the column, with its value as text.
function bar(share, text, kind) {
  const width = `${(100 * Math.max(0.01, Math.min(1, share))).toFixed(1)}%`;
  return h("div", { class: "bar-cell" },
    isNumber(share) ? h("div", { class: "bar-track" },
      h("div", { class: `bar ${kind}`, style: `width: ${width}` })) : null,
    h("span", { class: "bar-text" }, text));
}

// Shares on a logarithmic scale over the values above zero.
function logShare(values) {
  const positive = values.filter((x) => isNumber(x) && x > 0);
  const [low, high] = [Math.min(...positive), Math.max(...positive)];
  return (x) => {
    if (!isNumber(x) || x <= 0) return NaN;
    if (low >= high) return 1;
    return 0.06 + 0.94 * Math.log(x / low) / Math.log(high / low);
  };
}

function rowOf(step, { best, evidence, change, model, compared }) {
  const worse = isNumber(step.bic) ? step.bic - best : NaN;
  const words = worse === 0 ? "best" : isNumber(worse) ? `+${digits(worse, 2)}` : NONE;
  return h("tr", { class: step.taken ? "taken" : "skipped", "data-model": step.model },
    h("th", { scope: "row" }, step.taken ? h("span", { class: "tick" }, "✓ ") : null, step.model,
      step.model === model ? h("span", { class: "tag" }, "answer") : null),
    h("td", { class: "number", "data-head": "parameters: " }, String(step.num_parameters ?? NONE)),
    h("td", { class: "bars", "data-head": "evidence against" },
      bar(evidence(worse), words, "evidence")),
    compared ? h("td", { class: "bars", "data-head": "difference" },
      bar(change(step.difference_px), px(step.difference_px), "change")) : null,
    h("td", { class: "why" }, step.sentence ?? ""));
}

// What was chosen, and why, in a sentence.
function choiceOf(data, steps, best) {
  const answer = steps.find((step) => step.model === data.model);
  if (!answer) return null;
  const rival = steps.find((step) => step.bic === best);
  const start = `${data.model} was ${data.chosen === false ? "asked for" : "chosen"}`;
  if (!rival || rival === answer) return `${start}: no other model explains the corners better.`;
  const weight = isNumber(rival.weight) && rival.weight >= 0.005
    ? ` The standard deviations include ${rival.model} by ${percent(rival.weight)}.` : "";
  const gap = `${rival.model} explains the corners better (${digits(answer.bic - best, 2)})`;
  if (data.chosen === false) return `${start}, although ${gap}.${weight}`;
  const why = isNumber(answer.difference_px)
    ? `, but where corners were the projection of ${data.model} differs from the best one's by ` +
      `${px(answer.difference_px)} only, with ${rival.num_parameters - answer.num_parameters} ` +
      "parameters less" : "";
  const refusal = /not taken: ([^;.]*)/.exec(rival.sentence ?? "")?.[1];
  return `${start}: ${gap}${refusal ? `, but ${refusal}` : why}.${weight}`;
}

export function ladder(data) {
  const steps = data.ladder ?? [];
  if (!steps.length) return null;
  const bics = steps.map((step) => step.bic).filter(isNumber);
  const best = Math.min(...bics);
  const evidence = logShare(bics.map((bic) => bic - best));
  const change = logShare(steps.map((step) => step.difference_px));
  const compared = steps.some((step) => isNumber(step.difference_px));
  const heads = ["model", "parameters", "evidence against", compared ? "difference" : null, "why"];
  return section("ladder", "Lens models that were tried", { wide: true },
    h("p", { class: "lead" }, choiceOf(data, steps, best)), chart({
    name: "ladder", marks: steps.length,
    label: `${steps.length} lens models with their evidence and projection difference`,
    read: "from simple to complex. Evidence: how much worse than the best model (BIC, logarithmic " +
      "bars; more than 10 is decisive). " +
      (compared ? "Difference: how far its projection lies from that of the best model, where " +
        "corners were (RMS). " : "") +
      "✓ marks the models that the data call for, up to the answer.",
  }, h("div", { class: "table-frame" }, h("table", { class: "ladder" },
    h("thead", null, h("tr", null,
      heads.filter(Boolean).map((head) => h("th", { scope: "col" }, head)))),
    h("tbody", null, steps.map((step) =>
      rowOf(step, { best, evidence, change, model: data.model, compared })))))));
}
