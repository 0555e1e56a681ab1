// The large picture of one entry with its facts, in a dialog that the browser keeps the focus in.

class Detail {
  constructor(root, moved) {
    this.dialog = document.getElementById("detail");
    this.root = root;
    this.moved = moved;
    this.shown = [];
    this.index = 0;
    const step = (by) => () => this.step(by);
    document.getElementById("previous").addEventListener("click", step(-1));
    document.getElementById("next").addEventListener("click", step(1));
    document.getElementById("close").addEventListener("click", () => this.dialog.close());
    this.dialog.addEventListener("click", (event) => event.target === this.dialog && this.dialog.close());
    // The event comes late: it may have been opened again, for another address.
    this.dialog.addEventListener("close", () => this.dialog.open || moved(this.index, false));
    this.dialog.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!by || event.altKey || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      this.step(by);
    });
  }

  open(shown, index) {
    this.shown = shown;
    this.go(index);
    if (!this.dialog.open) this.dialog.showModal();
  }

  close() {
    if (this.dialog.open) this.dialog.close();
  }

  step(by) {
    const index = this.index + by;
    if (index >= 0 && index < this.shown.length) this.go(index);
  }

  go(index) {
    this.index = index;
    const entry = this.shown[index];
    document.getElementById("detail-name").textContent = entry.name;
    document.getElementById("detail-place").textContent = `${number.format(index + 1)} of ${number.format(this.shown.length)}`;
    // Not "disabled": that would drop the focus from a button at the end of the list.
    document.getElementById("previous").setAttribute("aria-disabled", index === 0);
    document.getElementById("next").setAttribute("aria-disabled", index === this.shown.length - 1);
    const plate = picture(entry, true);
    document.getElementById("detail-picture").replaceChildren(plate);
    document.getElementById("detail-facts").replaceChildren(...this.facts(entry));
    if (entry.link) this.enlarge(plate.firstChild, entry);
    else plate.firstChild.textContent = "No picture"; // the reason stands beside it
    this.moved(index, true);
  }

  // Twice its size at most, and the size said: more would only show larger pixels.
  enlarge(image, entry) {
    image.alt = `Picture of ${entry.name}`;
    image.addEventListener("load", () => {
      image.style.width = `${2 * image.naturalWidth}px`;
      if (image.isConnected) this.pixels.textContent = `${image.naturalWidth} × ${image.naturalHeight} px`;
    });
  }

  facts(entry) {
    const status = data.statuses[entry.status];
    const verdict = make("p", `verdict ${status}`);
    verdict.append(make("span", "badge", status));
    if (entry.reason) verdict.append(" ", make("span", "reason", entry.reason));
    const list = make("dl");
    const add = (term, text, className = "") => {
      const [dt, dd] = [make("dt", className && "wide", term), make("dd", className, text)];
      list.append(dt, dd);
      return dd;
    };
    add("Path", `${this.root}${entry.path}`, "wide path");
    add("Faces drawn", entry.faces < 0 ? "–" : number.format(entry.drawn));
    add("Faces not drawn", entry.faces < 0 ? "–" : number.format(entry.missing));
    if (entry.link) {
      this.pixels = add("Picture", "–");
      add("Shows the model", `${(100 * entry.covered).toFixed(entry.covered < 0.01 ? 2 : 0)} % of it`);
    }
    add("Time", seconds(entry.seconds));
    add("Peak memory", entry.memory ? bytes(entry.memory * 2 ** 20) : "–");
    if (entry.size >= 0) add("File size", bytes(entry.size));
    add("SHA-256", entry.sha256 || "–", "wide code");
    const parts = [verdict, list];
    if (entry.link) {
      const link = make("a", "", "Open the picture alone");
      link.href = entry.link;
      link.target = "_blank";
      link.rel = "noopener noreferrer";
      parts.push(link);
    }
    return parts;
  }
}
