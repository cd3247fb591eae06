// Light in the painter's terms, and what the page asks of a stage's room besides: a wall's light, and what metal reflects.
// Images stay in this page's memory and are gone once they are read.
import { constants } from "./sandglass.mjs";
import { pixelsOf } from "./place_light.mjs";

const k_every_ms = 250;

// Irradiance over pi as the library's polynomial (sandglass_filament_light.sh): nine colours.
export function lightOfSky(sun, sky, ground) {
  const ambient = new Float32Array(27);
  for (let k = 0; k < 3; ++k) {
    ambient[k] = (sky[k] + ground[k]) / 2;
    ambient[3 + k] = (sky[k] - ground[k]) / 2;
  }
  return { facing: sun.map((x) => x * Math.PI), ambient, floor: ground };
}

// From the harmonics of radiance and the main light that a WebXR device gives, ARCore's: with the Condon-Shortley phase.
export function lightOfDevice({
  sphericalHarmonicsCoefficients: sh,
  primaryLightDirection: d,
  primaryLightIntensity: i,
}) {
  const convolved = [0.282095, -0.325735, 0.325735, -0.325735, 0.273137, -0.273137, 0.078848, -0.273137, 0.136569];
  const length = Math.hypot(d.x, d.y, d.z) || 1;
  const ambient = Float32Array.from(sh, (x, k) => x * convolved[Math.floor(k / 3)]);
  const floor = [0, 1, 2].map((k) => Math.max(0, ambient[k] - ambient[3 + k] - ambient[18 + k] - ambient[24 + k])); // from straight below
  return { toLight: [d.x, d.y, d.z].map((x) => x / length), facing: [i.x, i.y, i.z], ambient, floor };
}

export class RoomParts {
  /** @param {import("./stage.mjs").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    this.sand = stage.sand;
    this.face = this.images = this.facesLeft = 0;
    this.wallKey = "";
    this.words = this.sand.allocate(64);
    this.turn = this.sand.allocate(16);
    this.halves = this.sand.allocate(8 * constants.SANDGLASS_ROOM_CUBE_SIZE ** 2);
  }

  // Of a column-major matrix.
  orientationOf(pose) {
    const { sand, words, turn } = this;
    sand.floats(words, 16).set(pose);
    sand.sandglass_camera_orientation(words, turn);
    return [...sand.floats(turn, 4)];
  }

  // The light of a wall there, whose normal and a direction along it are given: its cells without the main light.
  // It is asked anew after an image, and where the wall has moved by a centimetre or turned by half a degree.
  cellsOfWall(position, normal, along) {
    const {
      sand,
      words,
      stage: { room, images },
    } = this;
    const key = [images, ...[...position, ...normal, ...along].map((x) => Math.round(100 * x))].join();
    if (key === this.wallKey) return this.wallLight.ambient_cells.slice();
    this.wallKey = key;
    this.wallPlace ??= sand.make("sandglass_room_place");
    this.wallLight ??= sand.make("sandglass_room_light");
    sand.sandglass_room_place_default(this.wallPlace);
    sand.floats(words, 6).set([...normal, ...along]);
    this.wallPlace.set({ position, normal: words, along: words + 12 });
    sand.sandglass_room_get(room, this.wallPlace, this.wallLight);
    return this.wallLight.ambient_cells.slice();
  }

  // The next face of what metal reflects there, so high above its table, for the painter: one a call, after an image.
  reflect(position, height, painter) {
    const {
      sand,
      words,
      halves,
      face,
      stage: { room, images },
    } = this;
    const side = constants.SANDGLASS_ROOM_CUBE_SIZE;
    if (this.images !== images) {
      this.images = images;
      this.facesLeft = 6;
    }
    if (this.facesLeft === 0) return;
    --this.facesLeft;
    sand.floats(words, 3).set(position);
    sand.sandglass_room_get_cube(room, words, height, face, 0, halves);
    painter.uploadFace(face, side, new Uint16Array(sand.memory.buffer, halves, 4 * side * side));
    this.face = (face + 1) % 6;
    if (this.face === 0) painter.roomKnown = 1;
  }
}

// A camera's images, some a second. `stop` ends it.
export class CameraImages {
  static async open() {
    if (!navigator.mediaDevices)
      throw new Error(
        "This browser gives no camera to this page. Serve it by https, or set the light with the sliders.",
      );
    let stream;
    try {
      stream = await navigator.mediaDevices.getUserMedia({
        audio: false,
        video: { facingMode: "environment", width: { ideal: 320 } },
      });
    } catch {
      throw new Error("The camera cannot be used. Allow it in the browser, or set the light with the sliders.");
    }
    const video = Object.assign(document.createElement("video"), { srcObject: stream, muted: true, playsInline: true });
    await video.play();
    return new CameraImages(stream, video);
  }
  constructor(stream, video) {
    this.stream = stream;
    this.video = video;
    this.last = -Infinity;
    this.towardsUser = stream.getVideoTracks()[0].getSettings().facingMode !== "environment";
  }
  // { data, width, height }, or null where it is too early for another.
  next(ms) {
    if (!this.video.videoWidth || ms - this.last < k_every_ms) return null;
    this.last = ms;
    return pixelsOf(this.video);
  }
  stop() {
    for (const track of this.stream.getTracks()) track.stop();
  }
}
