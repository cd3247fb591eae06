// sandglass/three: a stage in a scene of three.js, which the app hands over; nothing is imported of it.
import { Engine, oneMesh } from "./engine.mjs";
import { checked } from "./options.mjs";
import { frustumOf } from "./place_light.mjs";
import { receive, receivers, receiverValues } from "./glsl.mjs";

const k_lit = ["MeshStandardMaterial", "MeshPhysicalMaterial", "MeshLambertMaterial", "MeshPhongMaterial"];

// `renderer` and `scene` are needed; `worker`: the stage runs in a Worker; else options of Stage.create.
export async function createStage(THREE, { renderer, scene, ...options } = {}) {
  if (!renderer?.isWebGLRenderer)
    throw new Error(
      "sandglass: createStage needs three's WebGLRenderer (WebGPURenderer has no onBeforeCompile). Call createStage(THREE, { renderer: new THREE.WebGLRenderer(), scene }).",
    );
  if (!scene?.isScene) throw new Error("sandglass: createStage needs the scene that is lit. Pass { scene }.");
  return new ThreeStage(THREE, renderer, scene, await Engine.stageOf(options));
}

class ThreeStage extends Engine {
  constructor(THREE, renderer, scene, stage) {
    super(stage, renderer.getContext());
    Object.assign(this, {
      THREE,
      scene,
      renderer,
      probe: new THREE.LightProbe(),
      sun: new THREE.DirectionalLight(),
      group: null,
      placing: "updateWorldMatrix",
    });
    scene.add(this.probe, this.sun, this.sun.target);
    this.uniforms = Object.fromEntries(
      Object.keys(receiverValues({ light: { toLight: [] } })).map((name) => [name, { value: new THREE.Vector4() }]),
    );
    for (const name of receivers)
      this.uniforms[`sandglass_${name}`] = {
        value: this.texture(1, new Uint8Array([name === "occlusion" || name === "sky" ? 255 : 0])),
      };
    this.uniforms.sandglass_occlusion_box.value.set(2, 2, 0, 0);
  }
  texture(side, bytes) {
    const { LinearFilter, RedFormat, DataTexture } = this.THREE;
    return Object.assign(new DataTexture(bytes, side, side, RedFormat), {
      minFilter: LinearFilter,
      magFilter: LinearFilter,
      unpackAlignment: 1,
      needsUpdate: true,
    });
  }

