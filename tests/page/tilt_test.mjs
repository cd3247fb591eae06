// The light of the room on a table that is tipped with the picture: however the device is held, straight down in the room
// is where the sand falls, a rotation stays one, and a device that is held as it was when it became level changes nothing
// but what it was turned by about the vertical.
import assert from "node:assert/strict";
import { downOnScreen, gravityOfScreen, tableOfRoom, cellsOfTable } from "../../models/page/tilt.mjs";

const axes = (azimuth, elevation) => {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  const away = [sa * ce, se, ca * ce];
  const right = [ca, 0, -sa];
  return {
    right,
    away,
    up: [
      away[1] * right[2] - away[2] * right[1],
      away[2] * right[0] - away[0] * right[2],
      away[0] * right[1] - away[1] * right[0],
    ],
  };
};
const close = (a, b, what) => a.forEach((x, k) => assert.ok(Math.abs(x - b[k]) < 1e-5, `${what}: ${a} and ${b}`));
const times = (m, v) => [0, 1, 2].map((i) => v[0] * m[i] + v[1] * m[3 + i] + v[2] * m[6 + i]);

let tried = 0;
for (const [azimuth, elevation] of [
  [0.35, 0.5],
  [-1, 0.1],
  [2.5, 1.4],
])
  for (const beta of [20, 45, 70])
    for (const gamma of [-20, 0, 15])
      for (const screen of [0, 90])
        for (const yaw of [0, 1, -2]) {
          const camera = axes(azimuth, elevation);
          const level = downOnScreen({ beta: 40, gamma: 5 }, screen);
          const down = downOnScreen({ beta, gamma }, screen);
          const m = tableOfRoom(down, level, camera, yaw);
          const [x, y, z] = [m.slice(0, 3), m.slice(3, 6), m.slice(6)];
          close(
            times(m, [0, -1, 0]),
            gravityOfScreen(down, level, camera).map((g) => g / 9.81),
            "straight down",
          );
          close(
            [x, y, z].map((axis) => Math.hypot(...axis)),
            [1, 1, 1],
            "lengths",
          );
          close([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]], z, "right-handed");
          close(
            tableOfRoom(level, level, camera, yaw),
            [Math.cos(yaw), 0, Math.sin(yaw), 0, 1, 0, -Math.sin(yaw), 0, Math.cos(yaw)],
            "held level",
          );
          ++tried;
        }

// Cells of light: a level table keeps them, one that is turned about the vertical by four sectors moves them by four, and
// on a tipped one a lamp overhead is where the room's zenith has gone. Light that is even loses what the floor takes away.
const cells = Float32Array.from({ length: 64 }, (_, i) => ((i % 7) + 1) / 251);
const identity = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const sum = cells.reduce((all, x) => all + x);
const shared = [...cells].map((x) => x / sum);
close(cellsOfTable(cells, identity), shared, "level");
const quarter = [0, 0, 1, 0, 1, 0, -1, 0, 0]; // the room's x is the table's z
close(
  cellsOfTable(cells, quarter),
  shared.map((_, i) => shared[i - (i % 16) + ((i + 12) % 16)]),
  "a quarter turn",
);
const lamp = Float32Array.from({ length: 64 }, (_, i) => (i >= 48 ? 1 / 16 : 0));
const tip = (50 * Math.PI) / 180;
const [c, s] = [Math.cos(tip), Math.sin(tip)];
const tipped = [c, -s, 0, s, c, 0, 0, 0, 1];
const seen = cellsOfTable(lamp, tipped); // the zenith leans towards the table's x
const middle = [0, 1, 2].map((k) =>
  seen.reduce((all, x, i) => {
    const azimuth = (((i % 16) + 0.5) * Math.PI) / 8;
    const up = Math.sqrt((Math.floor(i / 16) + 0.5) / 4);
    const flat = Math.sqrt(1 - up * up);
    return all + x * [flat * Math.cos(azimuth), up, flat * Math.sin(azimuth)][k];
  }, 0),
);
const angle = (Math.acos((middle[0] * s + middle[1] * c) / Math.hypot(...middle)) * 180) / Math.PI;
assert.ok(angle < 12 && Math.abs(middle[2]) < 0.02, `the lamp is ${angle} degrees from the room's zenith`);
const even = cellsOfTable(new Float32Array(64).fill(1 / 64), tipped);
const [away, towards] = [8, 0].map((sector) => even[sector]);
assert.ok(
  Math.abs(even.reduce((all, x) => all + x) - 1) < 1e-5 && away < 0.4 * towards,
  `the floor is as bright as the room: ${away}, ${towards}`,
);
console.log(`${tried} ways to hold a device`);
