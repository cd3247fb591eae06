// What the calls of a stage take, and the sentence that refuses something else.

// How many numbers an option has, 1 of them above 0; 0: something else.
export const k_options = { sand: 0, source: 0, threads: 1, origin: 3, half: 1, height: 1, budget: 1, reflections: 0 };
export const k_model_options = { shadow: 0, collide: 0 };
export const k_sand_options = { particles: 1, radius: 1 };
export const k_view_options = { orientation: 4, position: 3, diagonal: 1, centre: 2, exposure: 0, ms: 0 };
export const k_depth_options = {
  ...{ data: 0, width: 1, height: 1, toMetres: 1, focal: 2, centre: 2 },
  ...{ position: 3, orientation: 4 },
};
export const k_pose = { position: 3, rotation: 4 };
const k_nozzle_options = { position: 3, rotation: 4, radius: 1, speed: 1 };
const k_ball_options = { position: 3, radius: 1, velocity: 3 };
const k_joint_options = { position: 3, radius: 1 };

export const k_ended = "sandglass: the stage has ended: dispose or end was called. Create another.";
export const k_nozzles = 8;
export const k_balls = 31;
export const k_hands = 2;
const k_joints = 25; // of WebXR, of a hand
const k_farthest_sand = 1000; // metres from the world's origin: farther away the library has no sand
const k_farthest_shadow = 1e6; // and so far no shadows
const k_axes = ["x", "y", "z", "w"];

// Of an array, or of a vector of a renderer or of WebXR.
export const numbersOf = (value, count) =>
  typeof value?.x === "number" ? k_axes.slice(0, count).map((axis) => value[axis]) : Array.from(value ?? []);

function fits(value, count, reach) {
  if (!count) return true;
  if (count === 1) return Number.isFinite(value) && value > 0;
  const all = value.length === count && value.every((x) => Number.isFinite(x) && Math.abs(x) <= reach);
  return all && (count < 4 || Math.hypot(...value) > 0);
}

// Gives what was given, with arrays for vectors. Refuses an option that there is not, what is no such number, and where
// one of `needed` is not there.
export function checked(what, given, kinds, { needed = [], reach = k_farthest_sand } = {}) {
  const taken = {};
  for (const [name, value] of Object.entries({ ...Object.fromEntries(needed.map((name) => [name, null])), ...given })) {
    const count = kinds[name];
    if (count === undefined) {
      const all = Object.keys(kinds).join(", ");
      throw new Error(`sandglass: ${what} takes no "${name}". It takes: ${all}.`);
    }
    if (value === undefined && !needed.includes(name)) continue;
    taken[name] = count > 1 ? numbersOf(value, count) : value;
    if (fits(taken[name], count, reach)) continue;
    const some = `${count} numbers up to ${reach}${count > 3 ? ", not all 0" : ""}`;
    throw new Error(
      `sandglass: ${what}: ${name} must be ${count > 1 ? `${some}: an array or a vector` : "a number above 0"}.`,
    );
  }
  return taken;
}

export const poseOf = (what, position, rotation) =>
  checked(what, { position, rotation }, k_pose, { needed: ["position", "rotation"], reach: k_farthest_shadow });

// Whether a model can stand so; a tracker that has lost it gives NaN.
export const isPose = ({ position, rotation }) =>
  fits(position, 3, k_farthest_shadow) && fits(rotation, 4, k_farthest_shadow);

function allOf(call, what, given, most, kinds, needed) {
  if (given.length > most)
    throw new Error(
      `sandglass: ${call} takes ${most} ${what}s at most, not ${given.length}. Pass those near the sand.`,
    );
  return given.map((one) => checked(`a ${what}`, one, kinds, { needed }));
}
export const nozzlesOf = (given) => allOf("pour", "nozzle", given, k_nozzles, k_nozzle_options, ["position"]);
export const ballsOf = (given) => allOf("push", "ball", given, k_balls, k_ball_options, ["position", "radius"]);
// Of each hand its joints; null: it is lost.
export function handsOf(given) {
  if (given.length > k_hands) throw new Error(`sandglass: setHands takes ${k_hands} hands, not ${given.length}.`);
  return given.map((hand) => {
    if (!hand) return null;
    if (hand.length === k_joints)
      return hand.map((joint) => checked("a joint", joint, k_joint_options, { needed: ["position", "radius"] }));
    throw new Error(
      `sandglass: a hand has the ${k_joints} joints of WebXR, in their order, not ${hand.length}. Pass null where it is lost.`,
    );
  });
}
