// The light of the room by what a camera has seen of it (room.h), in the painter's terms. The library needs no network
// for it, so nothing is loaded. Images stay in this page's memory and are gone once they are read.
import { constants } from "./sandglass.mjs";

const k_image = 160;          // pixels along the longer side: the parts of the room are some degrees wide
const k_diagonal = 75;        // degrees, of the cameras of phones; a browser does not tell
const k_every_ms = 250;

// Irradiance over pi as the library's polynomial (sandglass_filament_light.sh): nine colours.
export function lightOfSky(sun, sky, ground) {
  const ambient = new Float32Array(27);
  for (let k = 0; k < 3; ++k) ambient[k] = (sky[k] + ground[k]) / 2, ambient[3 + k] = (sky[k] - ground[k]) / 2;
  return { sun, ambient, floor: ground };
}

// From the harmonics of radiance and the main light that a WebXR device gives.
export function lightOfDevice({ sphericalHarmonicsCoefficients: sh, primaryLightDirection: d, primaryLightIntensity: i }) {
  const convolved = [0.282095, ...Array(3).fill(0.325735), 0.273137, 0.273137, 0.078848, 0.273137, 0.136569];
  const length = Math.hypot(d.x, d.y, d.z) || 1;
  const ambient = Float32Array.from(sh, (x, k) => x * convolved[Math.floor(k / 3)]);
  const floor = [0, 1, 2].map((k) => Math.max(0, ambient[k] - ambient[3 + k] - ambient[18 + k] - ambient[24 + k]));  // from straight below
  return { toLight: [d.x, d.y, d.z].map((x) => x / length), sun: [i.x, i.y, i.z].map((x) => x / Math.PI), ambient, floor };
}

export class RoomLight {
  constructor(sand) {
    this.sand = sand;
    const desc = sand.make("sandglass_room_desc");
    sand.sandglass_room_desc_default(desc);
    desc.reflections = 1;
    this.room = sand.create("sandglass_room", desc);
    sand.free(desc);
    this.image = sand.make("sandglass_camera_image");
    sand.sandglass_camera_image_default(this.image);
    this.pixels = sand.allocate(4 * k_image * k_image), this.words = sand.allocate(64);
    this.face = 0, this.facesLeft = 6, this.wallKey = "", this.images = 0, this.halves = sand.allocate(8 * constants.SANDGLASS_ROOM_CUBE_SIZE ** 2);
    this.now = sand.make("sandglass_room_light"), this.shown = sand.make("sandglass_room_light");
    this.shown.struct_size = 0;
    this.place = sand.make("sandglass_room_place");
    sand.sandglass_room_place_default(this.place);
    this.place.shown = this.shown.address;
    this.lighting = sand.make("sandglass_lighting"), this.filament = sand.make("sandglass_filament_light");
    this.get();
  }

  get() {
    this.sand.sandglass_room_get(this.room, this.place, this.now);
  }

  // Something is placed there. It begins in the light that is known; the fade is for what has stood there.
  stand(position) {
    this.place.position.set(position);
    this.shown.struct_size = 0;
    this.get();
  }

  // For another frame of the world.
  forget() {
    this.sand.sandglass_room_reset(this.room);
    this.get();
  }

  // RGBA bytes, the upper row first, from a camera that looks along -z of `pose`, a column-major matrix.
  see(bytes, width, height, pose, ms) {
    const { sand, image, words } = this;
    sand.bytes(this.pixels, bytes.length).set(bytes);
    const focal = sand.sandglass_camera_focal(width, height, k_diagonal);
    sand.floats(words, 16).set(pose);
    sand.sandglass_camera_orientation(words, image.orientation);
    image.set({ format: constants.SANDGLASS_CAMERA_RGBA, width, height, focal_x: focal, focal_y: focal, centre_x: (width - 1) / 2, centre_y: (height - 1) / 2,
      timestamp_ns: Math.round(ms * 1e6) });
    image.planes[0] = this.pixels, image.strides[0] = 4 * width;
    sand.sandglass_room_set_image(this.room, image, words);
    ++this.images, this.facesLeft = 6;
    this.get();
  }

