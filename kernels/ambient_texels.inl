// An ambient shadow from its components. Texels of one component lie together, so that a group of k_bytes neighbouring
// texels stays in registers while the components stream by, two at a time. Their products are exact and so are the
// sums, so every set gives the same bits in any order.

static void ambient_texels(const AmbientComponents* components, uint32_t begin, uint32_t end, uint8_t* visibility) {
  const AmbientComponents& all = *components;
  for (uint32_t t = begin; t < end; t += k_bytes) {
    Mixture sums = mixture_of(1 << (all.shift - 1));
    const int8_t* texels = all.texels + t;
    for (uint32_t k = 0; k < all.count; k += 2, texels += 2 * all.size)
      mix(&sums, texels, texels + all.size, all.weights[k], all.weights[k + 1]);
    store_bytes(visibility + t, visibility_of(sums, all.shift));
  }
}
