// Meshes of files on the table: as objects, which cast and which sand collides with, or as sand.
import { constants } from "./sandglass.mjs";
import { addPoints } from "./scene.mjs";
import { fieldOf, matrixOf, withMesh } from "./mesh_field.mjs";
import { standing, smoothed } from "./mesh_file.mjs";
import { k_casts, k_object_triangles, k_objects } from "./stands.mjs";
import { say, counted } from "./elements.mjs";
import { k_scene } from "./data.mjs";

const k_sand_radius = k_scene.granular.particle_radius;
export const k_mesh_height = 0.22; // metres, of a mesh that stands or becomes sand
const k_mesh_width = 0.5; // at most
const k_mesh_above = 0.05; // where it begins to fall, over the mark
const k_mesh_particles = 1000; // about the most of one mesh, so that it finds room beside what is poured
const k_spare_triangles = 1000; // for what the floor cuts
const k_paint = [0.35, 0.33, 0.3]; // albedo of an object
const k_metal = [0.95, 0.93, 0.88]; // what metal reflects
const k_object_spacing = 0.5 * k_sand_radius; // of the field that sand collides with

// A mesh as an object at the mark: it casts at once, and sand collides with it when its field is made, a frame later.
export function addObject(page, read, metal = false) {
  const mesh = standing(read, k_mesh_height, k_mesh_width);
  const triangles = page.objects.reduce((sum, { indices }) => sum + indices.length / 3, mesh.indices.length / 3);
  if (page.objects.length === k_objects)
    throw new Error(`There are ${k_objects} objects on the table. Press "Start again" to clear it.`);
  if (triangles > k_object_triangles - k_spare_triangles) {
    const of = `${counted(triangles)} of ${counted(k_object_triangles)}`;
    throw new Error(`The mesh has too many triangles: ${of}. Choose a coarser one.`);
  }
  const object = objectOf(page, mesh, [...page.mark], metal);
  page.objects.push(object);
  showObjects(page);
  requestAnimationFrame(() => setTimeout(() => giveField(page, object))); // once it was seen
  return mesh.indices.length / 3;
}

function giveField(page, object) {
  const { vertices, indices, at, metal } = object;
  if (!page.objects.includes(object)) return;
  try {
    object.field = fieldOfObject(page.sand, object);
  } catch (error) {
    say(`Sand goes through the object: ${error.message}`);
    return;
  }
  page.added.push({ vertices: [...vertices], indices: [...indices], at, metal });
}

/** @param {import("./page.mjs").Page} page */
export function objectOf(page, { vertices, indices }, at, metal) {
  const pose = { position: at, rotation: [0, 0, 0, 1] };
  const number = page.stage.addModel({ positions: vertices, indices, ...pose }, k_casts);
  return { vertices, indices, at, metal, model: matrixOf(at, pose.rotation), field: 0, number };
}

export function fieldOfObject(sand, { vertices, indices }) {
  return sand.put(fieldOf(sand, { positions: vertices, indices }, k_object_spacing));
}

export function showObjects(page) {
  for (const object of page.objects) object.drawn ??= drawnObject(page.painter, object);
  page.castAll();
}

function drawnObject(painter, { vertices, indices, model, metal }) {
  if (!metal) return painter.add(vertices, indices, model, k_paint);
  const { corners, normals } = smoothed(vertices, indices);
  const inOrder = Uint32Array.from({ length: indices.length }, (_, i) => i);
  return painter.add(corners, inOrder, model, k_metal, normals);
}

/** @param {import("./page.mjs").Page} page */
export function dropObjects(page) {
  const gone = page.objects;
  page.objects = [];
  page.wake();
  for (const { drawn, field, number } of gone) {
    if (drawn) page.painter.remove(drawn);
    page.stage.remove(number);
    page.sand.free(field);
  }
}

// A mesh as sand: its volume on the library's lattice, above the mark. One that takes too much sand is made smaller.
export function addMesh(page, read) {
  const mesh = standing(read, k_mesh_height, k_mesh_width);
  let particles = filled(page.sand, mesh);
  if (particles.length === 0) throw new Error("The mesh is too thin to be filled with sand. Choose one with a volume.");
  const smaller = Math.cbrt((3 * k_mesh_particles) / particles.length);
  if (smaller < 1) particles = filled(page.sand, { ...mesh, vertices: mesh.vertices.map((x) => x * smaller) });
  const count = particles.length / 3;
  if (count > page.scene.desc.granular.particle_capacity - page.particles()) {
    const answer = 'Press "Start again", then drop it again.';
    throw new Error(`${page.full()}, and the mesh needs ${counted(count)}. ${answer}`);
  }
  for (let i = 0; i < particles.length; i += 3) {
    particles[i] += page.mark[0];
    particles[i + 1] += k_mesh_above;
    particles[i + 2] += page.mark[2];
  }
  addPoints(page.sand, page.scene.handle, { positions: particles });
  page.wake();
  page.added.push({ particles: [...particles] });
  return count;
}

// The particles that fill a mesh.
function filled(sand, { vertices, indices }) {
  return withMesh(sand, vertices, indices, (mesh, keep) => {
    const desc = keep(sand.make("sandglass_sample_desc"));
    const out = keep(sand.allocate(8));
    const word = () => new Uint32Array(sand.memory.buffer, out, 1)[0];
    sand.sandglass_sample_desc_default(desc);
    sand.sandglass_mesh_bounds(mesh, desc.bounds_min, desc.bounds_max);
    desc.set({
      method: constants.SANDGLASS_SAMPLE_LATTICE,
      distance: 2.02 * k_sand_radius,
      inside: sand.pointer("sandglass_mesh_inside_test"),
      inside_user: keep(sand.create("sandglass_mesh_inside", mesh, constants.SANDGLASS_INSIDE_WINDING)),
    });
    sand.sandglass_sample_capacity(desc, out);
    const capacity = word();
    sand.sandglass_sample_bytes(desc, capacity, out);
    const scratch = word();
    const block = keep(sand.allocate(scratch));
    const points = keep(sand.allocate(12 * capacity));
    sand.sandglass_sample_points(desc, block, scratch, points, capacity, out);
    return sand.floats(points, 3 * word()).slice();
  });
}
