// Runs of a mission played back: the way over the floor, what the antennas read, how each run ended.
import { ENDS } from "./ends.js";
import { choice, css, fixed, make, Plan, svg } from "./plan.js";
import { Rose } from "./rose.js";

const KINDS = Object.keys(ENDS);

export function drive(live, data) {
  const rose = new Rose(data.azimuths_deg.map((a) => a * Math.PI / 180));
  const state = { run: 0, step: 0, playing: false, before: 0, clock: 0 };
  const run = () => data.runs[state.run];
  const count = () => run().t.values.length;

  const view = new Plan(data.plan, (context) => {
    view.walls(context);
    context.setLineDash([6, 5]);
    line(context, data.way, css("--soft"), 1.2);
    context.setLineDash([]);
    data.runs.forEach((one, index) => {
      if (index !== state.run) line(context, points(one), css(ENDS[one.end].colour), 1, 0.3);
    });
    line(context, points(run()), css("--accent"), 1.4, 0.45);
    line(context, points(run(), state.step + 1), css("--accent"), 2.6);
    view.tags(context, data.tags, run().target.values[state.step]);
    for (const one of data.runs) mark(context, one);
    robot(context);
  });

  const points = (one, most = one.x.values.length) =>
    Array.from({ length: most }, (_, k) => [one.x.values[k], one.y.values[k]]);

  const line = (context, list, colour, width, alpha = 1) => {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.globalAlpha = alpha;
    context.lineJoin = "round";
    context.beginPath();
    for (const [x, y] of list) context.lineTo(...view.at(x, y));
    context.stroke();
    context.globalAlpha = 1;
  };

  const mark = (context, one) => {
    const last = one.x.values.length - 1;
    const [x, y] = view.at(one.x.values[last], one.y.values[last]);
    context.globalAlpha = one === run() ? 1 : 0.75;
    shape(context, KINDS.indexOf(one.end), x, y, css(ENDS[one.end].colour));
    context.globalAlpha = 1;
  };

  const robot = (context) => {
    const k = state.step;
    const [x, y] = view.at(run().x.values[k], run().y.values[k]);
    const heading = run().heading.values[k];
    const r = Math.max(6, data.radius_m * view.scale);
    context.fillStyle = css("--accent");
    context.globalAlpha = 0.25;
    context.beginPath();
    context.arc(x, y, r, 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = css("--accent");
    context.lineWidth = 2;
    context.stroke();
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + 1.5 * r * Math.cos(heading), y - 1.5 * r * Math.sin(heading));
    context.stroke();
  };

  const read = make("p", { className: "value" });
  const show = () => {
    const k = state.step;
    const n = data.azimuths_deg.length;
    const list = Array.from(run().rss.values.subarray(k * n, (k + 1) * n));
    const tag = data.tags[run().target.values[k]];
    const x = run().x.values[k], y = run().y.values[k];
    const distance = tag ? Math.hypot(tag.x - x, tag.y - y) : NaN;
    const towards = tag ? Math.atan2(tag.y - y, tag.x - x) : NaN;
    const said = `${fixed(run().t.values[k], 0, "s")}: ${tag ? `towards ${tag.id}, ${fixed(distance, 2, "m")} away` : "at the end"}. ${
      run().said}`;
    rose.show(list, run().heading.values[k] - Math.PI / 2, [[towards, "#d1432b", "", "tag"]], said);
    read.textContent = said;
    scrub.value = k;
    scrub.setAttribute("aria-valuetext", fixed(run().t.values[k], 0, "s"));
    view.redraw();
  };

  const pick = choice("Run", data.runs.map((one, i) => [i, `${one.run}: ${ENDS[one.end].text}`]), (value) => {
    state.run = Number(value);
    state.step = 0;
    scrub.max = count() - 1;
    show();
  });
  const play = make("button", { textContent: "Play", type: "button" });
  const speed = choice("Speed", [[5, "5 ×"], [10, "10 ×"], [20, "20 ×"], [40, "40 ×"]], () => {});
  speed.select.value = 10;
  const scrub = make("input", { type: "range", min: 0, max: count() - 1, step: 1, value: 0 });
  scrub.setAttribute("aria-label", "Time");
  scrub.addEventListener("input", () => { state.step = Number(scrub.value); show(); });
  play.addEventListener("click", () => {
    state.playing = !state.playing;
    play.textContent = state.playing ? "Pause" : "Play";
    if (!state.playing) return;
    if (state.step >= count() - 1) state.step = 0;
    state.clock = run().t.values[state.step];
    state.before = 0;
    requestAnimationFrame(tick);
  });
  const tick = (now) => {
    if (!state.playing) return;
    state.clock += state.before ? (now - state.before) / 1000 * Number(speed.select.value) : 0;
    state.before = now;
    const before = state.step;
    while (state.step < count() - 1 && run().t.values[state.step + 1] <= state.clock) state.step += 1;
    if (state.step !== before) show();
    if (state.step >= count() - 1) {
      state.playing = false;
      play.textContent = "Play";
    } else requestAnimationFrame(tick);
  };

  const key = make("ul", { className: "key" });
  for (const [index, kind] of KINDS.entries()) {
    const number = data.runs.filter((one) => one.end === kind).length;
    if (!number) continue;
    const sign = make("canvas", { width: 28, height: 28, style: "width:14px;height:14px;vertical-align:-2px" });
    const context = sign.getContext("2d");
    context.scale(2, 2);
    shape(context, index, 7, 7, css(ENDS[kind].colour));
    key.append(make("li", {}, sign, ` ${ENDS[kind].text}: ${number} of ${data.runs.length}`));
  }
  const side = make("div", {}, rose.node, read, ...histogram(data));
  live.append(
    make("div", { className: "controls" }, pick.box, play, speed.box, make("span", { className: "grow" }, scrub)),
    make("div", { className: "stage" }, make("div", {}, view.box, key), side));
  view.canvas.setAttribute("aria-label",
    `Ways of ${data.runs.length} runs over the floor; ${key.textContent}. Use the time bar to play a run.`);
  view.canvas.addEventListener("click", (event) => {
    const [x, y] = view.place(event);
    let best = [Infinity, 0];
    data.runs.forEach((one, index) => {
      for (let k = 0; k < one.x.values.length; k += 1) {
        const d = Math.hypot(one.x.values[k] - x, one.y.values[k] - y);
        if (d < best[0]) best = [d, index];
      }
    });
    if (best[0] > 0.4) return;
    pick.select.value = best[1];
    pick.select.dispatchEvent(new Event("change"));
  });
  show();
}

