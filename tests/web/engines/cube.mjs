// How far the worst face of a white cube is from what a room's light gives it, in which half comes from one lamp. `shown`
// gives the red that the engine shows on the face of a normal of the stage's world.
export async function worst(engine, shown) {
  const { stage } = engine;
  const { fadedLight: light, roomLight } = stage;
  const before = stage.sand.make("sandglass_room_light", light);
  stage.see({ data: new Uint8Array(4 * 16 * 16), width: 16, height: 16 }); // after an image the light is told anew in every frame
  light.set(before);
  const at = (k, [x, y, z], sh) =>
    sh[k] +
    sh[3 + k] * y +
    sh[6 + k] * z +
    sh[9 + k] * x +
    sh[12 + k] * x * y +
    sh[15 + k] * y * z +
    sh[18 + k] * (3 * z * z - 1) +
    sh[21 + k] * x * z +
    sh[24 + k] * (x * x - y * y);
  light.main_share = 0.5;
  light.main_direction.set([0.5, 0.7, 0.5099]);
  light.main_colour.fill(1);
  roomLight.set(light);
  let most = 0;
  for (const n of [
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
    [0, 0, 1],
    [0, 0, -1],
  ]) {
    engine.update(0);
    const { toLight, facing, ambient } = engine.drawn.light;
    const expected =
      Math.max(0, at(0, n, ambient)) +
      (facing[0] *
        Math.max(
          0,
          n.reduce((sum, c, k) => sum + c * toLight[k], 0),
        )) /
        Math.PI;
    most = Math.max(most, Math.abs((await shown(n)) / expected - 1));
  }
  return most;
}
