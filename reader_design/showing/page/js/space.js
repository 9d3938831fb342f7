// What turns in three dimensions: the room with tags, paths and ways, and the antennas' patterns.
import { pattern } from "./pattern.js";
import { room } from "./room.js";

Object.assign(globalThis.Octant.widgets, { room, pattern });
