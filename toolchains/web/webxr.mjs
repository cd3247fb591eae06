// What WebXR tells of hands, of the room and of depth, as a stage takes it; and a picture of a headset's camera.
import { checked, numbersOf } from "./options.mjs";

const k_depth_pixels = { 2: Uint16Array, 4: Float32Array }; // by their bytes
const k_lens = { focal: 2, centre: 2, position: 3, orientation: 4 };
const k_straight = 1e-3; // how far a depth image's axes may be from square

// The left hand and the right: of each its joints, or null where one of them is lost.
export const handJoints = (frame, space) =>
  ["left", "right"].map((side) => {
    const source = [...frame.session.inputSources].find(({ hand, handedness }) => hand && handedness === side);
    const joints = [...(source?.hand.values() ?? [])].map((joint) => frame.getJointPose(joint, space));
    if (joints.length === 0 || !joints.every((pose) => pose?.radius > 0)) return null;
    return joints.map(({ transform: { position }, radius }) => ({ position, radius }));
  });

// How a camera with a known lens saw that is at `position`, `orientation` from the viewer and looks along -z; `size`: of the picture
// that `focal` and `centre` are pixels of.
export function viewThrough(viewer, lens, size) {
  if (!viewer?.orientation)
    throw new Error("sandglass: seeThrough takes a picture, and where the viewer was then: an XRRigidTransform.");
  const needed = ["focal", "centre"];
  const given = { position: [0, 0, 0], orientation: [0, 0, 0, 1], ...lens };
  const { focal, centre, position: p, orientation: o } = checked("seeThrough", given, k_lens, { needed, reach: 1e6 });
  if (!(Math.min(...focal) > 0)) throw new Error("sandglass: seeThrough needs focal lengths above 0, in pixels.");
  const [x, y, z, w] = numbersOf(viewer.orientation, 4);
  const [tx, ty, tz] = [y * p[2] - z * p[1], z * p[0] - x * p[2], x * p[1] - y * p[0]].map((c) => 2 * c);
  const turned = [p[0] + w * tx + y * tz - z * ty, p[1] + w * ty + z * tx - x * tz, p[2] + w * tz + x * ty - y * tx];
  const [across, up] = centre.map((c, k) => (2 * c + 1) / size[k] - 1);
  return {
    position: numbersOf(viewer.position, 3).map((c, k) => c + turned[k]),
    orientation: [
      w * o[0] + x * o[3] + y * o[2] - z * o[1],
      w * o[1] - x * o[2] + y * o[3] + z * o[0],
      w * o[2] + x * o[1] - y * o[0] + z * o[3],
      w * o[3] - x * o[0] - y * o[1] - z * o[2],
    ],
    diagonal: (360 / Math.PI) * Math.atan(Math.hypot(size[0] / focal[0], size[1] / focal[1]) / 2),
    centre: [-across, up],
  };
}

// Of the room: by each XRMesh or XRPlane its pose and triangles, and when they changed.
export function roomOf(frame, space) {
  const meshes = [...(frame.detectedMeshes ?? [])];
  const all = meshes.length > 0 ? meshes : [...(frame.detectedPlanes ?? [])];
  const found = new Map();
  for (const one of all) {
    const { position: p, orientation: q } = frame.getPose(one.meshSpace ?? one.planeSpace, space)?.transform ?? {};
    const pose = p && { position: [p.x, p.y, p.z], rotation: [q.x, q.y, q.z, q.w] };
    const mesh = one.polygon ? fan(one.polygon) : { positions: one.vertices, indices: one.indices };
    found.set(one, { pose, mesh, changed: one.lastChangedTime });
  }
  return found;
}
const fan = (corners) => ({
  positions: Float32Array.from(corners.flatMap(({ x, y, z }) => [x, y, z])),
  indices: Uint32Array.from(corners.slice(2).flatMap((_, i) => [0, i + 1, i + 2])),
});

// A depth image as its own camera took it: how its columns and rows lie in the view is in normDepthBufferFromNormView, and it may have
// a pose and a projection of its own. Depth is along the camera's axis.
export function depthOf(depth, view) {
  const { width, height, rawValueToMeters, normDepthBufferFromNormView } = depth;
  const { transform, projectionMatrix } = depth.projectionMatrix && depth.transform ? depth : (view ?? {});
  const Kind = k_depth_pixels[depth.data?.byteLength / (width * height)];
  if (!depth.data)
    throw new Error(
      "sandglass: seeDepth cannot read a texture. Ask the session for depthSensing with cpu-optimized, or read it back and pass { data, " +
        "width, height, rawValueToMeters, normDepthBufferFromNormView }.",
    );
  if (!Kind || !transform || !projectionMatrix || !normDepthBufferFromNormView)
    throw new Error(
      "sandglass: seeDepth takes what frame.getDepthInformation(view) gives, with 2 or 4 bytes a pixel, and that view.",
    );
  const { 0: a, 1: b, 4: c, 5: d, 12: e, 13: f } = normDepthBufferFromNormView.matrix;
  const { 0: px, 5: py, 8: cx, 9: cy } = projectionMatrix;
  const area = a * d - b * c;
  // What a pixel to the right, and one down, are in the plane at one metre before the camera, y up.
  const right = [(2 * d) / (area * width * px), (2 * b) / (area * width * py)];
  const down = [(-2 * c) / (area * height * px), (-2 * a) / (area * height * py)];
  const [columns, rows] = [Math.hypot(...right), Math.hypot(...down)];
  const [cos, sin] = right.map((x) => x / columns);
  const [x, y] = down.map((one) => one / rows);
  if (!(Math.abs(cos * x + sin * y) < k_straight && sin * x - cos * y > 0))
    throw new Error("sandglass: seeDepth takes a depth image that is turned and scaled, not mirrored or sheared.");
  const [u, v] = [(1 - cx) / 2, (1 + cy) / 2]; // where the camera's axis meets the view
  const { orientation: q, position: p } = transform;
  const [s, w] = [Math.sin(Math.atan2(sin, cos) / 2), Math.cos(Math.atan2(sin, cos) / 2)];
  return {
    data: new Kind(depth.data.buffer ?? depth.data, depth.data.byteOffset ?? 0, width * height),
    width,
    height,
    toMetres: rawValueToMeters,
    focal: [1 / columns, 1 / rows],
    centre: [(a * u + c * v + e) * width - 0.5, (b * u + d * v + f) * height - 0.5],
    position: [p.x, p.y, p.z],
    orientation: [q.x * w + q.y * s, q.y * w - q.x * s, q.z * w + q.w * s, q.w * w - q.z * s],
  };
}
