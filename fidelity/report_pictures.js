// The pictures of one comparison: both beside each other, their overlay, or A over B with a border to move.

const MODES = { beside: "Side by side", overlay: "Overlay", slider: "Slider" };

// Of the overlay (overlay.py): class to meaning.
const COLORS = { "only-a": "only in A", "only-b": "only in B", surface: "in depth or normal", color: "in colour alone" };

const differing = (picture) => Math.max(0, ...Object.values(picture.differing));

function image(source, label) {
  const element = make("img");
  element.src = source;
  element.alt = label;
  element.draggable = false;
  return element;
}

function plate(source, label, className = "") {
  const element = make("div", `plate ${className}`.trim());
  element.append(image(source, label));
  return element;
}

function figure(source, label, caption) {
  const element = make("figure");
  element.append(plate(source, label), make("figcaption", "", caption));
  return element;
}

function slider(picture, comparison, place) {
  const element = make("figure");
  const stack = make("div", "plate stack");
  stack.append(
    plate(picture.b, `B, ${picture.view}`, "below"),
    plate(picture.a, `A, ${picture.view}`, "above"),
    make("span", "side left", "A"),
    make("span", "side right", "B"),
  );
  const range = make("input", "border");
  range.type = "range";
  range.min = 0;
  range.max = 100;
  range.step = 1;
  range.value = place.value;
  range.setAttribute("aria-label", "Border between A and B");
  const move = () => {
    place.value = Number(range.value);
    stack.style.setProperty("--border", `${place.value}%`);
    range.setAttribute("aria-valuetext", `${place.value} % of A`);
  };
  range.addEventListener("input", move);
  const point = (event) => {
    const box = stack.getBoundingClientRect();
    range.value = (100 * (event.clientX - box.left)) / box.width;
    move();
  };
  stack.addEventListener("pointerdown", (event) => {
    stack.setPointerCapture(event.pointerId);
    point(event);
  });
  stack.addEventListener("pointermove", (event) => stack.hasPointerCapture(event.pointerId) && point(event));
  move();
  element.append(stack, range, make("figcaption", "", `left of the border ${comparison.a}, right of it ${comparison.b}`));
  return element;
}

// A row of buttons of which one is pressed. items: name to label.
function choice(label, items, chosen, choose) {
  const group = make("div");
  group.setAttribute("role", "group");
  group.setAttribute("aria-label", label);
  for (const [name, parts] of Object.entries(items)) {
    const button = make("button");
    button.type = "button";
    button.dataset.name = name;
    button.append(...parts);
    button.setAttribute("aria-pressed", name === chosen);
    button.addEventListener("click", () => {
      for (const other of group.children) other.setAttribute("aria-pressed", other === button);
      choose(name);
    });
    group.append(button);
  }
  return group;
}

// state: {view, mode}, kept from input to input; changed: called when the reader changes it.
function pictures(comparison, state, changed) {
  const seen = comparison.pictures.filter((picture) => picture.a && picture.b);
  for (const picture of seen) if (picture.b === "a") picture.b = picture.a;
  if (!seen.length) return [];
  const worst = seen.reduce((a, b) => (differing(b) > differing(a) ? b : a));
  let picture = seen.find((one) => one.view === state.view) ?? worst;
  const sheets = make("div", "sheets");
  const legend = make("p", "legend");
  const place = { value: 50 };
  const modes = Object.fromEntries(
    Object.entries(MODES).filter(([name]) => name !== "overlay" || seen.some((one) => one.overlay)).map(([name, title]) => [name, [title]]),
  );
  if (!(state.mode in modes)) state.mode = "beside";
  const show = () => {
    sheets.classList.toggle("single", state.mode !== "beside");
    if (state.mode === "slider") sheets.replaceChildren(slider(picture, comparison, place));
    else if (state.mode === "overlay" && picture.overlay) {
      const sheet = figure(picture.overlay, `Overlay, ${picture.view}`, "Pixels that differ: ");
      for (const [name, words] of Object.entries(COLORS)) sheet.lastChild.append(make("span", `key ${name}`), `${words} `);
      sheets.replaceChildren(sheet);
    } else {
      sheets.replaceChildren(
        figure(picture.a, `A, ${picture.view}`, `A: ${comparison.a}`),
        figure(picture.b, `B, ${picture.view}`, `B: ${comparison.b}`),
      );
    }
    const counts = Object.entries(picture.differing).map(([plane, count]) => `${count.toLocaleString("en")} in ${plane}`);
    const size = picture.size.join(" × ");
    legend.textContent = `Pixels that differ, of ${size}: ${counts.join(", ") || "none"}.`;
  };
  const views = Object.fromEntries(seen.map((one) => [one.view, [one.view, " ", make("span", "dim", differing(one).toLocaleString("en"))]]));
  const controls = make("div", "controls");
  controls.append(
    choice("View, and pixels that differ in it", views, picture.view, (name) => {
      picture = seen.find((one) => one.view === name);
      state.view = name;
      show();
      changed();
    }),
    choice("Way of showing", modes, state.mode, (name) => {
      state.mode = name;
      show();
      changed();
    }),
  );
  show();
  return [controls, sheets, legend];
}
