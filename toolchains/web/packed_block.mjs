// The block of packed grains for engines whose textures of three dimensions have one level: all levels in one (packed.glsl).
const k_texels = 64;
export const k_packed_sides = [75, 66, 100];

// Where a level lies, within its border.
const placeOf = (side) =>
  side === k_texels ? [1, 1, 1] : [63 + 2 * Math.log2(k_texels / side) - 2 * side, 1, k_texels + 3];

// `which` of the two textures of sandBlock's bytes.
function packed(block, which) {
  const [wide, high, deep] = k_packed_sides;
  const texels = new Uint32Array(wide * high * deep);
  let from = 0;
  for (let side = k_texels; side >= 1; side >>= 1) {
    const bytes = 4 * side ** 3;
    const level = new Uint32Array(block.slice(from + which * bytes, from + (which + 1) * bytes).buffer);
    const [x0, y0, z0] = placeOf(side);
    const within = (i) => (i + side) % side;
    for (let z = -1; z <= side; ++z)
      for (let y = -1; y <= side; ++y)
        for (let x = -1; x <= side; ++x)
          texels[x0 + x + wide * (y0 + y + high * (z0 + z))] = level[within(x) + side * (within(y) + side * within(z))];
    from += 2 * bytes;
  }
  return new Uint8Array(texels.buffer);
}

export const packedBlock = (block) => ({ grains: packed(block, 0), facets: packed(block, 1) });
