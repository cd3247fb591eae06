// Reads the triangles of a glTF 2.0 file: .glb, or .gltf whose buffers stand in the file. Places are those of the default
// scene, with its nodes' transforms. Materials, skins and morphs are passed over. Every number of the file is checked
// before it is used; what cannot be read is refused with one sentence.
const k_glb = 0x46546c67, k_json = 0x4e4f534a, k_bin = 0x004e4942;
const k_items_at_most = 1 << 22;  // vertices or indices of a mesh
const k_float = 5126, k_index_types = { 5121: [1, "getUint8"], 5123: [2, "getUint16"], 5125: [4, "getUint32"] };
const k_triangles = 4, k_strip = 5, k_fan = 6;
const k_still = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];  // column by column

const cannot = (what, help = "Export it again.") => { throw new Error(`The file is no glTF that this page reads: ${what}. ${help}`); };
const whole = (value, most, what) => (Number.isInteger(value) && value >= 0 && value <= most ? value : cannot(what));
const item = (list, index, what) => (Array.isArray(list) && Number.isInteger(index) && index >= 0 && index < list.length &&
  typeof list[index] === "object" && list[index] !== null ? list[index] : cannot(what));
const numbers = (list, count, what) => (Array.isArray(list) && list.length === count && list.every(Number.isFinite) ? list : cannot(what));

function parsed(bytes) {
  try {
    const file = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
    if (typeof file === "object" && file !== null) return file;
  } catch {}
  return cannot("its description is damaged");
}

// The description, and the binary chunk of a .glb.
function opened(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 12 || view.getUint32(0, true) !== k_glb) return { file: parsed(bytes), binary: null };
  if (view.getUint32(4, true) !== 2 || view.getUint32(8, true) > bytes.length) cannot("it is cut off, or of another version");
  let at = 12, file = null, binary = null;
  const end = view.getUint32(8, true);
  while (at + 8 <= end) {
    const length = view.getUint32(at, true), kind = view.getUint32(at + 4, true);
    if (length > end - at - 8) cannot("it is cut off");
    const chunk = bytes.subarray(at + 8, at + 8 + length);
    if (kind === k_json) file ??= parsed(chunk);
    if (kind === k_bin) binary ??= chunk;
    at += 8 + length;
  }
  return { file: file ?? cannot("it has no description"), binary };
}

function bufferBytes({ file, binary }, index) {
  const { uri } = item(file.buffers, index, "a buffer is missing");
  if (uri === undefined && index === 0 && binary) return binary;
  const found = typeof uri === "string" && /^data:[^,]*;base64,([A-Za-z0-9+/=\s]*)$/.exec(uri);
  if (!found) cannot("its data lies in another file", "Export it as .glb, in one file.");
  try { return Uint8Array.from(atob(found[1]), (c) => c.charCodeAt(0)); } catch { return cannot("a buffer is damaged"); }
}

// A function that reads number `k` of item `i`, and the number of items.
function accessor(gltf, index, parts, types) {
  const { file, buffers } = gltf, what = "an accessor is wrong", a = item(file.accessors, index, "an accessor is missing");
  if (a.sparse !== undefined) cannot("it has sparse data", "Export it without.");
  const type = types[a.componentType] ?? cannot("places must be floats, and indices whole numbers");
  if (a.type !== (parts === 3 ? "VEC3" : "SCALAR")) cannot(what);
  const count = whole(a.count, k_items_at_most, "it has too many vertices"), size = parts * type[0];
  const v = item(file.bufferViews, a.bufferView, "a buffer view is missing");
  if (!buffers.has(v.buffer)) buffers.set(v.buffer, bufferBytes(gltf, v.buffer));
  const all = buffers.get(v.buffer), offset = whole(v.byteOffset ?? 0, all.length, what), length = whole(v.byteLength, all.length - offset, what);
  const first = whole(a.byteOffset ?? 0, length, what), stride = whole(v.byteStride ?? size, 252, what);
  if (stride < size || (count > 0 && first + stride * (count - 1) + size > length)) cannot("an accessor reaches beyond its data");
  const view = new DataView(all.buffer, all.byteOffset + offset + first, length - first);
  return { count, read: (i, k = 0) => view[type[1]](i * stride + k * type[0], true) };
}

const product = (a, b) => k_still.map((_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + a[i % 4 + 4 * k] * b[k + 4 * (i >> 2)], 0));

