// Colour maps by nine colours each, after Matplotlib's.

const MAPS = {
  viridis: ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725"],
  error: ["fcfdbf", "fed395", "fe9f6d", "f7705c", "de4968", "b63679", "8c2981", "641a80", "3b0f70"],
  share: ["ffffd9", "edf8b1", "c7e9b4", "7fcdbb", "41b6c4", "1d91c0", "225ea8", "253494", "081d58"],
};

export function colourMap(name) {
  const stops = MAPS[name].map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)));
  return (share) => {
    const place = Math.max(0, Math.min(1, share)) * (stops.length - 1);
    const low = Math.min(stops.length - 2, Math.floor(place));
    return stops[low].map((value, k) => value + (place - low) * (stops[low + 1][k] - value));
  };
}

export const gradient = (name) => `linear-gradient(to right,${MAPS[name].map((hex) => `#${hex}`).join(",")})`;
