// What the calls of a stage take, and the sentence that refuses something else.

// How many numbers an option has, 1 of them above 0; 0: something else.
export const k_options = { sand: 0, source: 0, threads: 1, origin: 3, half: 1, budget: 1, reflections: 0 };
export const k_model_options = { shadow: 0, collide: 0 };
export const k_nozzle_options = { position: 3, rotation: 4, radius: 1, speed: 1 };
export const k_sand_options = { particles: 1, radius: 1 };

function fits(value, count) {
  if (!count || value === undefined) return true;
  const numbers = count > 1 ? Array.from(value ?? []) : [value];
  return numbers.length === count && numbers.every(Number.isFinite) && (count > 1 || value > 0);
}

// Refuses an option that there is not, and what is no such number.
export function checked(what, given, kinds) {
  for (const [name, value] of Object.entries(given)) {
    const count = kinds[name];
    if (count === undefined) {
      const all = Object.keys(kinds).join(", ");
      throw new Error(`sandglass: ${what} takes no "${name}". It takes: ${all}.`);
    }
    if (fits(value, count)) continue;
    const wanted = count > 1 ? `${count} numbers: an array or a vector` : "a number above 0";
    throw new Error(`sandglass: ${what}: ${name} must be ${wanted}.`);
  }
}
