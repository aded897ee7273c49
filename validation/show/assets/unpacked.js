'use strict';
/** Data of a page with arrays in place of where they are in its binary part, `blob`; small
 * integers are turned into SI values. */
async function unpacked(data) {
  const packed = Uint8Array.from(atob(data.blob), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const buffer = await new Response(stream).arrayBuffer();
  const kinds = { f4: Float32Array, u4: Uint32Array, i2: Int16Array };
  const array = (at) => {
    const raw = new kinds[at.type](buffer, at.offset, at.count);
    return at.type === 'i2' ? Float32Array.from(raw, (v) => v * at.scale) : raw;
  };
  const filled = (value) => {
    if (Array.isArray(value)) return value.map(filled);
    if (value === null || typeof value !== 'object') return value;
    if ('offset' in value) return array(value);
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, filled(inner)]));
  };
  return filled(data);
}
