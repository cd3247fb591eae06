// The shadows of a stage: what its models throw on the floor and on a wall, and what its sand throws on the floor and on
// itself, as textures of the library.
import { constants } from "./sandglass.mjs";
import { castMesh, made } from "./mesh_field.mjs";

const k_texels = { pile: 128, sky: 64, shadow: 256, occlusion: 128 };
const k_planes = 2; // the floor and the wall
const k_height_step = 0.25; // metres, of what stands there that receives them
const k_layers = 4; // of the floor's shadows, where something that receives them stands on it
const k_cast_textures = [
  ["shadow", "occlusion"],
  ["wallShadow", "wallOcclusion"],
];
const k_pile_textures = ["pile", "onSand", "sky", "skyOnSand"]; // in the order of sandglass_pile_shadow_part
const k_no_boxes = { shadow: [0, 0, 0, 0], occlusion: [2, 2, 0, 0] };
const k_coarse = 0.125; // of the smallest model's side: texels are as large as that at most, or it is said
const k_triangles = 4096; // of the models that cast, before more are needed
const k_most_triangles = 1e6; // of cast.h

const scalar_product = (a, b) => a.reduce((sum, c, k) => sum + c * b[k], 0);

export class StageShadows {
  #sand;
  #area; // { origin, half } of the sand's shadows; and `height`, up to which something receives those of models
  #given; // a height
  #capacity; // of models
  #triangles = k_triangles;
  #casts = []; // handles, of the floor and of the wall
  #planes = [{ x: [1, 0, 0], z: [0, 0, 1], at: [0, 0, 0] }];
  #cast_planes = [];
  #walled = false;
  #list; // of handles, in the module's memory
  #meshes;
  #texture;
  #words;
  #pile = 0;
  #boxes = {};
  #slide = [0, 0]; // x and z of the floor's shadow
  #shown = {};
  #warned = false;
  behind = 0; // of textures that show what was

  constructor(sand, area, models) {
    this.#sand = sand;
    this.#area = area;
    this.#given = area.height !== undefined;
    this.#list = sand.allocate(4 * k_planes);
    this.#meshes = sand.array("sandglass_cast_mesh", models);
    this.#capacity = models;
    this.#texture = sand.make("sandglass_texture");
    this.#words = sand.allocate(4 * constants.SANDGLASS_LIGHT_CELLS);
    this.#setPlane(0, { origin: area.origin, ...(area.height && { height: area.height }) });
  }