function transform(node) {
  if (node.matrix !== undefined) return numbers(node.matrix, 16, "a node's matrix is wrong");
  const [x, y, z, w] = numbers(node.rotation ?? [0, 0, 0, 1], 4, "a node's rotation is wrong");
  const s = numbers(node.scale ?? [1, 1, 1], 3, "a node's scale is wrong"), t = numbers(node.translation ?? [0, 0, 0], 3, "a node's place is wrong");
  return [s[0] * (1 - 2 * (y * y + z * z)), s[0] * 2 * (x * y + w * z), s[0] * 2 * (x * z - w * y), 0,
    s[1] * 2 * (x * y - w * z), s[1] * (1 - 2 * (x * x + z * z)), s[1] * 2 * (y * z + w * x), 0,
    s[2] * 2 * (x * z + w * y), s[2] * 2 * (y * z - w * x), s[2] * (1 - 2 * (x * x + y * y)), 0, ...t, 1];
}

function addPrimitive(gltf, primitive, matrix, out) {
  const mode = primitive?.mode ?? k_triangles;
  if (![k_triangles, k_strip, k_fan].includes(mode)) return;
  if (typeof primitive.attributes !== "object" || primitive.attributes === null) cannot("a mesh has no vertices");
  const places = accessor(gltf, primitive.attributes.POSITION, 3, { [k_float]: [4, "getFloat32"] }), first = out.vertices.length / 3;
  const listed = primitive.indices === undefined ? { count: places.count, read: (i) => i } : accessor(gltf, primitive.indices, 1, k_index_types);
  if (first + places.count > k_items_at_most || out.indices.length + 3 * listed.count > k_items_at_most) cannot("it has too many vertices", "Choose a smaller mesh.");
  for (let i = 0; i < places.count; ++i) {
    const [x, y, z] = [0, 1, 2].map((k) => places.read(i, k));
    for (let k = 0; k < 3; ++k) out.vertices.push(matrix[k] * x + matrix[4 + k] * y + matrix[8 + k] * z + matrix[12 + k]);
  }
  const corner = (i) => { const at = listed.read(i); return at < places.count ? first + at : cannot("a triangle is of vertices that are not there"); };
  const count = mode === k_triangles ? Math.floor(listed.count / 3) : Math.max(0, listed.count - 2);
  for (let i = 0; i < count; ++i) {
    const [a, b, c] = mode === k_triangles ? [3 * i, 3 * i + 1, 3 * i + 2] : mode === k_fan ? [0, i + 1, i + 2] : [i, i + 1 + i % 2, i + 2 - i % 2];
    out.indices.push(corner(a), corner(b), corner(c));
  }
}

export function readGltf(bytes) {
  const gltf = { ...opened(bytes), buffers: new Map() }, { file } = gltf, out = { vertices: [], indices: [] };
  if (!/^2\./.test(file.asset?.version ?? "")) cannot("it is of another version than 2");
  if (Array.isArray(file.extensionsRequired) && file.extensionsRequired.some((name) => /draco|meshopt|quantization/.test(name)))
    cannot("it is compressed", "Export it without compression.");
  const visited = new Set();
  const visit = (index, above) => {
    const node = item(file.nodes, index, "a node is missing");
    if (visited.has(index)) cannot("a node stands below itself or twice");
    visited.add(index);
    const matrix = product(above, transform(node));
    if (node.mesh !== undefined) {
      const { primitives } = item(file.meshes, node.mesh, "a mesh is missing");
      if (!Array.isArray(primitives)) cannot("a mesh is empty");
      for (const primitive of primitives) addPrimitive(gltf, primitive, matrix, out);
    }
    return { children: node.children ?? [], matrix };
  };
  const roots = Array.isArray(file.scenes) ? item(file.scenes, file.scene ?? 0, "the scene is missing").nodes ?? [] : (Array.isArray(file.nodes) ? file.nodes.map((_, i) => i) : []);
  // With a stack of its own: files may nest deeper than calls do.
  const open = (Array.isArray(roots) ? roots : cannot("the scene is wrong")).map((index) => [index, k_still]);
  while (open.length > 0) {
    const [index, above] = open.pop();
    if (!Array.isArray(file.scenes) && visited.has(index)) continue;
    const { children, matrix } = visit(index, above);
    if (!Array.isArray(children)) cannot("a node is wrong");
    for (const child of children) open.push([child, matrix]);
  }
  if (out.indices.length === 0) cannot("it has no triangles", "Choose a mesh with triangles.");
  const vertices = new Float32Array(out.vertices);
  if (!vertices.every(Number.isFinite)) cannot("a vertex is not finite");
  return { vertices, indices: new Uint32Array(out.indices) };
}
