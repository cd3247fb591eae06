// sandglass/babylon: a stage in a scene of Babylon.js, right-handed or left-handed, which the app hands over; nothing is
// imported of it. In a left-handed scene the stage's z is the scene's -z.
import { Engine, oneMesh } from "./engine.mjs";
import { checked } from "./options.mjs";
import { frustumOf } from "./place_light.mjs";
import { receive, receivers, receiverValues } from "./glsl.mjs";

const k_vectors = [
  "sandglass_pile_box",
  "sandglass_shadow_box",
  "sandglass_occlusion_box",
  "sandglass_numbers",
  "sandglass_to_light",
];

// `scene` is needed; `worker`: the stage runs in a Worker; else options of Stage.create.
export async function createStage(BABYLON, { scene, ...options } = {}) {
  const engine = scene?.getEngine();
  if (!(engine?.webGLVersion >= 2))
    throw new Error(
      "sandglass: createStage needs a scene of an Engine with WebGL 2; WebGPUEngine has other shaders. Pass { scene: new Scene(new Engine(canvas)) }.",
    );
  return new BabylonStage(BABYLON, scene, await Engine.stageOf(options));
}

class BabylonStage extends Engine {
  constructor(BABYLON, scene, stage) {
    super(stage, scene.getEngine()._gl);
    Object.assign(this, {
      BABYLON,
      scene,
      z: scene.useRightHandedSystem ? 1 : -1,
      sun: new BABYLON.DirectionalLight("sandglass", new BABYLON.Vector3(0, -1, 0), scene),
      vectors: {},
      placing: "computeWorldMatrix",
    });
    // The engine takes harmonics from a cube map; this one is black, so that nothing is reflected.
    this.around = new BABYLON.RawCubeTexture(
      scene,
      Array.from({ length: 6 }, () => new Uint8Array([0, 0, 0, 255])),
      1,
    );
    scene.environmentTexture ??= this.around;
    this.textures = Object.fromEntries(
      receivers.map((name) => [
        name,
        this.texture(1, new Uint8Array([name === "occlusion" || name === "sky" ? 255 : 0])),
      ]),
    );
    for (const name of k_vectors) this.vectors[name] = [0, 0, 0, 0];
    this.vectors.sandglass_occlusion_box = [2, 2, 0, 0];
    this.Receiver = this.receiver();
  }
  texture(side, bytes) {
    const { RawTexture, Constants } = this.BABYLON;
    const made = RawTexture.CreateRTexture(
      bytes,
      side,
      side,
      this.scene,
      false,
      false,
      Constants.TEXTURE_BILINEAR_SAMPLINGMODE,
      Constants.TEXTURETYPE_UNSIGNED_BYTE,
    );
    made.wrapU = made.wrapV = Constants.TEXTURE_CLAMP_ADDRESSMODE;
    return made;
  }
  mirrored([x, y, z]) {
    return [x, y, this.z * z];
  }

