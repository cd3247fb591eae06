// A WebXR device as the page's test drives it: one view that looks down at a table, a hit on it, a light, a camera's
// picture, a finger, a wall behind the table, and depth. emulated.step() runs a frame.
window.emulated = (() => {
  const rigid = ([x, y, z], pitch = 0) => {
    const [c, s] = [Math.cos(pitch), Math.sin(pitch)];
    const orientation = { x: -Math.sin(pitch / 2), y: 0, z: 0, w: Math.cos(pitch / 2) };
    return { position: { x, y, z, w: 1 }, orientation, matrix: new Float32Array([1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0, x, y, z, 1]),
      inverse: { matrix: new Float32Array([1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, -x, -(c * y - s * z), -(s * y + c * z), 1]) } };
  };
  const made = { table: [0.1, 0.45, -0.2], eye: [0.1, 1.1, 0.9], asked: null, now: performance.now(), camera: {}, walls: [], depths: null, finger: null, box: null };
  const { gl } = sandglassPage.page.painter, pitch = Math.atan2(made.eye[1] - made.table[1], made.eye[2] - made.table[2]);
  const view = { transform: rigid(made.eye, pitch), projectionMatrix: new Float32Array([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1.01, -1, 0, 0, -0.1, 0]), camera: made.camera };
  const level = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
  // The table with a box on it, which ends at `low` and `high` of x and z from the table's middle: along the view's axis, in millimetres.
  const depthsOfBox = () => {
    const side = 120, { matrix: m } = view.transform, { low, high, height } = made.box, depths = new Uint16Array(side * side);
    for (let i = 0; i < depths.length; ++i) {
      const [x, y] = [((i % side) + 0.5) / side - 0.5, 0.5 - (Math.floor(i / side) + 0.5) / side];
      const d = [0, 1, 2].map((k) => m[k] * x + m[4 + k] * y - m[8 + k]), o = [0, 1, 2].map((k) => m[12 + k] - made.table[k]);
      const hits = [0, 1, 2].map((k) => [((k === 1 ? 0 : low[k >> 1]) - o[k]) / d[k], ((k === 1 ? height : high[k >> 1]) - o[k]) / d[k]].sort((a, b) => a - b));
      const [enter, leave] = [Math.max(...hits.map(([a]) => a)), Math.min(...hits.map(([, b]) => b))], floor = -o[1] / d[1];
      const far = enter > 0 && enter < leave ? enter : floor > 0 ? floor : 0;
      depths[i] = far < 4 ? Math.round(1000 * far) + ((i + made.images) % 2) : 0;
    }
    return depths.buffer;
  };
  made.images = 0;
  made.above = (x, z) => { made.finger = rigid([made.table[0] + x, made.table[1] + 0.5, made.table[2] + z], Math.PI / 2); };
  const frame = {
    getViewerPose: () => ({ views: [view], transform: view.transform }),
    getHitTestResults: () => [{ getPose: () => ({ transform: rigid(made.table) }) }],
    getLightEstimate: () => ({ sphericalHarmonicsCoefficients: Float32Array.from({ length: 27 }, (_, i) => ([1, 2, 3, -0.6][i] ?? 0)  /* red comes from above */),
      primaryLightDirection: { x: 0, y: 3, z: 4, w: 0 }, primaryLightIntensity: { x: Math.PI, y: Math.PI, z: 0 } }),
    // The finger points at the middle of the picture. The wall stands 0.35 m behind the table's middle and faces the viewer.
    getPose: (of) => ({ transform: of.isWall ? { matrix: new Float32Array([1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0.1, 0.45, -0.55, 1]) } : (made.finger ?? view.transform) }),
    get detectedPlanes() { return made.walls; },
    // Two columns: metres in millimetres, left and right.
    getDepthInformation: () => made.box ? { width: 120, height: 120, rawValueToMeters: 0.001, data: depthsOfBox(), normDepthBufferFromNormView: { matrix: level } } : made.depths && { width: 2, height: 1, rawValueToMeters: 0.001, data: Uint16Array.from(made.depths).buffer,
      normDepthBufferFromNormView: { matrix: level } },
  };
  made.wall = { orientation: "vertical", planeSpace: { isWall: true }, polygon: [[-1, -1], [1, -1], [1, 0], [-1, 0]].map(([x, z]) => ({ x, z })) };
  class Session extends EventTarget {
    requestAnimationFrame(run) { this.next = run; }
    updateRenderState(state) { made.state = state; }
    async requestReferenceSpace(kind) { return { kind }; }
    async requestHitTestSource() { return {}; }
    async requestLightProbe() { return {}; }
  }
  made.session = new Session();
  made.select = (kind) => made.session.dispatchEvent(Object.assign(new Event(kind), { inputSource: { targetRaySpace: {} } }));
  made.step = (count = 1) => {
    for (let i = 0; i < count; ++i) {
      made.now += 1000 / 60;
      const [x, y, z] = made.eye, sway = made.box ? 0.01 : 0;  // of a hand
      view.transform = rigid([x + sway * Math.sin(++made.images), y + sway * Math.cos(1.7 * made.images), z], pitch);
      made.session.next(made.now, frame);
    }
  };
  // Shares of the picture: nothing drawn, shadow on what is real, the scene itself.
  made.pixels = () => {
    const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight], all = new Uint8Array(4 * w * h), count = { nothing: 0, shadow: 0, scene: 0 };
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
    for (let i = 3; i < all.length; i += 4) ++count[all[i] < 3 ? "nothing" : all[i] < 255 ? "shadow" : "scene"];
    return count;
  };
  WebGL2RenderingContext.prototype.makeXRCompatible = async () => {};
  window.XRWebGLLayer = class { framebuffer = null; getViewport() { return { x: 0, y: 0, width: gl.drawingBufferWidth, height: gl.drawingBufferHeight }; } };
  window.XRWebGLBinding = class {
    getCameraImage() {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([200, 40, 40, 255]));
      for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
      return texture;
    }
  };
  Object.defineProperty(navigator, "xr", { configurable: true, value: {
    isSessionSupported: async (mode) => mode === "immersive-ar",
    requestSession: async (mode, wanted) => { made.asked = { mode, ...wanted }; return made.session; },
  } });
  return made;
})();
