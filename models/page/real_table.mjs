// The sand on a table of the user's own: WebXR. A hit test finds the table, a tap puts the scene there, a finger pours.
// The light is the device's estimate; where the browser also gives the camera's picture, the library makes one beside it. Where
// it knows walls, objects cast on the nearest; where it knows depth, what is real hides what is behind it, and sand lies on it. The
// scene keeps the axes of the session's space, whose y is up.
import { frustumOf } from "./place_light.mjs";
import { depthOf } from "./webxr.mjs";
import { lightOfDevice } from "./room_light.mjs";

const k_required = ["local", "hit-test"];
const k_optional = ["light-estimation", "camera-access", "depth-sensing", "plane-detection"];
const k_depth = { usagePreference: ["cpu-optimized"], dataFormatPreference: ["luminance-alpha", "float32"] };
const k_wall_reach = 1.5; // metres from the table: farther walls show no shadow
const k_shrunk_width = 160; // pixels of the camera's picture, as the library gets it
const k_shrunk_every_ms = 250;
const k_least_depth = 16; // pixels a side; fewer show no heights

export class RealTable {
  // Throws what is missing.
  /** @param {import("./page.mjs").Page} page */
  static async start(page) {
    const { xr } = navigator;
    const { gl } = page.painter;
    if (!xr)
      throw new Error(
        "This browser has no WebXR, which would put the sand on a table of yours. Chrome on an Android phone with ARCore has it.",
      );
    if (!(await xr.isSessionSupported("immersive-ar")))
      throw new Error(
        "This device shows no augmented reality in the browser (WebXR's immersive-ar is missing). A phone with ARCore does.",
      );
    let session;
    try {
      session = await xr.requestSession("immersive-ar", {
        requiredFeatures: k_required,
        optionalFeatures: k_optional,
        depthSensing: k_depth,
      });
    } catch {
      throw new Error(
        "The browser did not start augmented reality: it needs the camera and the hit test (WebXR's hit-test). Allow the camera, or update the browser.",
      );
    }
    await gl.makeXRCompatible();
    const layer = new XRWebGLLayer(session, gl, { alpha: true });
    session.updateRenderState({ baseLayer: layer, depthNear: 0.05, depthFar: 12 });
    const space = await session.requestReferenceSpace("local");
    const viewer = await session.requestReferenceSpace("viewer");
    const hits = await session.requestHitTestSource({ space: viewer });
    const probe = await session.requestLightProbe?.().catch(() => null);
    return new RealTable(page, session, layer, space, hits, probe);
  }

  /** @param {import("./page.mjs").Page} page */
  constructor(page, session, layer, space, hits, probe) {
    this.page = page;
    Object.assign(this, {
      session,
      layer,
      space,
      hits,
      probe,
      table: null,
      placed: false,
      finger: null,
      before: null,
      shrunk: -Infinity,
    });
    page.real = this;
    page.stage.forget();
    session.addEventListener("selectstart", ({ inputSource }) => {
      if (this.placed) this.finger = inputSource;
      else if (this.table) {
        this.placed = true;
        page.stage.stand(this.table);
      }
    });
    session.addEventListener("selectend", () => {
      this.finger = null;
      page.at = null;
    });
    session.addEventListener("end", () => {
      page.at = null;
      page.real = null;
      page.painter.depthOnScreen = null;
      page.setWall(null);
      page.stage.forget();
      page.setLight();
    });
    const frame = (now, told) => {
      if (page.real !== this) return;
      session.requestAnimationFrame(frame);
      this.frame(now, told);
    };
    session.requestAnimationFrame(frame);
  }

  frame(now, told) {
    const { page, space } = this;
    const seconds = this.before === null ? 0 : Math.max(0, now - this.before) / 1e3;
    this.before = now;
    const pose = told.getViewerPose(space);
    if (!pose) return;
    if (!this.placed) {
      const hit = told.getHitTestResults(this.hits)[0]?.getPose(space);
      if (hit) this.table = [hit.transform.position.x, hit.transform.position.y, hit.transform.position.z];
    }
    this.takeWall(told);
    this.takeLight(now, told, pose);
    if (this.placed) {
      this.takeHeights(told, pose.views[0]);
      page.at = this.finger && this.pointed(told);
      page.advance(seconds);
    }
    this.draw(told, pose);
  }