  poseOf(object) {
    const { Vector3, Quaternion } = this.BABYLON;
    const position = new Vector3();
    const rotation = new Quaternion();
    object.computeWorldMatrix(true).decompose(new Vector3(), rotation, position);
    return {
      position: this.mirrored(position.asArray()),
      rotation: [this.z * rotation.x, this.z * rotation.y, rotation.z, rotation.w],
    };
  }
  isShown(object) {
    return !object.isDisposed() && object.isEnabled() && object.isVisible !== false && object.getScene() === this.scene;
  }
  // The meshes of an object that are seen where it is: no hidden child, and no lines.
  meshesOf(object) {
    const isSeen = (mesh) => {
      let one = mesh;
      for (; one !== object && one.isEnabled(false); one = one.parent);
      return one === object && mesh.isVisible;
    };
    return [object, ...object.getChildMeshes(false).filter(isSeen)].filter(
      (mesh) => mesh.getTotalVertices?.() && !/Lines/.test(mesh.getClassName()),
    );
  }
  toStageOf({ position, rotation }) {
    const { Vector3, Matrix, Quaternion } = this.BABYLON;
    const pose = Matrix.Compose(Vector3.One(), Quaternion.FromArray(rotation), Vector3.FromArray(position));
    return Matrix.Scaling(1, 1, this.z).multiply(pose.invert());
  }
  meshOf(object, pose) {
    const to_stage = this.toStageOf(pose);
    const parts = this.meshesOf(object).flatMap((mesh) => {
      const positions = mesh.getPositionData(true, true);
      const corners = mesh.getIndices();
      const to = mesh.computeWorldMatrix(true).multiply(to_stage);
      const copies = mesh.thinInstanceCount
        ? mesh.thinInstanceGetWorldMatrices().slice(0, mesh.thinInstanceCount)
        : null;
      return (copies?.map((copy) => copy.multiply(to)) ?? [to]).map(({ m: matrix }) => ({
        positions,
        corners,
        matrix,
      }));
    });
    return oneMesh(parts);
  }
  // What the mesh of an object depends on, but for its pose.
  shapeOf(object, pose) {
    const to_stage = this.toStageOf(pose);
    return this.meshesOf(object).flatMap((mesh) => [
      ...mesh.computeWorldMatrix(true).multiply(to_stage).m,
      ...(mesh.skeleton?.getTransformMatrices(mesh) ?? []),
      ...(mesh.morphTargetManager?.influences ?? []),
      mesh.thinInstanceCount ?? 0,
    ]);
  }
  // Column-major matrices of a camera that looks along -z of the stage's world.
  matricesOf(camera) {
    const view = [...camera.getViewMatrix().m];
    const projection = [...camera.getProjectionMatrix().m];
    if (this.z < 0) for (let i = 0; i < 16; ++i) if ((i % 4 === 2) !== (i >> 2 === 2)) view[i] = -view[i];
    if (this.z < 0) for (let i = 8; i < 12; ++i) projection[i] = -projection[i];
    return { view, projection };
  }
  cameraOf(camera) {
    const { Matrix, Quaternion } = this.BABYLON;
    const { view, projection } = this.matricesOf(camera);
    const orientation = Quaternion.FromRotationMatrix(Matrix.FromArray(view).invert().getRotationMatrix()).asArray();
    return { position: this.mirrored(camera.globalPosition.asArray()), orientation, ...frustumOf(projection) };
  }

