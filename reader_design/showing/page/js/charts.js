// Designs side by side: any two qualities against each other, all of them in parallel, and the table.
import { ParallelChart, ScatterChart } from "echarts/charts";
import { GridComponent, ParallelComponent, TooltipComponent } from "echarts/components";
import { init, use } from "echarts/core";
import { SVGRenderer } from "echarts/renderers";
import { choice, css, make, minus } from "./plan.js";

use([ParallelChart, ScatterChart, GridComponent, ParallelComponent, TooltipComponent, SVGRenderer]);

const symbols = (text) => text.replace(/\br_a\b/g, "r\u2090").replace(/\bh_p\b/g, "h\u209a");
const broken = (text) => text.split(" ").reduce((lines, word) => {
  const last = lines.at(-1);
  if (last && last.length + word.length < 15) lines[lines.length - 1] = `${last} ${word}`;
  else lines.push(word);
  return lines;
}, []).join("\n");
const shown = (value) => (value === null ? "–" : minus(String(Number(value.toPrecision(3)))));

function designs(live, data, box) {
  const { columns, rows } = data;
  const state = { x: data.x, y: data.y, picked: new Set(), hidden: new Set() };
  const table = box.closest("section").querySelector(".table table");
  const lines = table ? [...table.tBodies[0].rows] : [];
  const scatter = make("div", { className: "chart" });
  const parallel = make("div", { className: "chart" });
  const compared = make("div");
  const names = columns.map((column, i) => [i, column]);
  const across = choice("Across", names, (value) => { state.x = Number(value); draw(); });
  const up = choice("Up", names, (value) => { state.y = Number(value); draw(); });
  across.select.value = state.x;
  up.select.value = state.y;
  const clear = make("button", { type: "button", textContent: "Clear choice" });
  clear.addEventListener("click", () => { state.picked.clear(); draw(); });
  live.append(make("div", { className: "controls" }, across.box, up.box, clear), scatter, parallel, compared);
  const left = init(scatter, null, { renderer: "svg" });
  const right = init(parallel, null, { renderer: "svg" });

  const looks = () => ({ color: css("--soft"), line: css("--line"), ink: css("--ink") });
  const colour = (index) => (state.picked.has(index) ? css("--poor")
    : rows[index].front ? css("--accent") : css("--soft"));

  function draw() {
    const { color, line, ink } = looks();
    const axis = (name) => ({ type: "value", name, nameLocation: "middle", nameGap: 34, scale: true,
      nameTextStyle: { color }, axisLabel: { color, formatter: shown }, splitLine: { lineStyle: { color: line } },
      axisLine: { lineStyle: { color } } });
    left.setOption({
      animation: false, textStyle: { fontFamily: "system-ui, sans-serif" },
      grid: { left: 64, right: 24, top: 18, bottom: 56 },
      tooltip: { trigger: "item", confine: true, formatter: (one) => tip(one.dataIndex, [state.x, state.y]) },
      xAxis: axis(columns[state.x]), yAxis: { ...axis(columns[state.y]), nameGap: 46 },
      series: [{ type: "scatter", data: rows.map((row, i) => ({
        value: [row.values[state.x], row.values[state.y]],
        symbol: row.front ? "diamond" : "circle", symbolSize: state.picked.has(i) ? 17 : row.front ? 13 : 9,
        itemStyle: { color: colour(i), opacity: state.hidden.has(i) ? 0.12 : 0.9 },
        label: { show: rows.length <= 6 || state.picked.has(i), formatter: symbols(row.label), position: row.values[state.x] > middle(state.x) ? "left" : "right",
          color: ink, fontSize: 11 } })),
        labelLayout: { hideOverlap: true, moveOverlap: "shiftY" } }],
    }, true);
    right.setOption({
      animation: false, textStyle: { fontFamily: "system-ui, sans-serif" },
      tooltip: { confine: true, formatter: (one) => tip(one.dataIndex, data.axes) },
      parallel: { left: 64, right: 64, top: 66, bottom: 24,
        parallelAxisDefault: { nameTextStyle: { color, fontSize: 11, lineHeight: 13 },
          nameGap: 12, axisLabel: { color, formatter: shown }, axisLine: { lineStyle: { color: line } },
          axisTick: { show: false }, scale: true, realtime: true } },
      parallelAxis: data.axes.map((dim, i) => ({ dim: i, name: broken(columns[dim]) })),
      series: [{ type: "parallel", smooth: false, inactiveOpacity: 0.06, activeOpacity: 1,
        data: rows.map((row, i) => ({ value: data.axes.map((dim) => row.values[dim]),
          lineStyle: { color: colour(i), width: state.picked.has(i) ? 3 : 1.3,
            opacity: state.picked.has(i) || rows[i].front ? 0.95 : 0.5 } })) }],
    }, true);
    lines.forEach((row, i) => row.classList.toggle("picked", state.picked.has(i)));
    compare();
  }

  const middle = (dim) => {
    const values = rows.map((row) => row.values[dim]).filter((value) => value !== null);
    return (Math.min(...values) + Math.max(...values)) / 2;
  };
  const tip = (index, dims) => `<b>${escape(symbols(rows[index].label))}</b>${dims.map((dim) =>
    `<br>${escape(columns[dim])}: ${shown(rows[index].values[dim])}`).join("")}`;

  function compare() {
    compared.replaceChildren();
    const chosen = [...state.picked];
    if (chosen.length < 2) {
      compared.append(make("p", { className: "note", textContent:
        "Choose two designs, here or in the table, to compare them. Diamonds are on the Pareto front. Drag along an axis of the lower plot to keep a range." }));
      return;
    }
    const head = make("tr", {}, make("th", { textContent: "quality" }),
      ...chosen.map((i) => make("th", { textContent: symbols(rows[i].label) })));
    const body = make("tbody");
    columns.forEach((column, k) => body.append(make("tr", {}, make("th", { textContent: column }),
      ...chosen.map((i) => make("td", { textContent: shown(rows[i].values[k]) })))));
    compared.append(make("div", { className: "scroll", tabIndex: 0 },
      make("table", { className: "compared" }, make("thead", {}, head), body)));
  }

  const pick = (index) => {
    if (state.picked.has(index)) state.picked.delete(index);
    else state.picked.add(index);
    draw();
  };
  left.on("click", (one) => pick(one.dataIndex));
  right.on("click", (one) => pick(one.dataIndex));
  right.on("axisareaselected", () => {
    const active = new Set(right.getModel().getSeries()[0].getRawIndicesByActiveState("active"));
    const limited = right.getModel().getComponent("parallel") && active.size
      ? active : new Set(rows.map((_, i) => i));
    state.hidden = new Set(rows.map((_, i) => i).filter((i) => !limited.has(i)));
    lines.forEach((row, i) => { row.hidden = state.hidden.has(i); });
  });
  lines.forEach((row, i) => {
    row.addEventListener("click", () => pick(i));
    row.tabIndex = 0;
    row.addEventListener("keydown", (event) => { if (event.key === "Enter") pick(i); });
  });
  addEventListener("octant-theme", draw);
  new ResizeObserver(() => { left.resize(); right.resize(); }).observe(live);
  draw();
}

const escape = (text) => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

globalThis.Octant.widgets.designs = designs;