  poseOf(object) {
    const { Vector3, Quaternion } = this.THREE;
    const position = new Vector3();
    const rotation = new Quaternion();
    object.updateWorldMatrix(true, false);
    object.matrixWorld.decompose(position, rotation, new Vector3());
    return { position: position.toArray(), rotation: rotation.toArray() };
  }
  isShown(object) {
    let one = object;
    while (one?.visible && one !== this.scene) one = one.parent;
    return one?.visible === true;
  }
  // The meshes of an object that are seen where it is: no hidden child, of a LOD its present level, and none whose places
  // a shader makes, as of thick lines.
  meshesOf(object) {
    const meshes = [];
    const visit = (one) => {
      const { isMesh, geometry, isLOD, children } = one;
      if (isMesh && geometry?.getAttribute("position") && !geometry.isInstancedBufferGeometry) meshes.push(one);
      const level = isLOD && one.levels[one.getCurrentLevel()]?.object;
      for (const child of children) if (level ? child === level : child.visible) visit(child);
    };
    object.updateWorldMatrix(true, true);
    visit(object);
    return meshes;
  }
  toStageOf({ position, rotation }) {
    const { Vector3, Quaternion, Matrix4 } = this.THREE;
    return new Matrix4().compose(new Vector3(...position), new Quaternion(...rotation), new Vector3(1, 1, 1)).invert();
  }
  meshOf(object, pose) {
    const from = this.toStageOf(pose);
    const parts = this.meshesOf(object).flatMap((mesh) => {
      const to = from.clone().multiply(mesh.matrixWorld);
      return this.copiesOf(mesh).map(({ matrix, start, count }) => ({
        ...this.trianglesOf(mesh, start, count),
        matrix: (matrix ? to.clone().multiply(matrix) : to).elements,
      }));
    });
    return oneMesh(parts);
  }
  // How often a mesh is drawn: each time by a matrix of its own, and a range of its triangles.
  copiesOf(mesh) {
    const { Matrix4 } = this.THREE;
    const { start, count } = mesh.geometry.drawRange;
    if (mesh.isInstancedMesh)
      return Array.from({ length: mesh.count }, (_, i) => {
        const matrix = new Matrix4();
        mesh.getMatrixAt(i, matrix);
        return { matrix, start, count };
      });
    if (!mesh.isBatchedMesh) return [{ start, count }];
    const copies = [];
    for (let i = 0, left = mesh.instanceCount; left > 0 && i < mesh.maxInstanceCount; ++i) {
      try {
        const seen = mesh.getVisibleAt(i);
        --left;
        if (seen)
          copies.push({
            matrix: mesh.getMatrixAt(i, new Matrix4()),
            ...mesh.getGeometryRangeAt(mesh.getGeometryIdAt(i)),
          });
      } catch {
        // an instance that was deleted
      }
    }
    return copies;
  }
  // A range of a mesh's triangles, bent as it is drawn: by its bones and morph targets.
  trianglesOf(mesh, start, count) {
    const {
      index,
      attributes: { position },
    } = mesh.geometry;
    const all = index ? index.count : position.count;
    const end = Math.min(all, start + count);
    const bent = mesh.isSkinnedMesh || mesh.morphTargetInfluences;
    const v = new this.THREE.Vector3();
    const placesOf = (length, vertexAt) => {
      const places = new Float32Array(3 * length);
      for (let i = 0; i < length; ++i) mesh.getVertexPosition(vertexAt(i), v).toArray(places, 3 * i);
      return places;
    };
    if (start > 0 || end < all)
      return {
        positions: placesOf(3 * Math.max(0, Math.floor((end - start) / 3)), (i) => index?.getX(start + i) ?? start + i),
      };
    const plain = !bent && position.isBufferAttribute && position.array instanceof Float32Array;
    return { positions: plain ? position.array : placesOf(position.count, (i) => i), corners: index?.array };
  }
  // What the mesh of an object depends on, but for its pose.
  shapeOf(object, pose) {
    const from = this.toStageOf(pose);
    const to = new this.THREE.Matrix4();
    return this.meshesOf(object).flatMap((mesh) => [
      ...[mesh, ...(mesh.skeleton?.bones ?? [])].flatMap((one) => to.multiplyMatrices(from, one.matrixWorld).toArray()),
      ...(mesh.morphTargetInfluences ?? []),
      mesh.count ?? 1,
      mesh.instanceMatrix?.version ?? 0,
    ]);
  }
  cameraOf(camera) {
    const { position, rotation } = this.poseOf(camera);
    return { position, orientation: rotation, ...frustumOf(camera.projectionMatrix?.elements) };
  }