  // A plugin of materials: what the library says is left of the light.
  receiver() {
    const stage = this;
    const place = this.z < 0 ? "vec3(vPositionW.xy, -vPositionW.z)" : "vPositionW";
    return class extends this.BABYLON.MaterialPluginBase {
      constructor(material, shadowOnly) {
        super(material, "SandglassReceiver", 200, { SANDGLASS_VECTORS_DECLARED: false, SANDGLASS_SHADOW_ONLY: false });
        this.shadowOnly = shadowOnly;
        this._enable(true);
      }
      getClassName() {
        return "SandglassReceiver";
      }
      prepareDefines(defines) {
        defines.SANDGLASS_VECTORS_DECLARED = true;
        defines.SANDGLASS_SHADOW_ONLY = this.shadowOnly;
      }
      getSamplers(samplers) {
        samplers.push(...receivers.map((name) => `sandglass_${name}`));
      }
      getUniforms() {
        return {
          ubo: k_vectors.map((name) => ({ name, size: 4, type: "vec4" })),
          fragment: k_vectors.map((name) => `uniform vec4 ${name};`).join("\n"),
        };
      }
      bindForSubMesh(buffer) {
        for (const name of k_vectors) buffer.updateFloat4(name, ...stage.vectors[name]);
        for (const name of receivers) buffer.setTexture(`sandglass_${name}`, stage.textures[name]);
      }
      getCustomCode(kind) {
        return kind !== "fragment"
          ? null
          : {
              CUSTOM_FRAGMENT_DEFINITIONS: receive,
              CUSTOM_FRAGMENT_BEFORE_FINALCOLORCOMPOSITION: `
          vec2 sandglass_rest = sandglass_left(${place});
          vec3 sandglass_all = finalDiffuse, sandglass_some = finalDiffuse *= sandglass_rest.x;
          #ifdef SPECULARTERM
          finalSpecularScaled *= sandglass_rest.x;
          #endif
          #ifdef REFLECTION
          sandglass_all += finalIrradiance, sandglass_some += finalIrradiance *= sandglass_rest.y, finalRadianceScaled *= sandglass_rest.y;
          #endif`,
              CUSTOM_FRAGMENT_BEFORE_FRAGCOLOR: `
          #ifdef SANDGLASS_SHADOW_ONLY
          float sandglass_share = dot(sandglass_some, vec3(1)) / max(dot(sandglass_all, vec3(1)), 1e-6);
          #ifndef IMAGEPROCESSINGPOSTPROCESS
          sandglass_share = pow(sandglass_share, 1.0 / 2.2);
          #endif
          finalColor = vec4(vec3(0), 1.0 - sandglass_share);
          #endif`,
            };
      }
    };
  }
  // The material of a surface that shadows fall on. It stays as it is otherwise. With `shadowOnly` it is seen through but for
  // its shadows, as a real floor in the camera's picture.
  receive(material, options = {}) {
    checked("receive", options, { shadowOnly: 0 });
    const { shadowOnly = false } = options;
    const kind = material?.getClassName?.() ?? "thing without a class name";
    if (!/^PBR/.test(kind))
      throw new Error(
        `sandglass: no shadow falls on a ${kind}: Babylon.js does not light it by harmonics. Take a PBRMaterial.`,
      );
    if (shadowOnly) material.transparencyMode = 2; // MATERIAL_ALPHABLEND
    new this.Receiver(material, shadowOnly);
    return material;
  }

  // Sand, drawn before the scene's meshes. Options as for Stage.createSand.
  async createSand(options) {
    await this.newSand(options);
    this.drawing ??= this.scene.onBeforeDrawPhaseObservable.add(() => {
      const { scene, gl } = this;
      const camera = scene.activeCamera;
      this.sand.draw({
        ...this.matricesOf(camera),
        eye: this.mirrored(camera.globalPosition.asArray()),
        height: gl.getParameter(gl.VIEWPORT)[3],
        linear: scene.imageProcessingConfiguration.applyByPostProcess,
        reversed: scene.getEngine().useReverseDepthBuffer,
      });
    });
  }

  leave() {
    if (this.scene.environmentTexture === this.around) this.scene.environmentTexture = null;
    for (const one of [this.around, this.sun, ...Object.values(this.textures)]) one.dispose();
    Object.assign(this.vectors, { sandglass_numbers: [0, 0, 0, 0], sandglass_occlusion_box: [2, 2, 0, 0] }); // no shadows
    this.scene.onBeforeDrawPhaseObservable.remove(this.drawing);
  }
  show(drawn, changed) {
    const { BABYLON, around, sun } = this;
    const { toLight, facing, ambient } = drawn.light;
    // The engine's vectors have their z reversed, in scenes of both hands. The terms are those that it would make of harmonics.
    const harmonics = BABYLON.SphericalHarmonics.FromArray(
      Array.from({ length: 9 }, (_, k) => ambient.slice(3 * k, 3 * k + 3).map((x) => ([2, 5, 7].includes(k) ? -x : x))),
    );
    harmonics.preScaled = true;
    around.sphericalPolynomial = BABYLON.SphericalPolynomial.FromHarmonics(harmonics);
    sun.direction = BABYLON.Vector3.FromArray(this.mirrored(toLight)).negate();
    sun.diffuse = BABYLON.Color3.FromArray(facing);
    sun.specular = sun.diffuse;
    Object.assign(this.vectors, receiverValues(drawn));
    for (const name of changed) {
      const { side, bytes } = drawn.textures[name];
      if (this.textures[name].getSize().width !== side) {
        this.textures[name].dispose();
        this.textures[name] = this.texture(side, bytes.slice());
      } else this.textures[name].update(bytes.slice());
    }
  }
}
