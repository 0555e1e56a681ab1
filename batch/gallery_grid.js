// The grid of tiles. Only the rows near the window are in the document, however many entries there are.

const OVERSCAN = 2; // rows above and below the window
const GAP = 10; // CSS px
const CAPTION = 3.75; // rem: three lines below a picture

// The bounds keep very flat or tall pictures from making the tiles useless.
const aspect = Math.min(1.5, Math.max(0.5, data.aspect || 1));

// A name that is cut in its middle when it is too long, since names of parts differ at their ends.
function cutName(className, text, width) {
  const element = make("div", className);
  const cut = text.length - Math.min(width < 120 ? 8 : 13, text.length >> 1);
  element.append(make("span", "start", text.slice(0, cut)), make("span", "end", text.slice(cut)));
  return element;
}

// The picture of an entry, or why there is none.
function picture(entry, eager) {
  const plate = make("div", "plate");
  if (!entry.link) {
    plate.classList.add("empty");
    plate.append(make("p", "why", entry.reason || "no picture"));
    return plate;
  }
  const image = make("img");
  image.alt = "";
  image.decoding = "async";
  image.loading = eager ? "eager" : "lazy";
  image.addEventListener("error", () => {
    plate.classList.add("empty");
    plate.replaceChildren(make("p", "why", "Picture missing, or of a format that this browser does not show"));
  });
  image.src = entry.link;
  plate.append(image);
  return plate;
}

function faces(entry) {
  if (entry.faces < 0) return "";
  return entry.missing ? `${number.format(entry.drawn)} of ${plural(entry.faces, "face")}` : plural(entry.faces, "face");
}

function tile(entry, width, eager) {
  const status = data.statuses[entry.status];
  const element = make("div", `tile ${status}`);
  element.title = entry.reason ? `${entry.path}\n${status}: ${entry.reason}` : entry.path;
  const facts = make("div", "facts");
  if (status !== "complete") facts.append(make("span", "badge", status), " ");
  // What is remarkable about it: a failed one has its reason in place of its picture.
  const remark = status === "complete" || status === "failed" || entry.missing ? "" : entry.reason;
  facts.append(remark || [faces(entry), seconds(entry.seconds)].filter(Boolean).join(" · "));
  const names = [cutName("name", entry.name, width), cutName("folder", entry.folder, width)];
  element.append(picture(entry, eager), ...names, facts);
  return element;
}

class Grid {
  constructor(element, head, open) {
    this.element = element;
    this.head = head;
    this.open = open;
    this.shown = [];
    this.active = 0;
    this.rows = new Map(); // by number
    this.cells = new Map(); // by entry
    this.printing = false;
    element.addEventListener("click", (event) => {
      const cell = event.target.closest(".tile");
      if (!cell) return;
      this.active = Number(cell.dataset.index);
      this.mark();
      open(this.active);
    });
    element.addEventListener("keydown", (event) => this.key(event));
    element.addEventListener("focus", () => this.mark());
    addEventListener("scroll", () => this.later(), { passive: true });
    new ResizeObserver(() => element.clientWidth !== this.width && this.layout()).observe(element);
    addEventListener("resize", () => this.later());
    addEventListener("beforeprint", () => this.print(true));
    addEventListener("afterprint", () => this.print(false));
  }

  // Shows other entries, or the same in another order; the active one stays active where it is still there.
  show(shown, tileWidth) {
    const kept = shown.indexOf(this.shown[this.active]);
    this.shown = shown;
    this.tileWidth = tileWidth;
    this.active = Math.max(0, kept);
    this.layout();
  }

  layout() {
    const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
    const width = this.element.clientWidth;
    this.width = width;
    this.columns = Math.max(1, Math.floor((width + GAP) / (this.tileWidth + GAP)));
    const plate = Math.round(((width - GAP * (this.columns - 1)) / this.columns) * aspect);
    this.height = Math.round(plate + CAPTION * rem + GAP);
    this.count = Math.ceil(this.shown.length / this.columns);
    this.element.style.setProperty("--columns", this.columns);
    this.element.style.setProperty("--aspect", 1 / aspect);
    this.element.style.setProperty("--plate", `${plate}px`);
    this.element.style.setProperty("--row", `${this.height - GAP}px`);
    this.element.style.height = `${this.count * this.height}px`;
    // Where the browser scrolls to something, it is to be seen below the head.
    document.documentElement.style.scrollPaddingTop = `${this.fixed() + GAP}px`;
    this.element.setAttribute("aria-rowcount", this.count);
    this.element.setAttribute("aria-colcount", this.columns);
    // Tiles that stay are moved, not made anew: their pictures would flicker.
    const kind = `${this.tileWidth} ${this.printing}`;
    this.former = kind === this.kind ? this.cells : new Map();
    this.kind = kind;
    this.cells = new Map();
    this.rows.forEach((row) => row.remove());
    this.rows.clear();
    this.paint();
    this.former = new Map();
  }

