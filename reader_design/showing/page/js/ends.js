// How a run can end, in words and colour.

export const ENDS = {
  success: { text: "every tag reached", colour: "--good" },
  "wrong place": { text: "declared reached at a wrong place", colour: "--poor" },
  "time-out": { text: "time ran out", colour: "--fair" },
  "no signal": { text: "no signal", colour: "--fair" },
  collision: { text: "ran into something", colour: "--poor" },
  stuck: { text: "stuck", colour: "--poor" },
  "left the room": { text: "left the room", colour: "--poor" },
};
