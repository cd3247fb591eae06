// "Measure this phone": the scene's own frames, all work, no shadows. The hash is that of every other machine. The class
// of a device is how fast it does what these frames were counted to take on ARM, beside what phones' cores are stated to.
import { SandScene } from "./scene.mjs";
import { k_scene } from "./data.mjs";
import { constants } from "./sandglass.mjs";

const k_colours = ["#ffb454", "#f4f1a2", "#d9b38c", "#8fb8ff", "#e07b39", "#9ad6a0", "#c9a0dc", "#7fd1c7"]; // of stages, again and again
const k_pause_ms = 100; // of work, before the page is drawn

// The stages of a frame: their names and the colours of their bars.
export function stagesOf(sand) {
  return Array.from({ length: constants.SANDGLASS_STAGE_COUNT }, (_, i) => {
    return { name: sand.sandglass_stage_name(i), colour: k_colours[i % k_colours.length] };
  });
}

// Lets the browser draw where it has waited for long, and tells the share that is done.
export class Pauses {
  since = performance.now();
  async perhaps(shown, share) {
    if (performance.now() - this.since < k_pause_ms) return;
    shown(share);
    await new Promise((go) => setTimeout(go));
    this.since = performance.now();
  }
}

// `shown` is called with the share that is done.
export async function fixedRun(sand, frames = k_scene.frames, shown = () => {}) {
  const scene = new SandScene(sand, k_scene, { clock: true });
  const names = stagesOf(sand).map(({ name }) => name);
  const stages = names.map(() => 0);
  const pauses = new Pauses();
  let ms = 0;
  for (let frame = 0; frame < frames; ++frame) {
    await pauses.perhaps(shown, frame / frames);
    const report = scene.frame(k_scene.frame_step, 1e6);
    ms += report.time.elapsed_ns / 1e6;
    report.stages.forEach((one, i) => {
      stages[i] += one.elapsed_ns / 1e6;
    });
  }
  const result = {
    hash: scene.hash(),
    ms: ms / frames,
    stages: stages.map((sum, i) => [names[i], sum / frames]),
    particles: scene.report.sand.particles,
    threads: sand.threads,
    isa: sand.sandglass_isa_name(sand.sandglass_scene_isa(scene.handle)),
  };
  scene.destroy();
  return result;
}

function classOf(ms) {
  const billions = k_scene.counted.instructions / k_scene.frames / ms / 1e6;
  const shown = (x) => x.toPrecision(2);
  return [
    `class        ${shown(billions)} billion NEON instructions a second, as counted on ARM`,
    ...k_scene.counted.cores.map(
      ({ name, low, high }) => `  ${name.padEnd(10)} ${shown(low)} to ${shown(high)} as stated, without a browser`,
    ),
  ];
}

export function asText({ hash, ms, stages, particles, threads, isa }) {
  return [
    `Sandglass, ${k_scene.frames} frames of the page's scene, ${particles} particles at the end`,
    `browser      ${navigator.userAgent}`,
    `cores        ${navigator.hardwareConcurrency}`,
    `threads      ${threads}`,
    `kernels      ${isa}`,
    `a frame      ${ms.toFixed(2)} ms`,
    ...stages.map(([name, mean]) => `  ${name.padEnd(10)} ${mean.toFixed(2)} ms`),
    ...classOf(ms),
    `hash         ${hash}`,
  ].join("\n");
}