  // Where the light that is shown comes from, without the main light.
  cells() { return this.shown.ambient_cells.slice(); }

  // The light of a wall there, whose normal and a direction along it are given: its cells without the main light.
  // It is asked anew after an image, and where the wall has moved by a centimetre or turned by half a degree.
  cellsOfWall(position, normal, along) {
    const { sand, words } = this, key = [this.images, ...[...position, ...normal, ...along].map((x) => Math.round(100 * x))].join();
    if (key === this.wallKey) return this.wallLight.ambient_cells.slice();
    this.wallKey = key;
    this.wallPlace ??= sand.make("sandglass_room_place"), this.wallLight ??= sand.make("sandglass_room_light");
    sand.sandglass_room_place_default(this.wallPlace);
    sand.floats(words, 6).set([...normal, ...along]);
    this.wallPlace.set({ position, normal: words, along: words + 12 });
    sand.sandglass_room_get(this.room, this.wallPlace, this.wallLight);
    return this.wallLight.ambient_cells.slice();
  }

  // The next face of what metal reflects there, so high above its table, for the painter: one a call, after an image.
  reflect(position, height, painter) {
    if (this.facesLeft-- <= 0) { this.facesLeft = 0; return; }
    const { sand, words, halves, face } = this, side = constants.SANDGLASS_ROOM_CUBE_SIZE;
    sand.floats(words, 3).set(position);
    sand.sandglass_room_get_cube(this.room, words, height, face, 0, halves);
    painter.uploadFace(face, side, new Uint16Array(sand.memory.buffer, halves, 4 * side * side));
    this.face = (face + 1) % 6;
    if (this.face === 0) painter.roomKnown = 1;
  }

  // What is shown moves towards what is known. In the painter's terms.
  follow(seconds) {
    const { sand, shown, lighting, filament } = this;
    sand.sandglass_room_fade(shown, this.now, Math.max(0, seconds));
    sand.sandglass_lighting_of_room(shown, lighting);
    sand.sandglass_lighting_to_filament(lighting, constants.SANDGLASS_LIGHTING_AMBIENT, 1, filament);
    return { toLight: [...shown.main_direction], sun: [...filament.colour].map((x) => x * filament.intensity / Math.PI), ambient: filament.sh.slice(), floor: [...shown.floor] };
  }
}

// A camera's images, some a second. `stop` ends it.
export class CameraImages {
  static async open() {
    if (!navigator.mediaDevices) throw new Error("This browser gives no camera to this page. Serve it by https, or set the light with the sliders.");
    let stream;
    try { stream = await navigator.mediaDevices.getUserMedia({ audio: false, video: { facingMode: "environment", width: { ideal: 320 } } }); } catch {
      throw new Error("The camera cannot be used. Allow it in the browser, or set the light with the sliders.");
    }
    const video = Object.assign(document.createElement("video"), { srcObject: stream, muted: true, playsInline: true });
    await video.play();
    return new CameraImages(stream, video);
  }
  constructor(stream, video) {
    this.stream = stream, this.video = video, this.last = -Infinity;
    this.canvas = document.createElement("canvas");
    this.context = this.canvas.getContext("2d", { willReadFrequently: true });
    this.towardsUser = stream.getVideoTracks()[0].getSettings().facingMode !== "environment";
  }
  // { data, width, height }, or null where it is too early for another.
  next(ms) {
    const { video, canvas, context } = this, scale = k_image / Math.max(video.videoWidth, video.videoHeight);
    if (!(scale < Infinity) || ms - this.last < k_every_ms) return null;
    this.last = ms;
    canvas.width = Math.round(video.videoWidth * scale), canvas.height = Math.round(video.videoHeight * scale);
    context.drawImage(video, 0, 0, canvas.width, canvas.height);
    return context.getImageData(0, 0, canvas.width, canvas.height);
  }
  stop() { for (const track of this.stream.getTracks()) track.stop(); }
}