  later() {
    this.pending ??= requestAnimationFrame(() => {
      this.pending = undefined;
      this.paint();
    });
  }

  // Puts the rows near the window into the document and takes the others out.
  paint() {
    const top = -this.element.getBoundingClientRect().top;
    let first = Math.max(0, Math.floor(top / this.height) - OVERSCAN);
    let last = Math.min(this.count, Math.ceil((top + innerHeight) / this.height) + OVERSCAN);
    if (this.printing) [first, last] = [0, this.count];
    for (const [index, row] of this.rows) {
      if (index >= first && index < last) continue;
      row.remove();
      this.rows.delete(index);
      this.slice(index).forEach((entry) => this.cells.delete(entry));
    }
    for (let index = first; index < last; index += 1) {
      if (!this.rows.has(index)) this.rows.set(index, this.row(index));
    }
    this.mark();
  }

  slice(index) {
    return this.shown.slice(index * this.columns, (index + 1) * this.columns);
  }

  row(index) {
    const row = make("div", "row");
    row.setAttribute("role", "row");
    row.setAttribute("aria-rowindex", index + 1);
    row.style.top = `${index * this.height}px`;
    const start = index * this.columns;
    this.slice(index).forEach((entry, column) => {
      const cell = this.former.get(entry) ?? tile(entry, this.tileWidth, this.printing);
      this.cells.set(entry, cell);
      cell.id = `tile-${start + column}`;
      cell.dataset.index = start + column;
      cell.setAttribute("role", "gridcell");
      cell.setAttribute("aria-colindex", column + 1);
      row.append(cell);
    });
    // In the order of reading, for screen readers and for the print.
    const next = [...this.rows.entries()].filter(([other]) => other > index).sort(([a], [b]) => a - b)[0];
    this.element.insertBefore(row, next ? next[1] : null);
    return row;
  }

  // The grid has the focus, and says which of its tiles is the active one: that tile may be out of the document.
  mark() {
    this.element.querySelector(".active")?.classList.remove("active");
    const cell = document.getElementById(`tile-${this.active}`);
    cell?.classList.add("active");
    if (cell) this.element.setAttribute("aria-activedescendant", cell.id);
    else this.element.removeAttribute("aria-activedescendant");
  }

  move(index) {
    this.active = Math.max(0, Math.min(this.shown.length - 1, index));
    this.reveal();
  }

  // Height of what always covers the top of the window.
  fixed() {
    return getComputedStyle(this.head).position === "sticky" ? this.head.offsetHeight : 0;
  }

  // Scrolls as little as it takes to see the active tile whole, below a head that stays at the top.
  reveal() {
    const box = this.element.getBoundingClientRect();
    const top = box.top + Math.floor(this.active / this.columns) * this.height;
    const fixed = this.fixed();
    if (top < fixed + GAP) scrollBy(0, top - fixed - GAP);
    else if (top + this.height > innerHeight) scrollBy(0, Math.min(top - fixed - GAP, top + this.height - innerHeight));
    this.paint();
  }

  key(event) {
    if (event.altKey || event.metaKey) return;
    const page = Math.max(1, Math.floor((innerHeight - this.fixed()) / this.height)) * this.columns;
    const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -this.columns, ArrowDown: this.columns, PageUp: -page, PageDown: page };
    // After a turn of the wheel one goes on from what is to be seen.
    if (event.key in steps && !event.ctrlKey && !document.getElementById(`tile-${this.active}`)) {
      const top = this.fixed() - this.element.getBoundingClientRect().top;
      this.move(Math.ceil(top / this.height) * this.columns);
      event.preventDefault();
      return;
    }
    const up = this.active - this.columns < 0, down = Math.floor(this.active / this.columns) >= this.count - 1;
    if (event.key === "Home") this.move(0);
    else if (event.key === "End") this.move(this.shown.length - 1);
    else if (event.key === "Enter" || event.key === " ") this.shown.length && this.open(this.active);
    else if (!(event.key in steps) || event.ctrlKey) return;
    else if (!(event.key === "ArrowUp" && up) && !(event.key === "ArrowDown" && down)) this.move(this.active + steps[event.key]);
    event.preventDefault();
  }

  // On paper all tiles are needed at once.
  print(printing) {
    this.printing = printing;
    this.layout();
  }
}
