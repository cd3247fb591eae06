"use client";
import { useEffect, useState } from "react";
import { BoxGeometry, Mesh, MeshStandardMaterial, PlaneGeometry } from "three";
import { Example } from "../example";

export default function Page() {
  const [photo, setPhoto] = useState<ImageBitmap>();
  useEffect(() => {
    const pixels = new ImageData(64, 48);
    pixels.data.forEach((_, i) => (pixels.data[i] = i < 40 * 64 ? 250 : i % 4 === 3 ? 255 : 90));
    createImageBitmap(pixels).then(setPhoto);
  }, []);
  const chair = new Mesh(new BoxGeometry(0.4, 0.4, 0.4), new MeshStandardMaterial({ color: "steelblue" }));
  const floor = new Mesh(new PlaneGeometry(8, 8).rotateX(-Math.PI / 2), new MeshStandardMaterial());
  return <div style={{ height: 240 }}>{photo && <Example photo={photo} chair={chair} floor={floor} />}</div>;
}
