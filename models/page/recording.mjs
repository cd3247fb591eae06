// What the frames of the table were given and what they executed, so that they can be run again to the bit. Work units of
// shadows are left out: sand does not depend on them.
import { constants } from "./sandglass.mjs";
import { addPoints } from "./scene.mjs";
import { newTableScene } from "./stands.mjs";
import { dropObjects, fieldOfObject, objectOf, showObjects } from "./objects.mjs";
import { Pauses } from "./measure.mjs";
import { k_scene } from "./data.mjs";

const k_frames_at_most = 18000; // five minutes
const k_emitter_fields = ["position", "rotation", "radius", "speed"];
const k_collider_fields = ["shape", "position", "rotation", "size", "linear_velocity"];
const k_left_out = [constants.SANDGLASS_STAGE_SHADOW, constants.SANDGLASS_STAGE_SKIN];

function picked(view, names) {
  const copy = (value) => (typeof value === "number" ? value : [...value]);
  return Object.fromEntries(names.map((name) => [name, copy(view[name])]));
}

// A frame that has run: with so many emitters, and colliders from `first` on besides those of the scene's file.
export function record(page, emitters, plan, first) {
  const { scene, added } = page;
  page.added = [];
  if (!page.onTable || page.recorded.length >= k_frames_at_most) return;
  const runs = plan.runs.slice(0, plan.run_count).filter(({ stage }) => !k_left_out.includes(stage));
  page.recorded.push({
    emitters: scene.emitters.slice(0, emitters).map((emitter) => picked(emitter, k_emitter_fields)),
    colliders: scene.colliders
      .slice(first, scene.input.collider_count)
      .map((collider) => picked(collider, k_collider_fields)),
    level: plan.level,
    runs: runs.map(({ stage, units }) => [stage, units]),
    ...(page.tipped ? { gravity: page.given, tipped: true } : {}),
    ...(added.length ? { added } : {}),
  });
  if (page.recorded.length === k_frames_at_most) page.recordedHash = scene.hash();
}

export function recordingOf({ recorded, recordedHash, scene }) {
  const hash = recordedHash ?? scene.hash();
  return { sandglass: "recording", scene: k_scene.name, step: k_scene.frame_step, frames: recorded, hash };
}

// Runs a recording in a new scene, which then replaces the present one. Throws where it does not end as it did.
export async function playRecording(page, told, shown) {
  if (told?.sandglass !== "recording" || told.scene !== k_scene.name || !Array.isArray(told.frames))
    throw new Error("The file is no recording of this page. Choose one that it saved.");
  page.show("table");
  const scene = newTableScene(page.sand);
  const before = { given: page.given, tipped: page.tipped, objects: page.objects };
  page.given = [...k_scene.gravity];
  page.tipped = false;
  page.objects = [];
  try {
    await playFrames(page, scene, told, shown);
  } catch (error) {
    scene.destroy();
    dropObjects(page);
    Object.assign(page, before);
    showObjects(page);
    const ours = error.message.startsWith("sandglass") || error.constructor === Error;
    throw new Error(ours ? error.message : "The recording is damaged, so it cannot be played. Ask for it again.", {
      cause: error,
    });
  }
  const hash = scene.hash();
  replaceScene(page, scene, before.objects, told.frames);
  if (hash !== told.hash)
    throw new Error(`The recording ends in ${hash} here and in ${told.hash} where it was made. Please report this.`);
  return hash;
}

async function playFrames(page, scene, { frames, step }, shown) {
  const plan = page.sand.make("sandglass_plan");
  const pauses = new Pauses();
  try {
    for (const [i, frame] of frames.entries()) {
      playFrame(page, scene, frame, plan, step);
      await pauses.perhaps(shown, i / frames.length);
    }
    scene.input.plan = 0;
  } finally {
    page.sand.free(plan);
  }
}

/** @param {import("./page.mjs").Page} page */
function replaceScene(page, scene, objectsBefore, frames) {
  const { skin, pile_shadow, casts, cast_count } = page.scene.input;
  const after = page.objects;
  scene.input.set({ skin, pile_shadow, casts, cast_count });
  page.scene.destroy();
  page.stand.scene = scene;
  page.objects = objectsBefore;
  dropObjects(page);
  page.objects = after;
  showObjects(page);
  page.scene = scene;
  page.recorded = [...frames];
  page.recordedHash = undefined;
  page.added = [];
  page.denied = scene.report.sand.denied_particles;
  page.stage.refresh();
}

function playFrame(page, scene, frame, plan, step) {
  const { emitters, colliders, level, runs, gravity, tipped, added } = frame;
  for (const one of added ?? []) playAdded(page, scene, one);
  if (gravity && gravity.some((x, k) => x !== page.given[k])) page.setGravity(scene, gravity);
  page.tipped = tipped === true;
  const first = page.placeWalls(scene);
  emitters.forEach((emitter, k) => scene.emitters[k].set(emitter));
  colliders.forEach((collider, k) => scene.colliders[first + k].set(collider));
  scene.input.collider_count = first + colliders.length;
  plan.level = level;
  plan.run_count = runs.length;
  plan.runs.slice(0, runs.length).forEach((run, k) => run.set({ stage: runs[k][0], units: runs[k][1] }));
  scene.input.plan = plan;
  scene.frame(step, 0, emitters.length);
}

function playAdded(page, scene, { particles, vertices, indices, at, metal }) {
  if (!vertices) {
    addPoints(page.sand, scene.handle, { positions: Float32Array.from(particles) });
    return;
  }
  const mesh = { vertices: Float32Array.from(vertices), indices: Uint32Array.from(indices) };
  const object = objectOf(page, mesh, at, metal);
  object.field = fieldOfObject(page.sand, object);
  page.objects.push(object);
}
