// The entries: taken apart, searched, filtered, sorted; and the state of all that as text for the address.

const collator = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

// Without case and accents, so that "cafe" finds "Café" however its bytes compose the accent.
const folded = (text) => text.normalize("NFKD").replace(/\p{M}/gu, "").toLowerCase();

const entries = data.rows.map((row) => {
  const [path, link, status, drawn, missing, seconds, memory, size, covered, sha256, reason] = row;
  const slash = path.lastIndexOf("/") + 1;
  return {
    path, link, status, drawn, missing, seconds, memory, size, covered, sha256, reason,
    name: path.slice(slash),
    folder: path.slice(0, slash),
    // A model has a face; none means that it was never read.
    faces: drawn + missing || -1,
    texts: [folded(path), folded(reason)],
  };
});
[...entries]
  .sort((a, b) => collator.compare(a.path, b.path) || (a.path < b.path ? -1 : 1))
  .forEach((entry, rank) => { entry.rank = rank; });

// What can be sorted by: text, value (below zero: not known), does the largest come first?
const SORTS = {
  name: ["Name", (entry) => entry.rank, false],
  status: ["Status", (entry) => entry.status, true],
  faces: ["Faces", (entry) => entry.faces, true],
  seconds: ["Seconds", (entry) => entry.seconds, true],
  memory: ["Memory", (entry) => entry.memory || -1, true],
  size: ["File size", (entry) => entry.size, true],
};
if (!entries.some((entry) => entry.size >= 0)) delete SORTS.size;

// Width of a tile, CSS px.
const TILES = { small: 96, medium: 136, large: 240 };

const START = { query: "", statuses: [], least: "", most: "", sort: "name", reverse: false, tiles: "medium", open: "" };

// The entries to show, in order, and how many each status would have.
function select(state) {
  const words = folded(state.query).split(/\s+/).filter(Boolean);
  const sha = /^[0-9a-f]{8,64}$/.test(state.query.trim().toLowerCase()) ? state.query.trim().toLowerCase() : "";
  const least = state.least === "" ? -Infinity : Number(state.least);
  const most = state.most === "" ? Infinity : Number(state.most);
  const ranged = state.least !== "" || state.most !== "";
  const counts = data.statuses.map(() => 0);
  const shown = [];
  for (const entry of entries) {
    if (ranged && !(entry.faces >= 0 && entry.faces >= least && entry.faces <= most)) continue;
    // All words in the one text, lest "part 1" find part 5 for "1 face not drawn".
    const found = entry.texts.some((text) => words.every((word) => text.includes(word)));
    if (!found && !(sha && entry.sha256.startsWith(sha))) continue;
    counts[entry.status] += 1;
    if (!state.statuses.length || state.statuses.includes(entry.status)) shown.push(entry);
  }
  const [, value, falling] = SORTS[state.sort];
  const sign = falling !== state.reverse ? -1 : 1;
  shown.sort((a, b) => {
    const x = value(a), y = value(b);
    if (x < 0 || y < 0) return (x < 0) - (y < 0) || a.rank - b.rank;
    return sign * (x - y) || a.rank - b.rank;
  });
  return { shown, counts };
}

// The state to the part of the address behind "#", and back; unknown words are passed over.
function stateToHash(state) {
  const words = new URLSearchParams();
  if (state.query) words.set("q", state.query);
  if (state.statuses.length) words.set("status", state.statuses.map((s) => data.statuses[s]).join(","));
  if (state.least !== "" || state.most !== "") words.set("faces", `${state.least}-${state.most}`);
  if (state.sort !== START.sort || state.reverse) words.set("sort", (state.reverse ? "-" : "") + state.sort);
  if (state.tiles !== START.tiles) words.set("tiles", state.tiles);
  if (state.open) words.set("open", state.open);
  return words.toString();
}

function hashToState(hash) {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  const state = { ...START, query: words.get("q") ?? "", open: words.get("open") ?? "" };
  state.statuses = (words.get("status") ?? "").split(",").map((s) => data.statuses.indexOf(s)).filter((s) => s >= 0);
  const range = /^(\d*)-(\d*)$/.exec(words.get("faces") ?? "");
  if (range) [, state.least, state.most] = range;
  const sort = /^(-?)(.*)$/s.exec(words.get("sort") ?? "");
  if (Object.hasOwn(SORTS, sort[2])) [state.reverse, state.sort] = [sort[1] === "-", sort[2]];
  if (Object.hasOwn(TILES, words.get("tiles") ?? "")) state.tiles = words.get("tiles");
  return state;
}

// Words of a quantity, and "–" where it is not known.
const number = new Intl.NumberFormat("en");
function bytes(value) {
  if (value < 0) return "–";
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  for (; value >= 1024 && unit < units.length - 1; unit += 1) value /= 1024;
  return `${unit && value < 100 ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}
const seconds = (value) => (value < 10 ? `${value.toFixed(2)} s` : `${value.toFixed(1)} s`);
const plural = (count, noun) => `${number.format(count)} ${noun}${count === 1 ? "" : "s"}`;
