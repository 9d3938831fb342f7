// The room: walls that open towards the viewer, tags, the robot's start and ways, paths of a tag.
import { BufferGeometry, CanvasTexture, Color, DoubleSide, Float32BufferAttribute, FrontSide, Group,
  Line, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Raycaster, SphereGeometry, Sprite,
  SpriteMaterial, SRGBColorSpace, Vector2, Vector3 } from "three";
import { colourMap } from "./colours.js";
import { ENDS } from "./ends.js";
import { choice, fixed, make, TAG } from "./plan.js";
import { themed, View3d } from "./view3d.js";

// On a floor that is as light by day as by night.
const WAYS = { "--good": "#17734a", "--fair": "#8a5200", "--poor": "#ad2318" };

const geometry = (values) => {
  const made = new BufferGeometry();
  made.setAttribute("position", new Float32BufferAttribute(values, 3));
  made.computeVertexNormals();
  return made;
};

export function room(live, data) {
  const [low, high] = data.bounds;
  const centre = new Vector3(...low.map((value, i) => (value + high[i]) / 2));
  const reach = new Vector3(...high).sub(new Vector3(...low)).length() / 2;
  const view = new View3d(centre, reach);
  for (const part of data.parts) {
    view.scene.add(new Mesh(geometry(part.triangles.values), new MeshLambertMaterial({
      color: new Color(part.colour), transparent: part.opacity < 1, opacity: part.opacity,
      side: part.wall ? FrontSide : DoubleSide, depthWrite: part.opacity >= 1 })));
  }
  const edges = new LineSegments(geometry(data.edges.values), new LineBasicMaterial({ transparent: true, opacity: 0.45 }));
  view.scene.add(edges);
  if (data.reader) view.scene.add(new Mesh(geometry(data.reader.values), new MeshLambertMaterial({
    color: new Color("#44505c"), side: DoubleSide })));

  const marks = data.tags.map((tag, index) => {
    const ball = new Mesh(new SphereGeometry(reach / 55, 20, 12), new MeshLambertMaterial({ color: new Color(TAG) }));
    ball.position.set(tag.x, tag.y, tag.z);
    ball.userData.index = index;
    view.scene.add(ball, label(tag.id, ball.position, reach));
    const drop = new Line(geometry([tag.x, tag.y, tag.z, tag.x, tag.y, low[2]]), new LineBasicMaterial({
      color: new Color(TAG), transparent: true, opacity: 0.5 }));
    view.scene.add(drop);
    return ball;
  });
  if (data.start) view.scene.add(label("start", new Vector3(...data.start), reach));

  const ways = new Group();
  (data.ways ?? []).forEach((way, index) => {
    const points = [];
    for (let k = 0; k < way.points.shape[0]; k += 1)
      points.push(way.points.values[2 * k], way.points.values[2 * k + 1], data.way_z);
    const line = new Line(geometry(points), new LineBasicMaterial({ transparent: true, opacity: index ? 0.4 : 1 }));
    line.material.color = new Color(index ? WAYS[ENDS[way.end].colour] : "#1d5aa6");
    ways.add(line);
  });
  view.scene.add(ways);
  view.before = () => {
    edges.material.color = themed("--wall");
  };

  const paths = new Group();
  view.scene.add(paths);
  const read = make("p", { className: "note" });
  const showPaths = (index) => {
    paths.clear();
    pick.select.value = index;
    const found = index < 0 ? [] : data.paths[index] ?? [];
    const top = Math.max(...found.map((path) => path.gain_db));
    const colour = colourMap("viridis");
    for (const path of found) {
      const share = 0.12 + 0.78 * (1 - (top - path.gain_db) / 30);
      paths.add(new Line(geometry(path.points.flat()), new LineBasicMaterial({
        color: new Color(...colour(Math.max(0, share)).map((v) => v / 255)) })));
    }
    marks.forEach((ball, i) => ball.scale.setScalar(i === index ? 1.6 : 1));
    read.textContent = index < 0 ? "Click a tag, or choose it, to see the paths from it to the robot's start."
      : found.length ? `Tag ${data.tags[index].id}: the ${found.length} strongest paths to the start, from ${
        fixed(top, 1, "dB")} (yellow) down to ${fixed(found.at(-1).gain_db, 1, "dB")}; ${
        found[0].bends ? `the strongest has ${found[0].bends} bend${found[0].bends > 1 ? "s" : ""}` : "the strongest is the direct ray"}.`
        : `Tag ${data.tags[index].id}: no path reaches the robot's start.`;
    view.canvas.setAttribute("aria-label", `${data.said} ${read.textContent}`);
    view.redraw();
  };
  const pick = choice("Paths of tag", [[-1, "none"], ...data.tags.map((tag, i) => [i, tag.id])],
    (value) => showPaths(Number(value)));
  const way = make("button", { type: "button", textContent: "Ways" });
  way.setAttribute("aria-pressed", "true");
  way.addEventListener("click", () => {
    ways.visible = !ways.visible;
    way.setAttribute("aria-pressed", String(ways.visible));
    view.redraw();
  });
  let pressed = null;
  view.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  view.canvas.addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const box = view.canvas.getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(2 * (event.clientX - box.left) / box.width - 1,
      1 - 2 * (event.clientY - box.top) / box.height), view.camera);
    let best = [reach / 18, -1];
    marks.forEach((ball, index) => {
      const distance = ray.ray.distanceToPoint(ball.position);
      if (distance < best[0]) best = [distance, index];
    });
    if (best[1] >= 0) showPaths(best[1]);
  });
  const controls = make("div", { className: "controls" }, pick.box);
  if (ways.children.length) controls.append(way);
  controls.append(...view.buttons());
  const key = make("ul", { className: "key" }, ...data.materials.map(([name, colour]) =>
    make("li", {}, make("i", { style: `background:${colour}` }), name)));
  live.append(controls, view.box, read, key);
  showPaths(-1);
  view.resize();
}

function label(text, place, reach) {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  context.font = "600 40px system-ui, sans-serif";
  canvas.width = context.measureText(text).width + 24;
  canvas.height = 56;
  context.font = "600 40px system-ui, sans-serif";
  context.lineWidth = 8;
  context.strokeStyle = "#ffffffe0";
  context.strokeText(text, 12, 42);
  context.fillStyle = "#14181d";
  context.fillText(text, 12, 42);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false }));
  const height = reach / 16;
  sprite.scale.set(height * canvas.width / canvas.height, height, 1);
  sprite.position.copy(place).add(new Vector3(0, 0, height));
  sprite.renderOrder = 5;
  return sprite;
}
