// sandglass/glsl: the sand kit's GLSL, and what a renderer sets for it and for surfaces that receive shadows, from what
// Stage.frame gives. `receive` declares vec2 sandglass_left(vec3 world): what is left of the main light and of the rest.
import { k_kit } from "./kit.mjs";

export { k_kit as kit } from "./kit.mjs";
export const receive = k_kit.receive;
export const receivers = ["pile", "shadow", "occlusion", "sky"]; // textures of frame(), of the same names behind sandglass_

// Values of the vectors in `receive`.
export const receiverValues = ({
  light,
  pileBox,
  shadowBox,
  occlusionBox,
  pileOpacity,
  shadowOpacity,
  skyKnown,
  floor,
}) => ({
  sandglass_pile_box: pileBox,
  sandglass_shadow_box: shadowBox,
  sandglass_occlusion_box: occlusionBox,
  sandglass_numbers: [pileOpacity, shadowOpacity, skyKnown, floor],
  sandglass_to_light: [...light.toLight, 0],
});

// Values of the kit's uniforms for light and shadows (uniforms.glsl).
export const kitValues = ({
  light,
  pileBox,
  shadowBox,
  occlusionBox,
  pileOpacity,
  shadowOpacity,
  skyKnown,
  floor,
}) => ({
  to_light: light.toLight,
  sun: light.facing.map((x) => x / Math.PI),
  ambient: light.ambient,
  below: light.floor,
  table_of_room: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  pile_box: pileBox,
  shadow_box: shadowBox,
  occlusion_box: occlusionBox,
  on_plane: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -floor, 0, 1],
  pile_opacity: pileOpacity,
  shadow_opacity: shadowOpacity,
  sky_known: skyKnown,
});
