// Sand in a scene of three.js: a mesh for each chunk, and one each for what lies and flies alone. The look, a material of three's own
// kind, comes from three_glsl.mjs or three_nodes.mjs.
import { grainsNeeded, looseValues, squareIndices } from "./loose_sand.mjs";
import { chunkArrays, looseLists } from "./sand_geometry.mjs";
import { k_loose_words } from "./skin_changes.mjs";
import { ShadowTextures, nothingDrawn, showOnSand } from "./shadow_textures.mjs";
import { kitValues } from "./glsl.mjs";

const k_grain = 0.005; // metres that a grain may be drawn beside its particle, and moves while a picture is exposed

export class ThreeSand {
  // `look`: of the renderer; `radius`: a particle's.
  constructor(THREE, look, radius) {
    Object.assign(this, { THREE, look, radius, group: new THREE.Group(), chunks: [], particles: [] });
    this.textures = new ShadowTextures(textureMaker(THREE), (name, texture) => look.set({ [name]: texture }));
    this.take(nothingDrawn);
    this.loose = [0, 1].map((flies) => this.#looseMesh(flies));
  }
  // After a lost context: what geometries and textures had of the one before is gone with it, and must not be freed.
  renew() {
    const { look, textures } = this;
    for (const mesh of [...this.chunks, ...this.loose]) mesh.geometry = another(mesh.geometry);
    for (const [name, texture] of Object.entries(textures.all)) textures.put(name, sameTexture(texture));
    look.renew?.();
  }

  take(drawn) {
    const { look } = this;
    showOnSand(this.textures, drawn);
    look.set({ ...kitValues(drawn), ...looseValues(this.radius, drawn.streams ?? []) });
    if (!drawn.skin) return;
    for (const chunk of drawn.skin.chunks) this.#takeChunk(chunk);
    looseLists(drawn.skin).forEach((particles, flies) => this.#takeLoose(flies, particles, drawn.skin));
  }
  // What it holds of the scene and the renderer.
  end() {
    this.group.removeFromParent();
    for (const mesh of [...this.chunks, ...this.loose]) mesh.geometry.dispose();
    this.textures.end();
    this.look.end();
  }

  #takeChunk({ number, ...chunk }) {
    const { THREE, look, chunks, group } = this;
    while (chunks.length <= number) {
      const mesh = new THREE.Mesh(new THREE.BufferGeometry(), look.surface); // any may be made first
      mesh.visible = false;
      group.add(mesh);
      chunks.push(mesh);
    }
    const mesh = chunks[number];
    mesh.visible = chunk.indices.length > 0;
    if (!mesh.visible) return;
    const { positions, normals, origins, indices, low, high } = chunkArrays(chunk, look.first);
    const normal = put(THREE, mesh, "normal", normals, 4, true);
    mesh.geometry.setAttribute("sand_normal", normal);
    put(THREE, mesh, "position", positions, 3);
    put(THREE, mesh, "sand_origin", origins, 4, true);
    put(THREE, mesh, "", indices, 1);
    mesh.geometry.setDrawRange(0, indices.length);
    bound(THREE, mesh.geometry, low, high);
  }

  #looseMesh(flies) {
    const { THREE, look } = this;
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(squareIndices(), 1));
    geometry.instanceCount = 0;
    const mesh = new THREE.Mesh(geometry, look.loose[flies]);
    mesh.visible = false;
    mesh.raycast = () => {}; // a ray hits the mesh
    const view = new THREE.Matrix4();
    const needed = (renderer, camera) => {
      view.multiplyMatrices(camera.matrixWorldInverse, mesh.matrixWorld);
      const { elements } = camera.projectionMatrix;
      return grainsNeeded(flies, this.particles[flies], view.elements, elements, look.pixels(renderer, camera));
    };
    // WebGPURenderer calls it once for all eyes.
    mesh.onBeforeRender = (renderer, _scene, camera) => {
      let squares = camera.cameras?.length ? 0 : needed(renderer, camera);
      for (const each of camera.cameras ?? []) squares = Math.max(squares, needed(renderer, each));
      mesh.geometry.setDrawRange(0, 6 * squares);
    };
    this.group.add(mesh);
    return mesh;
  }
  #takeLoose(flies, particles, { low, high }) {
    const { THREE } = this;
    const mesh = this.loose[flies];
    const { geometry } = mesh;
    const count = particles.length / k_loose_words;
    mesh.visible = count > 0;
    this.particles[flies] = particles;
    if (!mesh.visible) return;
    let buffer = geometry.attributes.position?.data;
    if (!(buffer?.count >= count)) {
      const before = mesh.geometry;
      mesh.geometry = new THREE.InstancedBufferGeometry();
      mesh.geometry.setIndex(before.index.clone());
      before.dispose();
      buffer = new THREE.InstancedInterleavedBuffer(new Float32Array(k_loose_words * roomFor(count)), k_loose_words);
      buffer.setUsage(THREE.DynamicDrawUsage);
      const attribute = (name, size, at) =>
        mesh.geometry.setAttribute(name, new THREE.InterleavedBufferAttribute(buffer, size, at));
      attribute("position", 3, 0);
      attribute("sand_place", 4, 0);
      attribute("sand_way", 3, 4);
      attribute("sand_number", 1, 7);
    }
    fill(buffer, particles);
    mesh.geometry.instanceCount = count;
    bound(
      THREE,
      mesh.geometry,
      low.map((x) => x - k_grain),
      high.map((x) => x + k_grain),
    );
  }
}