  // The material of a surface that shadows fall on. It stays as it is otherwise. With `shadowOnly` it is seen through but for
  // its shadows, as a real floor in the camera's picture: they leave of what is behind the share of the light that is left.
  receive(material, options = {}) {
    checked("receive", options, { shadowOnly: 0 });
    const { shadowOnly = false } = options;
    if (!k_lit.includes(material?.type))
      throw new Error(
        `sandglass: no shadow falls on a ${material?.type ?? "thing without a type"}. receive takes the material of a mesh, which three lights: a MeshStandardMaterial.`,
      );
    if (shadowOnly) material.transparent = true;
    const before = material.onBeforeCompile;
    const key = material.customProgramCacheKey();
    material.onBeforeCompile = (shader, renderer) => {
      before.call(material, shader, renderer);
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = shader.vertexShader
        .replace("#include <common>", "#include <common>\nvarying vec3 sandglass_world;")
        .replace(
          "#include <project_vertex>",
          "#include <project_vertex>\nsandglass_world = (modelMatrix * vec4(transformed, 1)).xyz;",
        );
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\nvarying vec3 sandglass_world;\n${receive}`)
        .replace(
          "#include <aomap_fragment>",
          `#include <aomap_fragment>
        vec3 sandglass_all = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
        vec2 sandglass_rest = sandglass_left(sandglass_world);
        reflectedLight.directDiffuse *= sandglass_rest.x, reflectedLight.directSpecular *= sandglass_rest.x;
        reflectedLight.indirectDiffuse *= sandglass_rest.y, reflectedLight.indirectSpecular *= sandglass_rest.y;`,
        );
      if (shadowOnly)
        shader.fragmentShader = shader.fragmentShader.replace(
          "#include <opaque_fragment>",
          `
        float sandglass_share = dot(reflectedLight.directDiffuse + reflectedLight.indirectDiffuse, vec3(1)) / max(dot(sandglass_all, vec3(1)), 1e-6);
        gl_FragColor = vec4(vec3(0), 1.0 - linearToOutputTexel(vec4(sandglass_share)).r);`,
        );
    };
    material.customProgramCacheKey = () => `${key} sandglass ${shadowOnly}`;
    material.needsUpdate = true;
    return material;
  }

  // Sand, as a Group in the scene. Options as for Stage.createSand.
  async createSand(options) {
    const { THREE, scene, renderer } = this;
    const mesh = new THREE.Mesh(
      new THREE.BufferGeometry(),
      new THREE.MeshBasicMaterial({ colorWrite: false, depthWrite: false }),
    );
    const eye = new THREE.Vector3();
    await this.newSand(options);
    mesh.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(9), 3));
    mesh.frustumCulled = false;
    mesh.onBeforeRender = (_renderer, _scene, camera) => {
      const target = renderer.getRenderTarget();
      const space = target ? (target.isXRRenderTarget ? target.texture.colorSpace : "") : renderer.outputColorSpace;
      this.sand.draw({
        view: camera.matrixWorldInverse.elements,
        projection: camera.projectionMatrix.elements,
        eye: eye.setFromMatrixPosition(camera.matrixWorld).toArray(),
        height: this.gl.getParameter(this.gl.VIEWPORT)[3],
        linear: space !== THREE.SRGBColorSpace,
        reversed: camera.reversedDepth,
      });
    };
    this.leaveSand();
    scene.add((this.group = new THREE.Group().add(mesh)));
    return this.group;
  }

  leaveSand() {
    const mesh = this.group?.children[0];
    this.group?.removeFromParent();
    mesh?.geometry.dispose();
    mesh?.material.dispose();
  }
  leave() {
    this.leaveSand();
    for (const one of [this.probe, this.sun, this.sun.target]) one.removeFromParent();
    // Materials get no shadows any more.
    for (const name of receivers) {
      this.uniforms[`sandglass_${name}`].value.dispose();
      this.uniforms[`sandglass_${name}`].value = null;
    }
    this.uniforms.sandglass_numbers.value.set(0, 0, 0, 0);
    this.uniforms.sandglass_occlusion_box.value.set(2, 2, 0, 0);
  }
  show(drawn, changed) {
    const { uniforms } = this;
    const { toLight, facing, radiance } = drawn.light;
    this.probe.sh.fromArray(radiance);
    this.sun.color.setRGB(...facing);
    this.sun.position.set(...toLight);
    for (const [name, value] of Object.entries(receiverValues(drawn))) uniforms[name].value.fromArray(value);
    for (const name of changed) {
      const { side, bytes } = drawn.textures[name];
      const uniform = uniforms[`sandglass_${name}`];
      if (uniform.value.image.width !== side) {
        uniform.value.dispose();
        uniform.value = this.texture(side, new Uint8Array(side * side));
      }
      uniform.value.image.data.set(bytes);
      uniform.value.needsUpdate = true;
    }
  }
}
