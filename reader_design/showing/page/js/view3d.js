// A view that turns: drawn when something changes, with z up.
import { AmbientLight, Color, DirectionalLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { css, make } from "./plan.js";

export class View3d {
  constructor(centre, reach, { azimuth = -60, elevation = 35, shape = 0.62, far = 3.4 } = {}) {
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, reach / 50, reach * 30);
    this.camera.up.set(0, 0, 1);
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.style.touchAction = "none";
    this.box = make("div", { className: "canvas" }, this.canvas);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.target.copy(centre);
    this.controls.enableZoom = false;
    this.controls.addEventListener("change", () => this.redraw());
    this.shape = shape;
    this.home = { azimuth, elevation, distance: reach * far };
    this.look(azimuth, elevation);
    this.scene.add(new AmbientLight(0xffffff, 1.9));
    for (const [x, y, z, power] of [[0.4, -0.6, 1.2, 1.5], [-0.8, 0.5, 0.3, 0.5]]) {
      const light = new DirectionalLight(0xffffff, power);
      light.position.set(x, y, z);
      this.scene.add(light);
    }
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    addEventListener("octant-theme", () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  look(azimuth, elevation) {
    const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
    const away = new Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    this.camera.position.copy(this.controls.target).addScaledVector(away, this.home.distance);
    this.controls.update();
    this.redraw();
  }

  key(event) {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const zoom = { "+": 0.9, "-": 1.1 }[event.key];
    const away = this.camera.position.clone().sub(this.controls.target);
    if (turn) {
      event.preventDefault();
      const azimuth = Math.atan2(away.y, away.x) * 180 / Math.PI + 10 * turn[0];
      const elevation = Math.asin(away.z / away.length()) * 180 / Math.PI + 8 * turn[1];
      this.look(azimuth, Math.max(-85, Math.min(85, elevation)));
    } else if (zoom) this.zoom(zoom);
  }

  zoom(by) {
    this.home.distance *= by;
    this.camera.position.sub(this.controls.target).multiplyScalar(by).add(this.controls.target);
    this.controls.update();
    this.redraw();
  }

  buttons() {
    const button = (text, title, done) => {
      const one = make("button", { type: "button", textContent: text, title });
      one.addEventListener("click", done);
      return one;
    };
    return [button("From above", "Look from above", () => this.look(-90, 89)),
      button("Turn back", "The first view", () => this.look(this.home.azimuth, this.home.elevation)),
      button("+", "Nearer", () => this.zoom(0.85)), button("\u2212", "Farther", () => this.zoom(1.18))];
  }

  resize() {
    const width = this.box.clientWidth;
    if (!width) return;
    const height = Math.round(Math.min(width * this.shape, 560));
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    this.canvas.style.height = `${height}px`;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.before?.();
      this.renderer.render(this.scene, this.camera);
    });
  }
}

export const themed = (name) => new Color(css(name));