// Room for some more, so that few arrays are made.
const roomFor = (count) => 2 ** Math.ceil(Math.log2(Math.max(64, count)));

// Sets an attribute, or the index where the name is empty, in an array that may have room for more.
function put(THREE, mesh, name, values, size, normalized = false) {
  const { geometry } = mesh;
  let attribute = name ? geometry.getAttribute(name) : geometry.index;
  if (!(attribute?.array.length >= values.length)) {
    // A geometry frees what it has when it is disposed of; that which has room is uploaded once more.
    geometry.dispose();
    attribute = new THREE.BufferAttribute(
      new values.constructor(size * roomFor(values.length / size)),
      size,
      normalized,
    );
    attribute.setUsage(THREE.DynamicDrawUsage);
    if (name) geometry.setAttribute(name, attribute);
    else geometry.setIndex(attribute);
  }
  fill(attribute, values);
  return attribute;
}
function fill(attribute, values) {
  attribute.array.set(values);
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, values.length);
  attribute.needsUpdate = true;
}

// A geometry of the same arrays.
function another(geometry) {
  const made = new geometry.constructor();
  made.setIndex(geometry.index);
  for (const [name, attribute] of Object.entries(geometry.attributes)) made.setAttribute(name, attribute);
  const { boundingBox, boundingSphere, drawRange, instanceCount } = geometry;
  return Object.assign(made, {
    boundingBox,
    boundingSphere,
    drawRange,
    ...(made.isInstancedBufferGeometry ? { instanceCount } : {}),
  });
}

function bound(THREE, geometry, low, high) {
  geometry.boundingBox = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high));
  geometry.boundingSphere = geometry.boundingBox.getBoundingSphere(new THREE.Sphere());
}

export const sameTexture = (texture) => Object.assign(texture.clone(), { needsUpdate: true });

// Textures of one byte a texel, as a stage gives them.
export const textureMaker = ({ DataTexture, LinearFilter, RedFormat }) => ({
  make: (side, bytes) =>
    Object.assign(new DataTexture(new Uint8Array(bytes), side, bytes.length / side, RedFormat), {
      minFilter: LinearFilter,
      magFilter: LinearFilter,
      unpackAlignment: 1,
      needsUpdate: true,
    }),
  fill(texture, bytes) {
    texture.image.data.set(bytes);
    texture.needsUpdate = true;
  },
});

// The block of grains.
export function blockTexture({ Data3DTexture, LinearFilter }, bytes, sides) {
  return Object.assign(new Data3DTexture(bytes, ...sides), {
    minFilter: LinearFilter,
    magFilter: LinearFilter,
    needsUpdate: true,
  });
}
