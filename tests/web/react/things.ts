// What the example is given.
import { BoxGeometry, Mesh, MeshStandardMaterial, PlaneGeometry } from "three";

export function photograph() {
  const pixels = new ImageData(64, 48);
  pixels.data.forEach((_, i) => (pixels.data[i] = i < 40 * 64 ? 250 : i % 4 === 3 ? 255 : 90));
  return createImageBitmap(pixels);
}
export function things() {
  const chair = new Mesh(new BoxGeometry(0.4, 0.4, 0.4), new MeshStandardMaterial({ color: "steelblue" }));
  const floor = new Mesh(new PlaneGeometry(8, 8).rotateX(-Math.PI / 2), new MeshStandardMaterial());
  chair.position.y = 0.2;
  return { chair, floor };
}