// A sign of its own for each kind of end, so that no one needs the colours.
function shape(context, kind, x, y, colour) {
  context.fillStyle = colour;
  context.strokeStyle = colour;
  context.lineWidth = 2.2;
  context.beginPath();
  if (kind === 0) context.arc(x, y, 4, 0, 2 * Math.PI);
  else if (kind === 1) for (const [dx, dy] of [[0, -6], [6, 0], [0, 6], [-6, 0]]) context.lineTo(x + dx, y + dy);
  else if (kind === 2) { context.arc(x, y, 5, 0, 2 * Math.PI); context.stroke(); return; }
  else if (kind === 3) for (const [dx, dy] of [[0, -6], [6, 5], [-6, 5]]) context.lineTo(x + dx, y + dy);
  else if (kind === 4) {
    context.moveTo(x - 5, y - 5); context.lineTo(x + 5, y + 5);
    context.moveTo(x - 5, y + 5); context.lineTo(x + 5, y - 5);
    context.stroke();
    return;
  } else context.rect(x - 4.5, y - 4.5, 9, 9);
  context.fill();
}

function histogram(data) {
  const errors = data.runs.flatMap((one) => one.arrivals).filter(Number.isFinite);
  if (errors.length < 2) return [];
  const top = Math.max(...errors, 0.02);
  const bins = new Array(10).fill(0);
  for (const error of errors) bins[Math.min(9, Math.floor(10 * error / top))] += 1;
  const most = Math.max(...bins);
  const sorted = [...errors].sort((a, b) => a - b);
  const said = `Arrival errors: ${errors.length} arrivals, median ${
    fixed(100 * sorted[Math.floor(sorted.length / 2)], 1, "cm")}, greatest ${fixed(100 * top, 1, "cm")}.`;
  const picture = svg("svg", { viewBox: "0 0 220 74", role: "img", "aria-label": said });
  bins.forEach((number, k) => picture.append(svg("rect", { x: 2 + 21.6 * k, width: 19.6, rx: 1.5,
    y: 60 - 56 * number / most, height: Math.max(56 * number / most, 0.5), fill: "var(--accent)" })));
  picture.append(svg("line", { x1: 2, x2: 218, y1: 60.5, y2: 60.5, stroke: "var(--soft)" }));
  return [picture, make("div", { className: "ends" }, make("span", { textContent: "0" }),
    make("span", { textContent: fixed(100 * top, 1, "cm") })), make("p", { className: "note", textContent: said })];
}
