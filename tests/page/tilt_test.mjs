// The light of the room on a table that is tipped with the picture: however the device is held, straight down in the room
// is where the sand falls, a rotation stays one, and a device that is held as it was when it became level changes nothing
// but what it was turned by about the vertical.
import assert from "node:assert/strict";
import { downOnScreen, gravityOfScreen, tableOfRoom } from "../../models/page/tilt.mjs";

const axes = (azimuth, elevation) => {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  const away = [sa * ce, se, ca * ce], right = [ca, 0, -sa];
  return { right, away, up: [away[1] * right[2] - away[2] * right[1], away[2] * right[0] - away[0] * right[2], away[0] * right[1] - away[1] * right[0]] };
};
const close = (a, b, what) => a.forEach((x, k) => assert.ok(Math.abs(x - b[k]) < 1e-5, `${what}: ${a} and ${b}`));
const times = (m, v) => [0, 1, 2].map((i) => v[0] * m[i] + v[1] * m[3 + i] + v[2] * m[6 + i]);

let tried = 0;
for (const [azimuth, elevation] of [[0.35, 0.5], [-1, 0.1], [2.5, 1.4]])
  for (const beta of [20, 45, 70])
    for (const gamma of [-20, 0, 15])
      for (const screen of [0, 90])
        for (const yaw of [0, 1, -2]) {
          const camera = axes(azimuth, elevation), level = downOnScreen({ beta: 40, gamma: 5 }, screen), down = downOnScreen({ beta, gamma }, screen);
          const m = tableOfRoom(down, level, camera, yaw), [x, y, z] = [m.slice(0, 3), m.slice(3, 6), m.slice(6)];
          close(times(m, [0, -1, 0]), gravityOfScreen(down, level, camera).map((g) => g / 9.81), "straight down");
          close([x, y, z].map((axis) => Math.hypot(...axis)), [1, 1, 1], "lengths");
          close([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]], z, "right-handed");
          close(tableOfRoom(level, level, camera, yaw), [Math.cos(yaw), 0, Math.sin(yaw), 0, 1, 0, -Math.sin(yaw), 0, Math.cos(yaw)], "held level");
          ++tried;
        }
console.log(`${tried} ways to hold a device`);
