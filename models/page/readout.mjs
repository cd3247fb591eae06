// What a frame takes and what it did, as the page tells it.
import { stagesOf } from "./measure.mjs";
import { by, counted } from "./elements.mjs";

const k_in_time = 0.9; // of the time that was asked for: not slow motion
const k_late_ms = 1; // over the budget
const k_main_light = 0.02; // the smallest share of the floor's light that tells where it comes from

export const slowMotion = (flow) => flow < k_in_time;

function row(name, value, colour) {
  const term = document.createElement("dt");
  if (colour) term.append(Object.assign(document.createElement("i"), { style: `background:${colour}` }));
  term.append(name);
  return [term, Object.assign(document.createElement("dd"), { textContent: value })];
}

function tellShort(page, ms, budget) {
  const busy = slowMotion(page.flow) && "Slower: this device is busy";
  const less = !page.onTable && page.inGlass < page.stands.glass.full && "Less sand: this device is slow";
  const late = ms > budget + k_late_ms && "late";
  by("short").textContent = busy || less || `Sand: ${ms.toFixed(1)} of ${budget} ms a frame`;
  by("short").className = busy || less ? "slow" : late || "";
}

function tellBar(parts, ms, budget) {
  const bar = by("bar");
  const whole = Math.max(budget, ms);
  bar.setAttribute("aria-valuenow", Math.round((100 * ms) / budget));
  const pieces = parts.map(([, colour, part]) => {
    const style = `width:${(100 * part) / whole}%;background:${colour}`;
    return Object.assign(document.createElement("span"), { style });
  });
  bar.replaceChildren(...pieces);
}

export function tell(page) {
  const { report } = page.scene;
  const of = page.spent.length || 1;
  const mean = (pick) => page.spent.reduce((sum, frame) => sum + pick(frame), 0) / of;
  const budget = Number(by("budget").value);
  const ms = mean((frame) => frame.ms);
  tellShort(page, ms, budget);
  if (!by("more").open) return;
  const parts = stagesOf(page.sand)
    .map(({ name, colour }, i) => [name, colour, mean((frame) => frame.stages[i])])
    .filter(([, , part]) => part > 0.005);
  tellBar(parts, ms, budget);
  const rows = [
    ...parts.map(([name, colour, part]) => row(name, `${part.toFixed(2)} ms`, colour)),
    row("quality level", `${report.level} ${page.sand.sandglass_level_name(report.level)}`),
    row("time debt", `${report.time.debt.toFixed(2)} s`),
    row("particles", counted(report.sand.particles)),
    row("triangles", counted(page.skinMesh.index_count / 3)),
    row("drawn", page.pace.said),
    ...tellLight(page),
  ];
  by("numbers").replaceChildren(...rows.flat());
}

// What the camera knows of the room's light, and in augmented reality how far from the device's it is.
/** @param {import("./page.mjs").Page} page */
function tellLight({ stage, watching, real, deviceLight }) {
  const { valid, seen, main_share, main_direction } = stage.roomLight;
  if (valid !== 1 || !(watching || real)) return [];
  const percent = (share) => `${Math.round(100 * share)} %`;
  const rows = [row("room seen", percent(seen)), row("main light", percent(main_share))];
  if (!real || !deviceLight || main_share < k_main_light) return rows;
  const cosine = deviceLight.toLight.reduce((sum, x, k) => sum + x * main_direction[k], 0);
  const degrees = (Math.acos(Math.min(1, cosine)) * 180) / Math.PI;
  return [...rows, row("from the device's light", `${Math.round(degrees)}°`)];
}
