// What every report can do: terms, tables, folds, contents, theme; and it starts the widgets.
import { drive } from "./drive.js";
import { map } from "./map.js";
import { makeTable, save } from "./tables.js";
import { unpackAll } from "./unpack.js";

const Octant = { widgets: { map, drive }, tables: new Map(), makeTable };
globalThis.Octant = Octant;
document.documentElement.classList.add("js");

function element(name, attributes, ...children) {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...children);
  return made;
}

function explainTerms() {
  const box = element("div", { id: "meaning", hidden: true });
  box.setAttribute("role", "tooltip");
  document.body.append(box);
  const show = (term) => {
    box.textContent = term.dataset.meaning;
    box.hidden = false;
    const at = term.getBoundingClientRect();
    const left = Math.max(8, Math.min(at.left, innerWidth - box.offsetWidth - 8));
    box.style.left = `${left + scrollX}px`;
    box.style.top = `${at.bottom + scrollY + 6}px`;
    term.setAttribute("aria-describedby", "meaning");
  };
  const hide = () => { box.hidden = true; };
  for (const term of document.querySelectorAll("dfn.term")) {
    term.dataset.meaning = term.title;
    term.removeAttribute("title");
    term.addEventListener("mouseenter", () => show(term));
    term.addEventListener("focus", () => show(term));
    term.addEventListener("click", () => show(term));
    term.addEventListener("mouseleave", hide);
    term.addEventListener("blur", hide);
  }
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
}

function foldAndCopy() {
  const folds = [...document.querySelectorAll("details.fold")];
  const narrow = matchMedia("(max-width: 76rem)").matches;
  if (narrow) document.querySelector(".contents details").open = false;
  for (const fold of folds) fold.open = false;
  const open = () => { for (const fold of folds) { fold.dataset.was = fold.open; fold.open = true; } };
  const back = () => { for (const fold of folds) fold.open = fold.dataset.was === "true"; };
  addEventListener("beforeprint", open);
  addEventListener("afterprint", back);
  for (const text of document.querySelectorAll("pre")) {
    const button = element("button", { className: "small", textContent: "Copy" });
    button.addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(text.textContent);
      } catch {
        getSelection().selectAllChildren(text);
        document.execCommand("copy");
        getSelection().removeAllRanges();
      }
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    });
    const box = element("div", { className: "code" });
    text.replaceWith(box);
    box.append(text, button);
  }
}

function follow() {
  const links = new Map([...document.querySelectorAll(".contents a")]
    .map((link) => [link.getAttribute("href").slice(1), link]));
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      for (const link of links.values()) link.classList.remove("now");
      links.get(entry.target.id)?.classList.add("now");
    }
  }, { rootMargin: "-5% 0px -80% 0px" });
  for (const section of document.querySelectorAll("main > section")) seen.observe(section);
}

function theme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const button = element("button", { className: "small theme" });
  const root = document.documentElement;
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);
  const said = () => { button.textContent = isDark() ? "Light" : "Dark"; };
  const changed = () => {
    said();
    dispatchEvent(new Event("octant-theme"));
  };
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    changed();
  });
  dark.addEventListener("change", changed);
  said();
  document.querySelector(".contents details").append(button);
}

function downloads() {
  for (const image of document.querySelectorAll("figure > img")) {
    const button = element("button", { className: "small", textContent: "PNG",
      title: "Save this figure as a PNG file" });
    const name = image.alt.split(".")[0].toLowerCase().replace(/[^a-z0-9]+/g, "-");
    button.addEventListener("click", () => save(`${name}.png`, image.src));
    image.nextElementSibling.append(" ", button);
  }
}

async function library(name) {
  const script = document.getElementById(`library-${name}`);
  if (!script || script.dataset.ready) return;
  script.dataset.ready = "yes";
  const bytes = Uint8Array.from(atob(script.textContent), (c) => c.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const code = element("script", { textContent: await new Response(plain).text() });
  document.head.append(code);
}

const loading = new Map();

async function start(box) {
  const { kind, library: name } = box.dataset;
  try {
    if (name) {
      if (!loading.has(name)) loading.set(name, library(name));
      await loading.get(name);
    }
    const data = await unpackAll(JSON.parse(box.querySelector("script.data").textContent));
    await Octant.widgets[kind](box.querySelector(".live"), data, box);
    box.classList.add("open");
    box.dataset.ready = "yes";
  } catch (reason) {
    box.querySelector(".live").textContent = "";
    box.dataset.ready = "no";
    console.warn(`${kind}: ${reason}`);
  }
}

function startWidgets() {
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      near.unobserve(entry.target);
      start(entry.target);
    }
  }, { rootMargin: "900px" });
  for (const box of document.querySelectorAll(".widget")) near.observe(box);
}

for (const box of document.querySelectorAll(".table")) {
  const made = makeTable(box);
  if (box.id) Octant.tables.set(box.id, made);
}
foldAndCopy();
explainTerms();
follow();
theme();
downloads();
startWidgets();
