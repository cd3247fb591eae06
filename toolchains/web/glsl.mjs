// sandglass/glsl: the sand kit's GLSL, and what a renderer sets for it and for surfaces that receive shadows, from what
// Stage.frame gives. `receive` declares vec2 sandglass_left(vec3 world): what is left of the main light and of the rest.
import { k_kit } from "./kit.mjs";

export { k_kit as kit } from "./kit.mjs";
export const receive = k_kit.receive;
export const byDepth = `${k_kit.receive}${k_kit.depth}`; // float sandglass_left_by_depth(vec2 at, vec3 eye, vec3 ray)
export const receivers = ["pile", "shadow", "occlusion", "sky"]; // textures of frame(), of the same names behind sandglass_

// Values of the vectors in `receive`.
export const receiverValues = (drawn) => ({
  sandglass_pile_box: drawn.pileBox,
  sandglass_shadow_box: drawn.shadowBox,
  sandglass_occlusion_box: drawn.occlusionBox,
  sandglass_numbers: [drawn.pileOpacity, drawn.shadowOpacity, drawn.skyKnown, drawn.floor],
  sandglass_slide: drawn.slide,
  sandglass_layers: [...drawn.layers, 0, 0],
});

const k_near_floor = 0.05; // metres: what depth shows so near the floor lies on it

// Of sandglass_depth_numbers, in `byDepth`.
export function depthNumbers({ light: { toLight, facing, ambient }, layers: [number, rows] }) {
  const sum = (of) => [0, 1, 2].reduce((all, colour) => all + Math.max(0, of(colour)), 0);
  const sun = sum((c) => (facing[c] / Math.PI) * toLight[1]);
  const room = sum((c) => ambient[c] + ambient[3 + c] - ambient[18 + c] - ambient[24 + c]);
  const height = rows > 0 ? (number - 1) / rows : 0;
  return [sun / Math.max(sun + room, 1e-6), Math.max(height, k_near_floor), 0, 0];
}

// Values of the kit's uniforms for light and shadows (uniforms.glsl).
export const kitValues = (drawn) => ({
  to_light: drawn.light.toLight,
  sun: drawn.light.facing.map((x) => x / Math.PI),
  ambient: drawn.light.ambient,
  below: drawn.light.floor,
  table_of_room: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  pile_box: drawn.pileBox,
  shadow_box: drawn.shadowBox,
  shadow_layers: [...drawn.layers, drawn.slide[2]],
  occlusion_box: drawn.occlusionBox,
  on_plane: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -drawn.floor, 0, 1],
  pile_opacity: drawn.pileOpacity,
  shadow_opacity: drawn.shadowOpacity,
  sky_known: drawn.skyKnown,
});
