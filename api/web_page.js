// What all pages share: finding elements, making them, the theme.

const $ = (id) => document.getElementById(id);

const data = JSON.parse($("data").textContent);

function make(tag, className, text) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text !== undefined) element.textContent = text;
  return element;
}

// What the system asks for, until the reader says otherwise. Some browsers refuse to remember it for a file.
function makeTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const kept = { get: () => localStorage.getItem("trimray-theme"), set: (value) => localStorage.setItem("trimray-theme", value) };
  const attempt = (act) => { try { return act(); } catch { return null; } };
  let chosen = attempt(kept.get) ?? "";
  const apply = () => {
    if (chosen) document.documentElement.dataset.theme = chosen;
    else delete document.documentElement.dataset.theme;
    $("theme").setAttribute("aria-pressed", chosen ? chosen === "dark" : dark.matches);
  };
  $("theme").addEventListener("click", () => {
    const wanted = (chosen ? chosen === "dark" : dark.matches) ? "light" : "dark";
    chosen = wanted === (dark.matches ? "dark" : "light") ? "" : wanted;
    attempt(() => kept.set(chosen));
    apply();
  });
  dark.addEventListener("change", apply);
  apply();
}