  // The nearest upright plane; its polygon is given in its own x and z.
  takeWall(told) {
    const { page, space, table } = this;
    let nearest = null;
    let least = k_wall_reach;
    for (const plane of table ? (told.detectedPlanes ?? []) : []) {
      const matrix = plane.orientation === "vertical" ? told.getPose(plane.planeSpace, space)?.transform.matrix : null;
      if (!matrix) continue;
      const pose = Float32Array.from(matrix, (x, i) => (i >= 12 && i < 15 ? x - table[i - 12] : x));
      const away = -[4, 5, 6].reduce((sum, k) => sum + pose[k] * pose[8 + k], 0);
      if (away > 0 && away < least) {
        least = away;
        nearest = { pose, polygon: [...plane.polygon] };
      }
    }
    const side = (pick) => ["x", "z"].map((axis) => pick(...nearest.polygon.map((corner) => corner[axis])));
    if (nearest) page.setWall(nearest.pose, side(Math.min), side(Math.max));
    else page.setWall(null);
  }

  // The depth of what the camera shows, for the painter. `normDepthBufferFromNormView` counts from the upper left corner.
  takeDepth(told, view) {
    const { painter } = this.page;
    const depth = told.getDepthInformation?.(view);
    if (!depth) {
      painter.depthOnScreen = null;
      return;
    }
    const raw = this.session.depthDataFormat === "float32" ? new Float32Array(depth.data) : new Uint16Array(depth.data);
    const m = depth.normDepthBufferFromNormView.matrix;
    painter.uploadDepth(
      depth.width,
      depth.height,
      Float32Array.from(raw, (x) => x * depth.rawValueToMeters),
      [m[0], m[1], 0, -m[4], -m[5], 0, m[12] + m[4], m[13] + m[5], 1],
    );
  }

  // What stands on the table, for the sand.
  takeHeights(told, view) {
    const depth = view && told.getDepthInformation?.(view);
    if (!depth?.data || Math.min(depth.width, depth.height) < k_least_depth) return;
    const image = depthOf(depth, view);
    this.page.stage.seeDepth({ ...image, position: image.position.map((x, k) => x - this.table[k]) });
  }

  takeLight(now, told, pose) {
    const { page } = this;
    const estimate = this.probe && told.getLightEstimate?.(this.probe);
    const { camera, projectionMatrix: projection, transform } = pose.views[0] ?? {};
    if (estimate) page.deviceLight = lightOfDevice(estimate);
    if (camera && typeof XRWebGLBinding !== "undefined" && now - this.shrunk > k_shrunk_every_ms) {
      this.shrunk = now;
      this.binding ??= new XRWebGLBinding(this.session, page.painter.gl);
      const width = k_shrunk_width;
      const height = Math.round((width * projection[0]) / projection[5]);
      const data = page.painter.shrink(this.binding.getCameraImage(camera), width, height);
      page.stage.see(
        { data, width, height },
        { orientation: page.room.orientationOf(transform.matrix), ...frustumOf(projection), ms: now },
      );
    }
    page.setLight();
  }

  // Where the finger's ray meets the table, in the scene's coordinates.
  pointed(told) {
    const pose = told.getPose(this.finger.targetRaySpace, this.space);
    if (!pose) return null;
    const m = pose.transform.matrix;
    const [x, y, z] = [0, 1, 2].map((k) => m[12 + k] - this.table[k]);
    const along = m[9] > 0.02 ? y / m[9] : -1;
    const at = [x - along * m[8], 0, z - along * m[10]];
    return along > 0 && Math.hypot(...at) < 1.2 ? at : null;
  }

  draw(told, pose) {
    const { page, layer } = this;
    const { painter } = page;
    const { gl } = painter;
    const [x, y, z] = this.table ?? [0, 0, 0];
    page.takeDrawn();
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!this.table) return;
    for (const view of pose.views) {
      this.takeDepth(told, view);
      const matrix = Float32Array.from(view.transform.inverse.matrix);
      const port = layer.getViewport(view);
      const at = view.transform.position;
      for (let k = 0; k < 3; ++k) matrix[12 + k] += matrix[k] * x + matrix[4 + k] * y + matrix[8 + k] * z;
      painter.paint({
        view: matrix,
        projection: view.projectionMatrix,
        eye: [at.x - x, at.y - y, at.z - z],
        viewport: [port.x, port.y, port.width, port.height],
        real: true,
      });
    }
  }
}
