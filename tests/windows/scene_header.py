#!/usr/bin/env python3
"""Makes of the scene that web_scene wrote the header that golden.cpp includes.

scene_header.py SCENE.json HEADER"""

import base64
import json
import struct
import sys

scene = json.load(open(sys.argv[1]))
if scene["emitters"] or any("field" in collider for collider in scene["colliders"]):
    sys.exit("scene_header.py: the scene has emitters or meshes: take the demo scene")


def literal(value):
    if isinstance(value, (list, tuple)):
        return "{" + ", ".join(map(literal, value)) + "}"
    return str(value) if isinstance(value, int) else f"{value!r}f"


lines = []
for name in ("particles", "particle_velocities", "grains", "grain_velocities"):
    data = base64.b64decode(scene[name])
    lines.append(f"const float k_{name}[] = {literal(struct.unpack(f'<{len(data) // 4}f', data))};")
colliders = [
    "{" + ", ".join(literal(c[part]) for part in ("shape", "position", "rotation", "size")) + ", {}, {}, 0, nullptr, 0, nullptr}"
    for c in scene["colliders"]
]
lines.append("const sandglass_collider k_colliders[] = {" + ", ".join(colliders) + "};")
lines.append(f"const float k_frame_step = {literal(scene['frame_step'])}, k_gravity[] = {literal(scene['gravity'])};")
lines.append(f"const uint64_t k_budget_ns = {round(1e6 * scene['budget_ms'])}, k_virtual_step_ns = {scene['virtual_step_ns']};")
lines.append("inline void describe(sandglass_granular_desc* desc) {")
lines += [f"  desc->{name} = {literal(value)};" for name, value in scene["granular"].items()]
open(sys.argv[2], "w").write("\n".join(lines + ["}\n"]))
