// The page: an index of the inputs where there are several, and one of them with its comparisons.

const results = data.results;
const state = { input: 0, view: "", mode: "beside" };

const differences = (result) => result.comparisons.reduce((sum, one) => sum + one.differences, 0);
const valuesOf = (result) => result.comparisons.reduce((sum, one) => sum + one.values, 0);

// Browsers allow few changes of the address in a short time.
let timer;
function writeHash() {
  clearTimeout(timer);
  const words = new URLSearchParams();
  if (results.length > 1) words.set("input", state.input + 1);
  if (state.view) words.set("view", state.view);
  if (state.mode !== "beside") words.set("mode", state.mode);
  timer = setTimeout(() => history.replaceState(null, "", `#${words}`), 150);
}

function readHash() {
  const words = new URLSearchParams(location.hash.slice(1));
  const number = Number(words.get("input") ?? 1) - 1;
  state.input = Number.isInteger(number) && number in results ? number : 0;
  state.view = words.get("view") ?? "";
  state.mode = Object.hasOwn(MODES, words.get("mode") ?? "") ? words.get("mode") : "beside";
}

function makeIndex() {
  if (results.length < 2) return;
  const element = make("table");
  const body = make("tbody");
  results.forEach((result, number) => {
    const line = make("tr");
    const name = make("th");
    name.scope = "row";
    const link = make("a", "", result.input);
    link.href = `#input=${number + 1}`;
    link.addEventListener("click", (event) => {
      event.preventDefault();
      state.input = number;
      writeHash();
      show();
      $("result").focus();
    });
    name.append(link);
    const verdict = make("td", result.verdict);
    verdict.append(make("span", "badge", result.verdict));
    const error = [result, ...result.comparisons].map((one) => one.error).find(Boolean);
    const count = error ?? `${differences(result).toLocaleString("en")} of ${plural(valuesOf(result), "value")}`;
    line.append(name, verdict, make("td", error ? "" : "number", count));
    body.append(line);
  });
  element.append(heads(["Input", "Verdict", "Different"]), body);
  const scroll = make("div", "scroll");
  scroll.append(element);
  $("index").append(scroll);
}

function verdict(comparison) {
  const element = make("p", `verdict ${comparison.verdict}`);
  const count = plural(comparison.values, "value");
  const lacking = comparison.findings.filter(uncompared).length;
  const differ = comparison.differences - lacking;
  const parts = [differ ? `${differ.toLocaleString("en")} of ${count} differ` : `${count}, none differs`];
  if (lacking) parts.push(`${lacking.toLocaleString("en")} not compared`);
  const said = comparison.error || parts.join(", ");
  element.append(make("span", "badge", comparison.verdict), ` ${said}`, make("span", "dim", ` · ${comparison.profile} tolerances`));
  return element;
}

function show() {
  const result = results[state.input];
  const heading = make("h2", "", result.input);
  heading.id = "result-name";
  const parts = [heading];
  if (result.error) {
    const element = make("p", "verdict failed");
    element.append(make("span", "badge", "failed"), ` ${result.error}`);
    parts.push(element);
  }
  for (const comparison of result.comparisons) {
    // The name of a comparison of two files says both already.
    if (result.command === "check") parts.push(make("h3", "", "A: as declared · B: as it arrived"));
    if (result.command === "roundtrip") parts.push(make("h3", "", `A: ${comparison.a} · B: ${comparison.b}`));
    parts.push(verdict(comparison), ...different(comparison), ...pictures(comparison, state, writeHash));
    parts.push(...agreeing(comparison));
  }
  $("result").replaceChildren(...parts);
  [...$("index").querySelectorAll("tbody tr")].forEach((line, number) => {
    if (number === state.input) line.setAttribute("aria-current", "true");
    else line.removeAttribute("aria-current");
  });
}

const bad = results.filter((result) => result.verdict !== "complete").length;
$("count").textContent = results.length > 1
  ? (bad ? `${bad.toLocaleString("en")} of ${plural(results.length, "input")} not complete` : `${plural(results.length, "input")}, all complete`)
  : "";
makeTheme();
makeIndex();
if (results.length) {
  addEventListener("hashchange", () => { readHash(); show(); });
  readHash();
  show();
} else {
  $("result").append(make("p", "dim", "There was no input."));
}
