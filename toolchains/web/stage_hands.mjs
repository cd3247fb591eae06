// Hands of a stage, as capsules that push sand.
import { constants } from "./sandglass.mjs";

// From joint to joint, in the order of WebXR: the wrist, four of the thumb and five of each finger.
const k_fingers = [
  [0, 1, 2, 3, 4],
  ...[5, 10, 15, 20].map((first) => [0, ...Array.from({ length: 5 }, (_, i) => first + i)]),
];
const k_bones = k_fingers.flatMap((joints) => joints.slice(1).map((joint, i) => [joints[i], joint]));
export const k_hand_bodies = 2 * k_bones.length; // of two hands
const k_shortest = 1e-4; // metres, half of a capsule's line

function capsule(from, to) {
  const way = to.position.map((x, k) => (x - from.position[k]) / 2);
  const half = Math.hypot(...way);
  const [x, y, z] = half > 0 ? way.map((c) => c / half) : [0, 1, 0];
  return {
    shape: constants.SANDGLASS_SHAPE_CAPSULE,
    position: from.position.map((c, k) => c + way[k]),
    rotation: y > -0.999999 ? [z, 0, -x, 1 + y] : [1, 0, 0, 0], // from y to the line
    size: [(from.radius + to.radius) / 2, Math.max(half, k_shortest), 1],
  };
}

export class StageHands {
  #next = 2 ** 30; // number of a capsule, as a collider
  #hands = [];

  // `hands`: of each its 25 joints, or null. One that comes back is another hand: what jumped is not taken for a motion.
  take(hands) {
    this.#hands = hands.map((joints, which) => {
      if (!joints) return null;
      const first = this.#hands[which]?.first ?? this.#next;
      if (first === this.#next) this.#next += k_bones.length;
      return { first, joints };
    });
  }
  get bodies() {
    return this.#hands.flatMap((hand) =>
      hand ? k_bones.map(([a, b], i) => ({ ...capsule(hand.joints[a], hand.joints[b]), id: hand.first + i })) : [],
    );
  }
}
