// An antenna's pattern as a solid that turns, with cuts through it.
import { BufferGeometry, DoubleSide, Float32BufferAttribute, Line, LineBasicMaterial, Mesh, MeshBasicMaterial,
  Vector3 } from "three";
import { colourMap, gradient } from "./colours.js";
import { ANTENNAS, choice, css, fixed, make, slider, svg } from "./plan.js";
import { themed, View3d } from "./view3d.js";

const SPAN_DB = 30;

export function pattern(live, data) {
  const [n, rows, columns] = data.gain_dbi.shape;
  const gains = data.gain_dbi.values;
  const theta = (i) => Math.PI * i / (rows - 1), phi = (j) => 2 * Math.PI * j / columns;
  const top = gains.reduce((a, b) => Math.max(a, b), -Infinity);
  const gain = (antenna, i, j) => gains[(antenna * rows + i) * columns + (j % columns)];
  const state = { antenna: 0, row: Math.round(data.theta_deg / 180 * (rows - 1)) };
  const view = new View3d(new Vector3(0, 0, 0), 1.12, { azimuth: -52, elevation: 24, shape: 0.78, far: 3.5 });
  const solid = new BufferGeometry();
  const faces = [];
  for (let i = 0; i < rows - 1; i += 1) for (let j = 0; j < columns; j += 1) {
    const a = i * (columns + 1) + j, b = a + columns + 1;
    faces.push(a, b, a + 1, a + 1, b, b + 1);
  }
  solid.setIndex(faces);
  view.scene.add(new Mesh(solid, new MeshBasicMaterial({ vertexColors: true, side: DoubleSide })));
  const ring = new Line(new BufferGeometry(), new LineBasicMaterial());
  view.scene.add(ring);
  const axes = [[1.1, 0, 0], [0, 1.1, 0], [0, 0, 1.1]].map((end) => {
    const line = new BufferGeometry();
    line.setAttribute("position", new Float32BufferAttribute([0, 0, 0, ...end], 3));
    const made = new Line(line, new LineBasicMaterial());
    view.scene.add(made);
    return made;
  });
  view.before = () => {
    for (const one of axes) one.material.color = themed("--soft");
    ring.material.color = themed("--ink");
  };
  const radius = (value) => Math.max(0, 1 + (value - top) / SPAN_DB);
  const point = (value, i, j) => [radius(value) * Math.sin(theta(i)) * Math.cos(phi(j)),
    radius(value) * Math.sin(theta(i)) * Math.sin(phi(j)), radius(value) * Math.cos(theta(i))];

  const cut = svg("svg", { viewBox: "-118 -118 236 236", class: "rose", role: "img" });
  const read = make("p", { className: "note" });
  const showSolid = () => {
    const colour = colourMap("viridis");
    const places = [], colours = [];
    for (let i = 0; i < rows; i += 1) for (let j = 0; j <= columns; j += 1) {
      const value = gain(state.antenna, i, j);
      places.push(...point(value, i, j));
      colours.push(...colour(radius(value)).map((v) => (v / 255) ** 2.2));
    }
    solid.setAttribute("position", new Float32BufferAttribute(places, 3));
    solid.setAttribute("color", new Float32BufferAttribute(colours, 3));
    solid.computeBoundingSphere();
  };
  const showCut = () => {
    const line = [];
    for (let j = 0; j <= columns; j += 1) line.push(...point(gain(state.antenna, state.row, j) + 0.1, state.row, j));
    ring.geometry.setAttribute("position", new Float32BufferAttribute(line, 3));
    const parts = [];
    for (const share of [1 / 3, 2 / 3, 1]) {
      parts.push(svg("circle", { r: 96 * share, fill: "none", stroke: css("--line") }));
      const text = svg("text", { x: 3, y: -96 * share + 10 });
      text.textContent = fixed(top - SPAN_DB * (1 - share), 0, "dBi");
      parts.push(text);
    }
    for (let antenna = 0; antenna < n; antenna += 1) {
      const points = [];
      for (let j = 0; j <= columns; j += 1) {
        const r = 96 * radius(gain(antenna, state.row, j));
        points.push(`${(r * Math.cos(phi(j))).toFixed(1)},${(-r * Math.sin(phi(j))).toFixed(1)}`);
      }
      const own = antenna === state.antenna;
      parts.push(svg("polyline", { points: points.join(" "), fill: "none", stroke: ANTENNAS[antenna % 8],
        "stroke-width": own ? 3 : 1.1, opacity: own ? 1 : 0.7 }));
    }
    data.azimuths_deg.forEach((azimuth, antenna) => {
      const a = azimuth * Math.PI / 180;
      const text = svg("text", { x: 108 * Math.cos(a), y: 3.5 - 108 * Math.sin(a), "text-anchor": "middle" });
      text.textContent = antenna + 1;
      parts.push(text);
    });
    cut.replaceChildren(...parts);
    let best = [-Infinity, 0];
    for (let j = 0; j < columns; j += 1) {
      const value = gain(state.antenna, state.row, j);
      if (value > best[0]) best = [value, j];
    }
    read.textContent = `Antenna ${state.antenna + 1}, ${fixed(90 - 180 * state.row / (rows - 1), 0, "°")} above the horizon: greatest gain ${
      fixed(best[0], 1, "dBi")} at azimuth ${fixed(360 * best[1] / columns, 0, "°")} (antenna ${state.antenna + 1} stands at ${
      fixed(data.azimuths_deg[state.antenna], 0, "°")}).`;
    cut.setAttribute("aria-label", read.textContent);
    view.canvas.setAttribute("aria-label", `Realised gain as a solid. ${read.textContent}`);
    view.redraw();
  };
  const pick = choice("Antenna", data.azimuths_deg.map((_, i) => [i, `${i + 1}`]), (value) => {
    state.antenna = Number(value);
    showSolid();
    showCut();
  });
  const tilt = slider("Cut at elevation", { min: 0, max: rows - 1, step: 1, value: rows - 1 - state.row },
    (value) => fixed(180 * value / (rows - 1) - 90, 0, "°"), (value) => {
      state.row = rows - 1 - value;
      showCut();
    });
  const bar = make("div", { className: "bar", style: `background:${gradient("viridis")}` });
  const ends = make("div", { className: "ends" }, make("span", { textContent: fixed(top - SPAN_DB, 0, "dBi") }),
    make("span", { textContent: fixed(top, 1, "dBi") }));
  live.append(make("div", { className: "controls" }, pick.box, tilt.box, ...view.buttons()),
    make("div", { className: "stage" }, view.box, make("div", {}, cut, read, bar, ends)));
  showSolid();
  showCut();
  view.resize();
  addEventListener("octant-theme", showCut);
}
