// The block of packed grains at a place in sides of it, and at a level; and the mean of all.
vec4 block_level(sampler3D image, vec3 at, float level) { return textureLod(image, at, level); }
vec4 block_mean(sampler3D image) { return textureLod(image, vec3(0), 6.0); }
