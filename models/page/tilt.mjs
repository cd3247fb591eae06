// Gravity in the table's frame: of a device that is tipped, or of two angles from sliders and keys.
//
// The device counts as level as it was held when it was switched on. From then on the table is fixed to the picture:
// tipping the screen tips the table.
const k_gravity = 9.81; // m/s^2
const k_floor = 0.3; // what a room's floor reflects
const k_tilt_at_most = Math.PI / 3; // of gravity from straight down; beyond, sand would leave the table

const turned = (v, [x, y, z, w]) => {
  const t = [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]].map((c) => 2 * c);
  return [
    v[0] + w * t[0] + y * t[2] - z * t[1],
    v[1] + w * t[1] + z * t[0] - x * t[2],
    v[2] + w * t[2] + x * t[1] - y * t[0],
  ];
};

// The shortest rotation from one unit vector to another.
function shortest(a, b) {
  const q = [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
    1 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  ];
  const length = Math.hypot(...q);
  return length < 1e-6 ? [1, 0, 0, 0] : q.map((x) => x / length);
}

// Straight down in the frame of the screen (x right, y up, z towards the eye), as a unit vector, by the angles of a
// deviceorientation event and of the screen, degrees.
export function downOnScreen({ beta, gamma }, screenAngle = 0) {
  const [b, c, s] = [beta, gamma, screenAngle].map((degrees) => (degrees * Math.PI) / 180);
  const [x, y, z] = [Math.cos(b) * Math.sin(c), -Math.sin(b), -Math.cos(b) * Math.cos(c)];
  return [x * Math.cos(s) - y * Math.sin(s), x * Math.sin(s) + y * Math.cos(s), z];
}

function limited(down) {
  const flat = Math.hypot(down[0], down[2]);
  const angle = Math.atan2(flat, -down[1]);
  if (angle <= k_tilt_at_most) return down;
  return [
    (down[0] / flat) * Math.sin(k_tilt_at_most),
    -Math.cos(k_tilt_at_most),
    (down[2] / flat) * Math.sin(k_tilt_at_most),
  ];
}

// Numbers as 32 bits hold them: so they are recorded, and so they are played.
const gravityAlong = (down) => down.map((x) => Math.fround(k_gravity * x));

// By the screen's tilt since `level`, seen along a camera's axes.
export function gravityOfScreen(down, level, { right, up, away }) {
  const view = [right, up, away].map((axis) => -axis[1]); // straight down of the table, on the screen
  const [x, y, z] = turned(down, shortest(level, view));
  return gravityAlong(limited([0, 1, 2].map((k) => x * right[k] + y * up[k] + z * away[k])));
}

// From the frame of screenPose to that of a table that is fixed to the picture since `level`: a column-major 3 x 3
// rotation. What is straight down in the room becomes what gravityOfScreen says.
export function tableOfRoom(down, level, axes, yaw = 0) {
  const { right, up, away } = axes;
  const pose = screenPose(down, axes, yaw);
  const q = shortest(
    level,
    [right, up, away].map((axis) => -axis[1]),
  );
  return [0, 1, 2].flatMap((k) => {
    const [x, y, z] = turned([pose[k], pose[4 + k], pose[8 + k]], q); // the room's axis k on the screen
    return [0, 1, 2].map((i) => x * right[i] + y * up[i] + z * away[i]);
  });
}

// The room's cells of light (types.h) as they stand above a table that is tipped in it; together they are 1, or all 0.
// What is below the room's horizon is its floor.
export function cellsOfTable(cells, m) {
  const out = new Float32Array(cells.length);
  const mean = cells.reduce((sum, x) => sum + x, 0) / cells.length;
  for (let i = 0; i < 9 * cells.length; ++i) {
    // three by three directions of a cell, of equal weight for a level floor
    const cell = Math.floor(i / 9);
    const azimuth = (2 * Math.PI * ((cell % 16) + ((i % 3) + 0.5) / 3)) / 16;
    const up2 = (Math.floor(cell / 16) + (Math.floor((i % 9) / 3) + 0.5) / 3) / 4;
    const flat = Math.sqrt(1 - up2);
    const d = [flat * Math.cos(azimuth), Math.sqrt(up2), flat * Math.sin(azimuth)];
    const [x, y, z] = [0, 1, 2].map((k) => m[3 * k] * d[0] + m[3 * k + 1] * d[1] + m[3 * k + 2] * d[2]);
    const sector = Math.floor((Math.atan2(z, x) / (2 * Math.PI) + 1) * 16) % 16;
    out[cell] += y > 0 ? cells[16 * Math.min(3, Math.floor(4 * y * y)) + sector] : k_floor * mean;
  }
  const sum = out.reduce((all, x) => all + x, 0);
  return sum > 0 ? out.map((x) => x / sum) : out;
}

// By two angles, degrees: the right side lower, the near side lower.
export function gravityOfAngles(right, near) {
  const [a, b] = [right, near].map((degrees) => Math.tan((degrees * Math.PI) / 180));
  const length = Math.hypot(a, b, 1);
  return gravityAlong(limited([a / length, -1 / length, b / length]));
}

// The pose of the screen in a frame whose y is up, as a column-major matrix: as it is drawn, where nothing is known of
// `down`; else upright as the device is, turned by `yaw` radians since it was drawn so.
export function screenPose(down, { right, up, away }, yaw = 0) {
  const view = [right, up, away].map((axis) => -axis[1]);
  const q = shortest(down ?? view, view);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const columns = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ].map((axis) => {
    const [x, y, z] = turned(axis, q);
    const at = [0, 1, 2].map((k) => x * right[k] + y * up[k] + z * away[k]);
    return [c * at[0] + s * at[2], at[1], c * at[2] - s * at[0], 0];
  });
  return new Float32Array([...columns.flat(), 0, 0, 0, 1]);
}

// Listens to the device's orientation. Asks for the permission where the system has one; that must be in a click.
// Throws where there is none.
export async function followDevice(heard) {
  if (typeof DeviceOrientationEvent === "undefined")
    throw new Error("This browser knows nothing of how it is held. Tip the table with the sliders.");
  if (DeviceOrientationEvent.requestPermission && (await DeviceOrientationEvent.requestPermission()) !== "granted")
    throw new Error(
      "The phone may not tell how it is held. Allow motion in the settings of the browser, or tip the table with the sliders.",
    );
  const listener = (event) => {
    if (Number.isFinite(event.beta) && Number.isFinite(event.gamma)) heard(event);
  };
  addEventListener("deviceorientation", listener);
  return () => removeEventListener("deviceorientation", listener);
}
