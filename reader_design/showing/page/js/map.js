// The map explorer: what the reader receives at every place of the floor, as one asks for it.
import { colourMap, gradient } from "./colours.js";
import { choice, css, fixed, make, Plan, slider, TAG } from "./plan.js";
import { Rose, vectorSum, wrap } from "./rose.js";

const RAD = Math.PI / 180;

export function map(live, data) {
  const { grid, tags } = data;
  const azimuths = data.azimuths_deg.map((a) => a * RAD);
  const n = azimuths.length;
  const cells = grid.nx * grid.ny;
  const headings = allHeadings(data);
  const quantities = [["coherent", "RSS, coherent"], ["mean", "RSS, local mean"],
    ["vector", "bearing error, vector sum"], ["strongest", "bearing error, strongest antenna"],
    ["rms", "bearing error, rms over all headings"], ["captured", "capture by a reflection"]]
    .filter(([name]) => (name === "mean" || name === "captured" || name === "rms" ? data[name]
      : name === "coherent" || n > 1));
  const state = { tag: data.tag ?? 0, antenna: -1, heading: data.heading ?? 0, quantity: "coherent",
    limits: {}, place: null };
  const unit = () => ({ coherent: "dBm", mean: "dBm", captured: "%" })[state.quantity] ?? "°";
  const isRss = () => unit() === "dBm";

  const levels = (cell, quantity = "coherent", turn = headings[state.heading]) => {
    const block = data[quantity];
    const begin = ((turn.base * tags.length + state.tag) * cells + cell) * n;
    return azimuths.map((_, i) => block.values[begin + (i + turn.shift) % n]);
  };
  const towards = (cell) => Math.atan2(tags[state.tag].y - grid.y0 - Math.floor(cell / grid.nx) * grid.dy,
    tags[state.tag].x - grid.x0 - (cell % grid.nx) * grid.dx);
  const turnOf = () => (headings[state.heading].deg - 90) * RAD;
  const bearing = (list, kind) => (kind === "vector" ? vectorSum(list, azimuths)
    : azimuths[list.indexOf(Math.max(...list))]);
  const valueAt = (cell) => {
    const q = state.quantity;
    if (q === "captured" || q === "rms") return data[q].values[state.tag * cells + cell];
    const list = levels(cell, q === "mean" ? "mean" : "coherent");
    if (!list.some(Number.isFinite)) return NaN;
    if (isRss()) return state.antenna < 0 ? Math.max(...list.filter(Number.isFinite)) : list[state.antenna];
    return Math.abs(wrap(bearing(list, q) + turnOf() - towards(cell))) / RAD;
  };

  let values = new Float32Array(cells);
  const range = () => ({ "°": [0, 180], "%": [0, 100] })[unit()] ?? data.range_dbm;
  const passes = (value) => (isRss() ? value >= limit() : value <= limit());
  const limit = () => state.limits[unit()] ?? { dBm: data.threshold_dbm, "°": 90, "%": 50 }[unit()];

  const view = new Plan(data.plan, (context) => {
    const [low, high] = range();
    const colour = colourMap(isRss() ? "viridis" : unit() === "°" ? "error" : "share");
    const image = new ImageData(grid.nx, grid.ny);
    for (let cell = 0; cell < cells; cell += 1) {
      const value = values[cell];
      if (Number.isNaN(value)) continue;
      const at = 4 * ((grid.ny - 1 - Math.floor(cell / grid.nx)) * grid.nx + (cell % grid.nx));
      image.data.set([...colour((value - low) / (high - low)), passes(value) ? 255 : 70], at);
    }
    const small = new OffscreenCanvas(grid.nx, grid.ny);
    small.getContext("2d").putImageData(image, 0, 0);
    const [x, y] = view.at(grid.x0 - grid.dx / 2, grid.y0 + (grid.ny - 0.5) * grid.dy);
    context.imageSmoothingEnabled = false;
    context.drawImage(small, x, y, grid.nx * grid.dx * view.scale, grid.ny * grid.dy * view.scale);
    view.walls(context);
    view.tags(context, tags, state.tag);
    if (state.place !== null) ring(context);
  });
  const ring = (context) => {
    const [x, y] = view.at(grid.x0 + (state.place % grid.nx) * grid.dx,
      grid.y0 + Math.floor(state.place / grid.nx) * grid.dy);
    for (const [colour, width] of [["#fff", 4], ["#14181d", 1.8]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.arc(x, y, 7, 0, 2 * Math.PI);
      context.stroke();
    }
  };

  const rose = new Rose(azimuths);
  const read = make("p", { className: "value" });
  const share = make("p", { className: "note" });
  const bar = make("div", { className: "bar" });
  const ends = make("div", { className: "ends" }, make("span"), make("span"));
  const where = (cell) => `x ${fixed(grid.x0 + (cell % grid.nx) * grid.dx, 2, "m")}, y ${
    fixed(grid.y0 + Math.floor(cell / grid.nx) * grid.dy, 2, "m")}`;
  const say = (cell) => {
    const value = values[cell];
    if (Number.isNaN(value)) return `${where(cell)}: the reader does not fit here, or nothing arrives.`;
    return `${where(cell)}: ${fixed(value, unit() === "%" ? 0 : 1, unit())}`;
  };

  const showRose = () => {
    if (state.place === null || Number.isNaN(values[state.place])) {
      read.textContent = state.place === null ? "Click a place on the map, or move there with the arrow keys."
        : say(state.place);
      rose.node.style.display = "none";
      return;
    }
    rose.node.style.display = "";
    const list = levels(state.place, state.quantity === "mean" ? "mean" : "coherent");
    const best = list.indexOf(Math.max(...list.filter(Number.isFinite)));
    const vector = vectorSum(list, azimuths) + turnOf();
    const error = Math.abs(wrap(vector - towards(state.place))) / RAD;
    const said = `${say(state.place)}. Strongest: antenna ${best + 1}, ${fixed(list[best], 1, "dBm")}. The vector sum errs by ${fixed(error, 0, "°")}.`;
    rose.show(list, turnOf(), [[towards(state.place), TAG, "", "tag"], [vector, css("--ink"), "5 5", "vector sum"]], said);
    read.textContent = said;
  };

  const update = () => {
    for (let cell = 0; cell < cells; cell += 1) values[cell] = valueAt(cell);
    let fit = 0, good = 0;
    for (const value of values) {
      if (Number.isNaN(value)) continue;
      fit += 1;
      good += passes(value);
    }
    const text = fixed(limit(), 0, unit());
    share.textContent = `${fixed(100 * good / Math.max(fit, 1), 0, "%")} of the floor where the reader fits has ${
      isRss() ? `at least ${text}` : `no more than ${text}`}; the rest is faded.`;
    const [low, high] = range();
    bar.style.background = gradient(isRss() ? "viridis" : unit() === "°" ? "error" : "share");
    ends.firstChild.textContent = fixed(low, 0, unit());
    ends.lastChild.textContent = fixed(high, 0, unit());
    antenna.select.disabled = !isRss();
    turn.input.disabled = ["rms", "captured"].includes(state.quantity);
    Object.assign(threshold.input, { min: low, max: high });
    threshold.input.value = limit();
    threshold.say();
    view.canvas.setAttribute("aria-label", `Map of the floor: ${what.select.selectedOptions[0].textContent
    }, tag ${tags[state.tag].id}. ${share.textContent}`);
    view.redraw();
    showRose();
  };

  const tag = choice("Tag", tags.map((one, i) => [i, one.id]), (value) => { state.tag = Number(value); update(); });
  const what = choice("Show", quantities, (value) => { state.quantity = value; update(); });
  const antenna = choice("Antenna", [[-1, "strongest"], ...azimuths.map((_, i) => [i, `${i + 1}`])],
    (value) => { state.antenna = Number(value); update(); });
  const turn = slider("Heading", { min: 0, max: headings.length - 1, step: 1, value: state.heading },
    (value) => fixed(headings[value].deg, headings.some((h) => h.deg % 1) ? 1 : 0, "°"),
    (value) => { state.heading = value; update(); });
  const threshold = slider("Threshold", { min: -200, max: 100, step: 1, value: data.threshold_dbm },
    (value) => fixed(value, 0, unit()), (value) => { state.limits[unit()] = value; update(); });
  tag.select.value = state.tag;

  view.canvas.addEventListener("mousemove", (event) => {
    const cell = cellAt(view.place(event));
    if (cell !== null) view.canvas.title = say(cell);
  });
  const cellAt = ([x, y]) => {
    const i = Math.round((x - grid.x0) / grid.dx), j = Math.round((y - grid.y0) / grid.dy);
    return i < 0 || j < 0 || i >= grid.nx || j >= grid.ny ? null : j * grid.nx + i;
  };
  const choose = (cell) => { state.place = cell; view.redraw(); showRose(); };
  view.canvas.addEventListener("click", (event) => {
    const cell = cellAt(view.place(event));
    if (cell !== null) choose(cell);
  });
  view.canvas.addEventListener("keydown", (event) => {
    const move = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: grid.nx, ArrowDown: -grid.nx }[event.key];
    if (!move) return;
    event.preventDefault();
    const next = state.place === null ? Math.floor(grid.ny / 2) * grid.nx + Math.floor(grid.nx / 2)
      : state.place + move;
    if (next >= 0 && next < cells) choose(next);
  });

  const controls = make("div", { className: "controls" }, tag.box, what.box);
  if (n > 1) controls.append(antenna.box);
  if (headings.length > 1) controls.append(turn.box);
  controls.append(threshold.box);
  const side = make("div", {}, bar, ends, share, rose.node, read,
    make("p", { className: "note", innerHTML: `Wedges: RSS of each antenna over 30\u202fdB, towards where it faces. <span style="color:${TAG}">Red</span>: the tag; dashed: the vector sum.` }));
  live.append(controls, make("div", { className: "stage" }, view.box, side));
  update();
}

function allHeadings(data) {
  const turns = data.turn ? Math.round(360 / data.turn.step_deg) : 1;
  const list = [];
  data.headings_deg.forEach((deg, base) => {
    for (let k = 0; k < turns; k += 1)
      list.push({ deg: (deg + (data.turn ? k * data.turn.step_deg : 0)) % 360, base,
        shift: data.turn ? k * data.turn.shift : 0 });
  });
  const first = list[0];
  list.sort((a, b) => a.deg - b.deg);
  data.heading ??= list.indexOf(first);
  return list;
}
