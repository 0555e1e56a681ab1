// The page: one state, told by the address; controls change it, and everything is shown from it.

let state = { ...START };
let selection = { shown: [], counts: [] };

const grid = new Grid($("grid"), $("head"), (index) => detail.open(selection.shown, index));
const detail = new Detail(data.root ? `${data.root.replace(/\/$/, "")}/` : "", (index, open) => {
  state.open = open ? selection.shown[index].path : "";
  writeHash();
  grid.move(index);
  if (!open) $("grid").focus({ preventScroll: true });
});

// Browsers allow few changes of the address in a short time.
let timer;
function writeHash() {
  clearTimeout(timer);
  timer = setTimeout(() => history.replaceState(null, "", `#${stateToHash(state)}`), 150);
}

function change(changes) {
  Object.assign(state, changes);
  scrollTo(0, Math.min(scrollY, $("grid").offsetTop - grid.fixed() - GAP));
  writeHash();
  show();
}

// Writes a value where it differs: the cursor stays in the field that is being typed in.
function put(field, value) {
  if (field.value !== value) field.value = value;
}

function show() {
  selection = select(state);
  const { shown, counts } = selection;
  put($("search"), state.query);
  put($("least"), state.least);
  put($("most"), state.most);
  put($("sort"), state.sort);
  put($("tiles"), state.tiles);
  const falling = SORTS[state.sort][2] !== state.reverse;
  $("direction").textContent = falling ? "↓" : "↑";
  $("direction").setAttribute("aria-label", falling ? "Falling; turn the order round" : "Rising; turn the order round");
  for (const chip of $("statuses").children) {
    const status = Number(chip.dataset.status);
    chip.setAttribute("aria-pressed", state.statuses.includes(status));
    chip.classList.toggle("zero", !counts[status]);
    chip.lastChild.textContent = number.format(counts[status]);
  }
  const all = entries.length;
  $("count").textContent = shown.length === all ? plural(all, "file") : `${number.format(shown.length)} of ${plural(all, "file")}`;
  $("clear").disabled = !(state.query || state.statuses.length || state.least !== "" || state.most !== "");
  $("none").hidden = shown.length > 0;
  $("none").textContent = all ? "No file matches the search and the filters." : "The batch holds no files.";
  $("grid").hidden = !shown.length;
  grid.show(shown, TILES[state.tiles]);
}

function readHash() {
  clearTimeout(timer);
  const opened = hashToState(location.hash);
  const { open } = opened;
  detail.close();
  state = opened;
  show();
  const index = open ? selection.shown.findIndex((entry) => entry.path === open) : -1;
  if (index >= 0) detail.open(selection.shown, index);
}

function makeControls() {
  data.statuses.forEach((status, index) => {
    if (!entries.some((entry) => entry.status === index)) return;
    const chip = make("button", `chip ${status}`);
    chip.type = "button";
    chip.dataset.status = index;
    chip.append(make("span", "dot"), status, " ", make("span", "number"));
    chip.addEventListener("click", () => {
      const others = state.statuses.filter((other) => other !== index);
      change({ statuses: others.length === state.statuses.length ? [...others, index].sort() : others });
    });
    $("statuses").append(chip);
  });
  for (const [key, [text]] of Object.entries(SORTS)) $("sort").append(new Option(text, key));
  for (const key of Object.keys(TILES)) $("tiles").append(new Option(key, key));
  $("search").addEventListener("input", () => change({ query: $("search").value }));
  for (const id of ["least", "most"]) {
    $(id).addEventListener("input", () => change({ [id]: $(id).value.replace(/\D.*$/, "") }));
  }
  $("sort").addEventListener("change", () => change({ sort: $("sort").value, reverse: false }));
  $("direction").addEventListener("click", () => change({ reverse: !state.reverse }));
  $("tiles").addEventListener("change", () => change({ tiles: $("tiles").value }));
  $("clear").addEventListener("click", () => {
    change({ query: "", statuses: [], least: "", most: "" });
    $("search").focus();
  });
  $("controls").addEventListener("submit", (event) => event.preventDefault());
}

function makeKeys() {
  const moves = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"];
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || $("detail").open) return;
    const typing = event.target.matches("input, select, textarea");
    if (event.key === "/" && !typing) $("search").select();
    else if (event.key === "ArrowDown" && event.target === $("search")) $("grid").focus({ preventScroll: true });
    else if (event.key === "Escape" && event.target === $("search")) change({ query: "" });
    // Nothing has the focus yet: the arrows are meant for the pictures.
    else if (moves.includes(event.key) && event.target === document.body) $("grid").focus({ preventScroll: true });
    else return;
    event.preventDefault();
  });
}

document.body.classList.toggle("flat", entries.every((entry) => !entry.folder));
makeTheme();
makeControls();
makeKeys();
addEventListener("hashchange", readHash);
readHash();
