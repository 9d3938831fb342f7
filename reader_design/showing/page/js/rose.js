// The powers of all antennas as a rose: a wedge for each antenna, in the direction that it faces.
import { ANTENNAS, css, svg } from "./plan.js";

const SPAN_DB = 30;

export class Rose {
  constructor(azimuths) {
    this.azimuths = azimuths;
    this.node = svg("svg", { viewBox: "-110 -110 220 220", class: "rose", role: "img" });
  }

  // levels [dBm] by antenna; turn: room azimuth of the reader's own azimuth 0 [rad];
  // rays: [azimuth [rad], colour, dash, name]
  show(levels, turn, rays, said) {
    const finite = levels.filter(Number.isFinite);
    const top = Math.max(...finite);
    const half = Math.PI / levels.length * 0.92;
    const parts = [1, 2 / 3, 1 / 3].map((share) => svg("circle",
      { r: 84 * share, fill: "none", stroke: css("--line") }));
    levels.forEach((level, i) => {
      const share = Number.isFinite(level) ? Math.max(0.04, 1 + (level - top) / SPAN_DB) : 0.02;
      const middle = turn + this.azimuths[i];
      const at = (angle, radius) => `${(radius * Math.cos(angle)).toFixed(2)} ${(-radius * Math.sin(angle)).toFixed(2)}`;
      const r = 84 * share;
      parts.push(svg("path", { fill: ANTENNAS[i % 8], "fill-opacity": level === top ? 1 : 0.62,
        d: `M0 0L${at(middle - half, r)}A${r} ${r} 0 0 0 ${at(middle + half, r)}Z` }));
      const label = svg("text", { x: 97 * Math.cos(middle), y: 3.5 - 97 * Math.sin(middle),
        "text-anchor": "middle" });
      label.textContent = i + 1;
      parts.push(label);
    });
    for (const [azimuth, colour, dash] of rays) {
      if (!Number.isFinite(azimuth)) continue;
      parts.push(svg("line", { x1: 0, y1: 0, x2: 90 * Math.cos(azimuth), y2: -90 * Math.sin(azimuth),
        stroke: colour, "stroke-width": 2.6, "stroke-dasharray": dash, "stroke-linecap": "round" }));
    }
    this.node.replaceChildren(...parts);
    this.node.setAttribute("aria-label", said);
  }
}

export function vectorSum(levels, azimuths) {
  let x = 0, y = 0;
  levels.forEach((level, i) => {
    if (!Number.isFinite(level)) return;
    const power = 10 ** (level / 10);
    x += power * Math.cos(azimuths[i]);
    y += power * Math.sin(azimuths[i]);
  });
  return x === 0 && y === 0 ? NaN : Math.atan2(y, x);
}

export const wrap = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
