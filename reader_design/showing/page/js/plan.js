// A room seen from above on a canvas: scale, walls, objects and tags.

export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export const ANTENNAS = ["#4b3fb5", "#4aa8d8", "#1f9152", "#d39a1d", "#d0607a", "#aa4499", "#2fa093",
  "#8a8a8a"];
export const TAG = "#d1432b";

export function make(name, attributes = {}, ...children) {
  const { style, ...rest } = attributes;
  const made = Object.assign(document.createElement(name), rest);
  if (style) made.style.cssText = style;
  made.append(...children);
  return made;
}

export function svg(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

export function choice(label, options, changed) {
  const select = make("select");
  options.forEach(([value, text]) => select.append(make("option", { value, textContent: text })));
  select.addEventListener("change", () => changed(select.value));
  return { box: make("label", {}, label, select), select };
}

export function slider(label, { min, max, step, value }, shown, changed) {
  const input = make("input", { type: "range", min, max, step, value });
  const output = make("output");
  const say = () => { output.textContent = shown(Number(input.value)); };
  input.addEventListener("input", () => { say(); changed(Number(input.value)); });
  input.setAttribute("aria-label", label);
  say();
  return { box: make("label", {}, label, input, output), input, say };
}

export const minus = (text) => text.replace(/-/g, "\u2212");
export const fixed = (value, digits, unit) =>
  `${minus(value.toFixed(digits))}${unit === "°" ? "" : "\u202f"}${unit}`;

export class Plan {
  constructor(plan, draw) {
    this.plan = plan;
    this.canvas = make("canvas", { tabIndex: 0 });
    this.box = make("div", { className: "canvas" }, this.canvas);
    this.draw = draw;
    const [[x0, y0], [x1, y1]] = plan.bounds;
    const pad = 0.03 * Math.max(x1 - x0, y1 - y0);
    this.bounds = [x0 - pad, y0 - pad, x1 + pad, y1 + pad];
    new ResizeObserver(() => this.redraw()).observe(this.box);
    addEventListener("octant-theme", () => this.redraw());
  }

  redraw() {
    const width = this.box.clientWidth;
    if (!width) return;
    const [x0, y0, x1, y1] = this.bounds;
    const ratio = devicePixelRatio || 1;
    const height = Math.min(width * (y1 - y0) / (x1 - x0), 620);
    this.scale = Math.min(width / (x1 - x0), height / (y1 - y0));
    this.left = (width - this.scale * (x1 - x0)) / 2;
    this.height = height;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
      this.canvas.style.height = `${height}px`;
    }
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    this.draw(context);
  }

  at(x, y) {
    return [this.left + (x - this.bounds[0]) * this.scale, this.height - (y - this.bounds[1]) * this.scale];
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left - this.left) / this.scale + this.bounds[0],
      (this.height - event.clientY + box.top) / this.scale + this.bounds[1]];
  }

  walls(context) {
    context.fillStyle = css("--soft");
    context.globalAlpha = 0.55;
    context.beginPath();
    for (const solid of this.plan.solids) {
      const corners = [0, 2, 4].map((k) => this.at(solid[k], solid[k + 1]));
      const [a, b, c] = corners;
      const turned = (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]);
      (turned ? corners.reverse() : corners).forEach((p, k) => (k ? context.lineTo(...p) : context.moveTo(...p)));
      context.closePath();
    }
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = css("--wall");
    context.lineWidth = 2;
    context.lineCap = "round";
    context.beginPath();
    for (const [xa, ya, xb, yb] of this.plan.cuts) {
      context.moveTo(...this.at(xa, ya));
      context.lineTo(...this.at(xb, yb));
    }
    context.stroke();
  }

  tags(context, tags, chosen) {
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    tags.forEach((tag, index) => {
      const [x, y] = this.at(tag.x, tag.y);
      const size = index === chosen ? 7 : 5;
      for (const [colour, width] of [[css("--page"), 5], [TAG, 2.4]]) {
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.beginPath();
        context.moveTo(x - size, y - size);
        context.lineTo(x + size, y + size);
        context.moveTo(x - size, y + size);
        context.lineTo(x + size, y - size);
        context.stroke();
      }
      const side = y < 24 ? 20 : -11;
      context.lineWidth = 3.5;
      context.strokeStyle = css("--page");
      context.strokeText(tag.id, x, y + side);
      context.fillStyle = css("--ink");
      context.fillText(tag.id, x, y + side);
    });
  }
}
