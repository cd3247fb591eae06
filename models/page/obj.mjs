// Reads the triangles of a Wavefront OBJ file. Polygons become fans; everything but places and faces is passed over.
export function readObj(text) {
  const vertices = [], indices = [];
  text.split("\n").forEach((line, number) => {
    const words = line.trim().split(/\s+/), wrong = (what) => { throw new Error(`Line ${number + 1} of the mesh ${what}. Export it again.`); };
    if (words[0] === "v") {
      const place = words.slice(1, 4).map(Number);
      if (place.length < 3 || !place.every(Number.isFinite)) wrong("is no place of three numbers");
      vertices.push(...place);
    } else if (words[0] === "f") {
      const corners = words.slice(1).map((word) => parseInt(word, 10)).map((i) => (i < 0 ? vertices.length / 3 + i : i - 1));
      if (corners.length < 3 || !corners.every((i) => i >= 0 && i < vertices.length / 3)) wrong("is a face of vertices that are not there");
      for (let i = 2; i < corners.length; ++i) indices.push(corners[0], corners[i - 1], corners[i]);
    }
  });
  if (indices.length === 0) throw new Error("The file has no faces, so it is no mesh. Choose an OBJ file with triangles.");
  return { vertices: new Float32Array(vertices), indices: new Uint32Array(indices) };
}

// Scales a mesh to a height, or to less where it would be wider than `width`, and puts the middle of its base at the
// origin.
export function standing({ vertices, indices }, height, width) {
  const low = [0, 1, 2].map((axis) => vertices.reduce((least, x, i) => (i % 3 === axis ? Math.min(least, x) : least), Infinity));
  const high = [0, 1, 2].map((axis) => vertices.reduce((most, x, i) => (i % 3 === axis ? Math.max(most, x) : most), -Infinity));
  if (!(high[1] > low[1])) throw new Error("The mesh is flat, so it holds no sand. Turn it: y is up.");
  const scale = Math.min(height / (high[1] - low[1]), width / Math.max(high[0] - low[0], high[2] - low[2])), middle = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2];
  return { vertices: vertices.map((x, i) => (x - middle[i % 3]) * scale), indices };
}