  // What receives shadows stands so high above the floor: for an app that has said no height. Says whether a cast was made, which
  // knows no light and no models.
  raise(top) {
    const before = this.#area;
    const height = k_height_step * Math.ceil(top / k_height_step);
    if (this.#given || !(height > (before.height ?? 0))) return false;
    const [cast] = this.#casts;
    this.#area = { ...before, height };
    delete this.#casts[0];
    try {
      this.#setPlane(0, { origin: before.origin, height });
    } catch (error) {
      this.#casts[0] = cast;
      this.#area = before;
      throw error;
    }
    this.#sand.destroy(cast);
    for (const name of k_cast_textures[0]) delete this.#boxes[name]; // those that are shown have other layers
    return true;
  }

  // What is refused leaves the planes and the casts as they were.
  #setPlane(which, fields) {
    const sand = this.#sand;
    const plane = sand.make("sandglass_cast_plane");
    const cast = this.#casts[which] ?? this.#madeCast(which, this.#triangles);
    try {
      sand.sandglass_cast_plane_default(plane);
      plane.set(fields);
      sand.sandglass_cast_set_plane(cast, plane);
    } catch (error) {
      sand.free(plane);
      if (cast !== this.#casts[which]) sand.destroy(cast);
      throw error;
    }
    sand.free(this.#cast_planes[which]);
    this.#cast_planes[which] = plane;
    this.#setCast(which, cast);
  }
  #madeCast(which, triangles) {
    return made(this.#sand, "sandglass_cast", {
      layers: which === 0 ? this.#layers : 1,
      texels: k_texels.shadow,
      ambient_texels: k_texels.occlusion,
      mesh_capacity: this.#capacity,
      reach: 0, // all models cast
      triangle_capacity: triangles,
    });
  }
  get #layers() {
    return this.#area.height ? k_layers : 1;
  }
  #setCast(which, cast) {
    this.#casts[which] = cast;
    this.#sand.view().setUint32(this.#list + 4 * which, cast, true);
  }

  fits(triangles) {
    return triangles <= this.#triangles;
  }
  refuseMany(triangles) {
    if (triangles <= k_most_triangles) return;
    const [most, all] = [k_most_triangles, triangles].map((x) => x.toLocaleString("en"));
    throw new Error(
      `sandglass: models that throw shadows have ${most} triangles at most, all together, and these have ${all}. ` +
        "Simplify a model, or add it with { shadow: false }.",
    );
  }
  // Room for so many triangles, as far as there can be. Says whether casts were made anew, which know no light and no models.
  reserve(triangles) {
    if (this.fits(triangles) || this.#triangles === k_most_triangles) return false;
    const sand = this.#sand;
    const room = Math.min(k_most_triangles, triangles);
    const casts = [];
    try {
      for (const plane of this.#cast_planes) {
        casts.push(this.#madeCast(casts.length, room));
        sand.sandglass_cast_set_plane(casts.at(-1), plane);
      }
    } catch (error) {
      for (const cast of casts) sand.destroy(cast);
      throw error;
    }
    for (const cast of this.#casts) sand.destroy(cast);
    casts.forEach((cast, which) => this.#setCast(which, cast));
    this.#triangles = room;
    return true;
  }

  // Says whether a cast was made, which knows no light and no models.
  setWall(wall) {
    const before = this.#casts.length;
    if (wall) {
      const { x, y, z, at, low, high } = wall;
      this.#setPlane(1, { origin: at, normal: y, along: x, low, high });
      this.#planes[1] = { x, z, at };
    }
    this.#walled = wall !== null;
    return this.#casts.length > before;
  }

  // For shadows of sand, of which none was there: until takePile, all is as it was.
  madePile() {
    const [x, y, z] = this.#area.origin;
    const { half } = this.#area;
    return made(this.#sand, "sandglass_pile_shadow", {
      low: [x - half, z - half],
      high: [x + half, z + half],
      floor: y,
      texels: k_texels.pile,
      sky_texels: k_texels.sky,
    });
  }
  takePile(pile) {
    this.#sand.destroy(this.#pile);
    this.#pile = pile;
    this.#shown = {};
  }
  get hasPile() {
    return this.#pile !== 0;
  }
  refresh() {
    this.#sand.sandglass_pile_shadow_refresh(this.#pile);
  }

  // What stands on the floor, where shadows of sand fall on it; 0: nothing. For each frame.
  setGround(heights) {
    if (this.#pile) this.#sand.sandglass_pile_shadow_set_ground(this.#pile, heights);
  }

  // Fields of sandglass_frame_input.
  get fields() {
    return { pile_shadow: this.#pile, casts: this.#list, cast_count: this.#walled ? k_planes : 1 };
  }

  // By the light's direction, the cells where the rest comes from, and how large it is.
  setLight(toLight, cells, diameter) {
    const casts = this.#casts.map((handle) => ["cast", handle]);
    const all = this.#pile ? [...casts, ["pile_shadow", this.#pile]] : casts;
    const sum = Math.max(
      cells.reduce((total, cell) => total + cell, 0),
      0.001,
    );
    for (const [kind, handle] of all) {
      this.#sand.floats(this.#words, 3).set(toLight);
      this.#sand[`sandglass_${kind}_set_light`](handle, this.#words, diameter);
      // What is drawn by these cells is the light without the main one: they are 1 together.
      this.#setCells(
        kind,
        handle,
        cells.map((cell) => cell / sum),
      );
    }
  }
  #setCells(kind, handle, cells) {
    this.#sand.floats(this.#words, constants.SANDGLASS_LIGHT_CELLS).set(cells);
    this.#sand[`sandglass_${kind}_set_cells`](handle, this.#words);
  }
  setWallCells(cells) {
    this.#setCells("cast", this.#casts[1], cells);
  }

  // The models that throw shadows: pairs of a number and the model.
  setModels(models) {
    const sand = this.#sand;
    models.forEach((model, i) => castMesh(sand, this.#meshes[i], model));
    for (const cast of this.#casts) sand.sandglass_cast_set_meshes(cast, this.#meshes, models.length);
  }

  // What changed since the call before, and whether sand is drawn with it. `models`: that cast.
  drawn(models, sandy) {
    const textures = {};
    this.behind = 0;
    this.#casts.slice(0, this.#walled ? k_planes : 1).forEach((handle, which) => {
      const { x, z, at } = this.#planes[which];
      k_cast_textures[which].forEach((name, k) => {
        this.#sand[`sandglass_cast_get_${k === 0 ? "texture" : "ambient"}`](handle, this.#texture);
        if (!this.#take(textures, name, handle)) return;
        const { corner, along, across, slide } = this.#texture;
        if (name === "shadow") {
          this.#warn(Math.hypot(...along) / this.#texture.side, models);
          this.#slide = [slide[0], slide[2]];
        }
        this.#boxes[name] = [
          scalar_product(x, corner) - scalar_product(x, at),
          scalar_product(z, corner) - scalar_product(z, at),
          1 / scalar_product(x, along),
          1 / scalar_product(z, across),
        ];
      });
    });
    const { origin, half } = this.#area;
    const boxes = { ...k_no_boxes, ...this.#boxes };
    const pile = sandy ? this.#drawnPile(textures) : { pileOpacity: 0, skyKnown: 0 };
    return {
      textures,
      floor: origin[1],
      pileBox: [origin[0] - half, origin[2] - half, 0.5 / half, 0.5 / half],
      shadowBox: boxes.shadow,
      occlusionBox: boxes.occlusion,
      slide: [...this.#slide, 0.5 / k_texels.shadow, 0.5 / k_texels.occlusion],
      layers: [this.#layers, (this.#layers - 1) / (this.#area.height ?? 1)],
      boxes,
      shadowOpacity: this.#boxes.shadow ? 1 : 0,
      ...pile,
    };
  }
  #drawnPile(textures) {
    const found = { pileOpacity: 0, skyKnown: 0 };
    k_pile_textures.forEach((name, part) => {
      this.#sand.sandglass_pile_shadow_get_texture(this.#pile, part, this.#texture);
      const { valid, scale } = this.#texture;
      if (name === "pile" && valid) found.pileOpacity = scale;
      if (name === "sky") found.skyKnown = valid;
      this.#take(textures, name, this.#pile);
    });
    return found;
  }
  // The texture that the library has given last, where it is another than before.
  #take(textures, name, handle) {
    const { behind, valid, version, side, bytes, layers } = this.#texture;
    const key = `${handle} ${version}`;
    this.behind += behind;
    if (!valid || this.#shown[name] === key) return false;
    this.#shown[name] = key;
    textures[name] = { side, bytes: this.#sand.bytes(bytes, layers * side ** 2) };
    return true;
  }

  // All models share one texture: where they stand far apart its texels, of so many metres, are too coarse for the smallest.
  #warn(texel, models) {
    if (this.#warned || models.length < 2) return;
    if (texel <= k_coarse * Math.min(...models.map(([, { side }]) => side))) return;
    this.#warned = true;
    const size = `${(100 * texel).toFixed(1)} cm`;
    console.warn(
      `sandglass: models stand so far apart that their shadow has texels of ${size}. ` +
        "Put them nearer together, or give each place a stage of its own.",
    );
  }
}
