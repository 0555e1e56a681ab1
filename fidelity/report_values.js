// Values: as text, in rows, in tables.

const SECTIONS = ["file", "structure", "topology", "mass", "geometry", "pictures"];
const MOST_ROWS = 2000; // of one table; the JSON has all

const plural = (count, noun) => `${count.toLocaleString("en")} ${noun}${count === 1 ? "" : "s"}`;

// To 12 digits, which is what the strictest profile can tell apart.
function text(value) {
  if (value === null) return "–";
  if (value === true) return "yes";
  if (value === false) return "no";
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(12)));
  if (Array.isArray(value)) return `(${value.map(text).join(", ")})`;
  if (typeof value === "object") return Object.entries(value).map(([key, item]) => `${key} ${text(item)}`).join(", ");
  return value;
}

function short(value) {
  if (Number.isInteger(value)) return String(value);
  const small = value !== 0 && Math.abs(value) < 1e-3;
  return small ? value.toExponential(2).replace(/\.?0+e/, "e") : String(Number(value.toPrecision(3)));
}

function quantity(value, unit) {
  if (value === null) return "";
  return `${typeof value === "number" ? short(value) : value} ${unit}`.trim();
}

// What should have been compared and could not be.
const uncompared = (finding) => !finding.same && finding.reason.startsWith("not compared");

function outcome(finding) {
  if (uncompared(finding)) return "not compared";
  if (!finding.same) return finding.missing ? "missing" : "differs";
  return finding.reason.startsWith("not ") ? "not judged" : "agrees";
}

function row(finding) {
  const kind = finding.same ? "" : finding.missing ? "missing" : "differs";
  const element = make("tr", kind);
  const name = make("td");
  name.append(make("span", "dim", `${finding.section} `), finding.name);
  if (finding.where) name.append(make("span", "dim", ` ${finding.where}`));
  if (finding.reason) name.append(make("span", "reason", finding.reason));
  const judged = !finding.reason.startsWith("not ");
  const tolerance = finding.tolerance !== null ? quantity(finding.tolerance, finding.unit) : judged ? "equal" : "";
  element.append(
    name,
    make("td", "value", text(finding.a)),
    make("td", "value", text(finding.b)),
    make("td", "number", quantity(finding.difference, finding.unit)),
    make("td", "number", tolerance),
    make("td", "", outcome(finding)),
  );
  return element;
}

function heads(titles) {
  const line = make("tr");
  for (const title of titles) {
    const cell = make("th", "", title);
    cell.scope = "col";
    line.append(cell);
  }
  const head = make("thead");
  head.append(line);
  return head;
}

function table(findings, label) {
  const element = make("table");
  element.setAttribute("aria-label", label);
  const body = make("tbody");
  body.append(...findings.slice(0, MOST_ROWS).map(row));
  element.append(heads(["Value", "A", "B", "Difference", "Tolerance", "Outcome"]), body);
  const scroll = make("div", "scroll");
  scroll.tabIndex = 0;
  scroll.setAttribute("role", "region");
  scroll.setAttribute("aria-label", label);
  scroll.append(element);
  if (findings.length > MOST_ROWS) {
    scroll.append(make("p", "dim", `${plural(findings.length - MOST_ROWS, "more value")}: the JSON has all of them.`));
  }
  return scroll;
}

function different(comparison) {
  const found = comparison.findings.filter((finding) => !finding.same);
  return found.length ? [table(found, "Differences")] : [];
}

// By section, each table made when it is opened.
function agreeing(comparison) {
  const parts = [];
  for (const section of SECTIONS) {
    const found = comparison.findings.filter((finding) => finding.same && finding.section === section);
    if (!found.length) continue;
    const details = make("details");
    details.append(make("summary", "", `${section}: ${plural(found.length, "value")} ${found.length === 1 ? "agrees" : "agree"}`));
    details.addEventListener("toggle", () => {
      if (details.open && details.childElementCount === 1) details.append(table(found, section));
    });
    parts.push(details);
  }
  return parts;
}
