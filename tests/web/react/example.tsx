import { Canvas } from "@react-three/fiber";
import { Model, Pour, Receive, Sand, Sandglass, See } from "sandglass/react";

export const Example = ({ photo, chair, floor }: { photo: ImageBitmap; chair: object; floor: object }) => (
  <Canvas camera={{ position: [0, 1.1, 1.9], fov: 56 }}>
    <Sandglass>
      <See image={photo} />
      <Model>
        <primitive object={chair} />
      </Model>
      <Receive>
        <primitive object={floor} />
      </Receive>
      <Sand particles={2000}>
        <Pour position={[0, 0.8, 0]} />
      </Sand>
    </Sandglass>
  </Canvas>
);
