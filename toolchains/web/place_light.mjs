// The light of a place in a room: what a camera's images tell of it, how it fades from one to the next, and the terms in
// which renderers take it.
import { constants } from "./sandglass.mjs";
import { made } from "./mesh_field.mjs";

const k_longest_side = 256; // pixels of an image that are read
const k_not_read = "sandglass: see takes an image element, an ImageBitmap, a canvas or a video";

// Pixels along its sides, as it is.
export const sizeOf = (image) => [
  image?.videoWidth || image?.naturalWidth || image?.width,
  image?.videoHeight || image?.naturalHeight || image?.height,
];

// What see() takes, of an image, a video or a canvas.
export function pixelsOf(image) {
  if (image?.data) return image;
  const [wide, high] = sizeOf(image);
  if (!(wide > 1 && high > 1)) throw new Error(`${k_not_read} that is loaded.`);
  const smaller = Math.min(1, k_longest_side / Math.max(wide, high));
  const [width, height] = [wide, high].map((side) => Math.max(1, Math.round(side * smaller)));
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  try {
    context.drawImage(image, 0, 0, width, height);
  } catch {
    throw new Error(`${k_not_read}. Of a texture pass its image.`);
  }
  return { data: context.getImageData(0, 0, width, height).data, width, height };
}

// The RGBA bytes of an image.
function bytesOf({ data, width, height }) {
  const bytes = Array.isArray(data) ? Uint8Array.from(data) : data;
  const right = ArrayBuffer.isView(bytes) && bytes.BYTES_PER_ELEMENT === 1;
  if (
    right &&
    [width, height].every((side) => Number.isInteger(side) && side > 0) &&
    bytes.length === 4 * width * height
  )
    return bytes;
  const given = `${data?.length ?? "no"} numbers${data ? ` in a ${data.constructor.name}` : ""}`;
  throw new Error(
    `sandglass: see takes RGBA bytes, ${4 * width * height} of them for ${width} x ${height} pixels, not ${given}. ` +
      "Pass the image itself, or draw it on a canvas.",
  );
}

// What see() takes of a camera's projection matrix, column-major, of a camera that looks along -z.
export function frustumOf(projection) {
  const [across, up, right, above] = [0, 5, 8, 9].map((k) => projection?.[k] / -projection?.[11]);
  if (!(across > 0 && up > 0 && Number.isFinite(across + up + right + above)))
    throw new Error(
      "sandglass: see needs a camera with perspective, and its projection matrix. Pass the one that drew.",
    );
  return { diagonal: (360 / Math.PI) * Math.atan(Math.hypot(1 / across, 1 / up)), centre: [right, above] };
}

// The pixel where the camera's axis meets the image. 0: the library takes that for not given.
function axisOf([right, above], width, height) {
  return [
    [(1 - right) / 2, width],
    [(1 + above) / 2, height],
  ].map(([share, side]) => {
    if (share >= 0 && share <= 1) return Math.min(Math.max(share * side - 0.5, 0.001), side - 1);
    throw new Error(
      "sandglass: see needs an image that shows the middle of the camera's view. Pass the whole image, and a camera without setViewOffset.",
    );
  });
}

export class PlaceLight {
  #sand;
  #image;
  #words;
  #place;
  #now;
  #known = false; // as it is now
  #lights;
  #filament;

  // `origin`: the place. `reflections`: the room can be asked for what metal reflects.
  constructor(sand, origin, reflections) {
    this.#sand = sand;
    this.room = made(sand, "sandglass_room", { reflections: reflections ? 1 : 0 });
    this.images = 0;
    this.#now = sand.make("sandglass_room_light");
    this.faded = sand.make("sandglass_room_light");
    this.#words = sand.allocate(8);
    this.#image = sand.make("sandglass_camera_image");
    this.#place = sand.make("sandglass_room_place");
    this.#lights = sand.make("sandglass_light");
    this.#filament = sand.make("sandglass_filament_light");
    sand.sandglass_room_place_default(this.#place);
    this.#place.set({ position: origin, shown: this.faded });
    this.#begin();
  }

  // Light that comes next is taken as it is.
  #begin() {
    this.faded.struct_size = 0;
  }
  // The room's light as it is now: asked for once it is needed.
  get now() {
    if (!this.#known) this.#sand.sandglass_room_get(this.room, this.#place, this.#now);
    this.#known = true;
    return this.#now;
  }

  see(image, { orientation, position, diagonal, centre, exposure, ms }) {
    const sand = this.#sand;
    const { width, height } = image;
    const bytes = bytesOf(image);
    const [centre_x, centre_y] = axisOf(centre, width, height);
    const pixels = sand.put(bytes);
    const focal = sand.sandglass_camera_focal(width, height, diagonal);
    sand.sandglass_camera_image_default(this.#image);
    this.#image.set({
      format: constants.SANDGLASS_CAMERA_RGBA,
      width,
      height,
      focal_x: focal,
      focal_y: focal,
      centre_x,
      centre_y,
      planes: [pixels, 0, 0],
      strides: [4 * width, 0, 0],
      orientation,
      position,
      exposure,
      timestamp_ns: Math.round(ms * 1e6),
    });
    try {
      sand.sandglass_room_set_image(this.room, this.#image, this.#words);
    } finally {
      sand.free(pixels);
    }
    if (this.images++ === 0) this.#begin();
    this.#known = false;
  }

  stand(position) {
    this.#place.position.set(position);
    this.#begin();
    this.#known = false;
  }
  forget() {
    this.#sand.sandglass_room_reset(this.room);
    this.#known = false;
  }

  fade(seconds) {
    const sand = this.#sand;
    const lights = this.#lights;
    const filament = this.#filament;
    sand.sandglass_room_fade(this.faded, this.now, seconds);
    sand.sandglass_light_of_room(this.faded, lights);
    sand.sandglass_light_to_filament(lights, constants.SANDGLASS_LIGHT_AMBIENT, 1, filament);
    return {
      toLight: [...lights.towards],
      facing: [...lights.facing],
      radiance: [...lights.ambient_sh],
      ambient: [...filament.sh],
      floor: [...this.faded.floor],
    };
  }
}
