// Arrays that were rounded to equal steps and deflated (packing.py) become arrays of numbers again.

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(plain).arrayBuffer();
}

async function unpack(one) {
  const buffer = await inflate(one.data);
  const whole = one.bytes === 1 ? new Uint8Array(buffer) : new Uint16Array(buffer);
  const values = new Float32Array(whole.length);
  for (let i = 0; i < whole.length; i += 1)
    values[i] = whole[i] === one.none ? NaN : one.low + one.step * whole[i];
  return { shape: one.shape, values };
}

export async function unpackAll(data) {
  if (Array.isArray(data)) return Promise.all(data.map(unpackAll));
  if (data === null || typeof data !== "object") return data;
  if ("data" in data && "step" in data) return unpack(data);
  const entries = await Promise.all(
    Object.entries(data).map(async ([name, value]) => [name, await unpackAll(value)]));
  return Object.fromEntries(entries);
}
