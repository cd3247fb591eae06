"use client";
import { useEffect, useState } from "react";
import { Example } from "../example";
import { photograph, things } from "../things";

export default function Page() {
  const [photo, setPhoto] = useState<ImageBitmap>();
  const [given] = useState(things);
  useEffect(() => {
    photograph().then(setPhoto);
  }, []);
  return <div style={{ height: 240 }}>{photo && <Example photo={photo} {...given} />}</div>;
}
