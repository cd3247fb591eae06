"""Writes a lighting file: the FlatBuffer of runtime/asset/light.fbs, then the FNV-1a hash of its bytes. Tables and vectors are written in
the same order as in light_file.cpp, so that equal networks give equal bytes."""

import struct
from dataclasses import dataclass

import numpy as np

VERSION, IDENTIFIER = 1, b"SGLN"
FNV_BASIS, FNV_PRIME, MASK_64 = 0xCBF29CE484222325, 0x100000001B3, (1 << 64) - 1
# The fields of table Light in the order of the schema, which numbers them.
FIELDS = (
    "version",
    "name",
    "border",
    "stem",
    "blocks",
    "last_low",
    "last_high",
    "feature_scale",
    "feature_shift",
    "latent_weights",
    "latent_scale",
    "latent_bias",
    "heads_weights",
    "heads_bias",
    "data_hash",
    "seed",
    "training_images",
    "calibration_images",
    "angle_deg",
    "difference",
    "float_parameters",
)
VECTORS = FIELDS[FIELDS.index("last_low") : FIELDS.index("heads_bias") + 1]
REFERENCE = "reference"


class FlatBuffer:
    """A buffer that grows from its end to its beginning. A position counts the bytes from the end."""

    def __init__(self):
        self.parts, self.size, self.alignment, self.layouts = [], 0, 1, {}

    def push(self, content):
        self.parts.append(content)
        self.size += len(content)
        return self.size

    def align(self, unit, following=0):
        self.alignment = max(self.alignment, unit)
        self.push(bytes(-(self.size + following) % unit))

    def number(self, kind, value):
        self.align(struct.calcsize(kind))
        return self.push(struct.pack(kind, value))

    def reference(self, to):
        self.align(4)
        return self.number("<I", self.size - to + 4)

    def vector(self, values):
        content = values.tobytes()
        self.align(max(4, values.itemsize), len(content))
        self.push(content)
        return self.number("<I", values.size)

    def string(self, text):
        content = text.encode() + b"\0"
        self.align(4, len(content))
        self.push(content)
        return self.number("<I", len(content) - 1)

    def references(self, targets):
        for to in reversed(targets):
            self.reference(to)
        return self.number("<I", len(targets))

    def table(self, fields):
        """`fields`: slot, kind of number or REFERENCE, and value, in the order in which they are written. Zeros are left out."""
        start, at = self.size, {}
        for slot, kind, value in fields:
            if value:
                at[slot] = self.reference(value) if kind == REFERENCE else self.number(kind, value)
        self.align(4)
        here, slots = self.size + 4, max(at) + 1
        layout = struct.pack(f"<{slots + 2}H", 2 * slots + 4, here - start, *(here - at[s] if s in at else 0 for s in range(slots)))
        new = layout not in self.layouts
        position = self.layouts.setdefault(layout, here + len(layout))
        self.number("<i", position - here)
        if new:
            self.push(layout)
        return here

    def finished(self, root):
        self.align(self.alignment, 8)
        self.push(IDENTIFIER)
        self.reference(root)
        return b"".join(reversed(self.parts))


@dataclass
class Convolution:
    weights: np.ndarray  # outputs x places, int8
    bias: np.ndarray  # int32
    multiplier: np.ndarray  # float32
    low: np.ndarray = None  # uint8, of each input; None: the inputs are not clamped
    high: np.ndarray = None


def add_convolution(buffer, c):
    clamps = () if c.low is None else (buffer.vector(c.low), buffer.vector(c.high))
    weights, bias, multiplier = buffer.vector(c.weights), buffer.vector(c.bias), buffer.vector(c.multiplier)
    table = buffer.table([(2, REFERENCE, multiplier), (1, REFERENCE, bias), (0, REFERENCE, weights)])
    if clamps:
        table = buffer.table([(2, REFERENCE, table), (1, REFERENCE, clamps[1]), (0, REFERENCE, clamps[0])])
    return table


def fnv1a(content):
    value = FNV_BASIS
    for byte in content:
        value = (value ^ byte) * FNV_PRIME & MASK_64
    return value


def light_file_bytes(file):
    """`file` has the fields of table Light as attributes. In place of `blocks` its convolutions are in the lists `narrow`, `wide` and
    `transition`, and `layers` says how many pairs of narrow and wide each block has. `float_parameters` may be None."""
    buffer = FlatBuffer()
    narrow, wide, transitions, blocks = iter(file.narrow), iter(file.wide), iter(file.transition), []
    for count in file.layers:
        layers = []
        for _ in range(count):
            first, second = add_convolution(buffer, next(narrow)), add_convolution(buffer, next(wide))
            layers.append(buffer.table([(1, REFERENCE, second), (0, REFERENCE, first)]))
        layers, transition = buffer.references(layers), next(transitions, None)
        transition = 0 if transition is None else add_convolution(buffer, transition)
        blocks.append(buffer.table([(1, REFERENCE, transition), (0, REFERENCE, layers)]))
    to = {"blocks": buffer.references(blocks), "stem": add_convolution(buffer, file.stem), "name": buffer.string(file.name)}
    for name in ("border",) + VECTORS + ("float_parameters",):
        values = getattr(file, name)
        to[name] = 0 if values is None else buffer.vector(values)
    # The widest numbers come first, so that none needs a gap before it.
    fields = [
        ("seed", "<Q", file.seed),
        ("data_hash", "<Q", file.data_hash),
        ("float_parameters", REFERENCE, to["float_parameters"]),
        ("difference", "<f", file.difference),
        ("angle_deg", "<f", file.angle_deg),
        ("calibration_images", "<I", file.calibration_images),
        ("training_images", "<I", file.training_images),
    ]
    fields += [(name, REFERENCE, to[name]) for name in VECTORS[::-1] + ("blocks", "stem", "border", "name")]
    fields.append(("version", "<H", VERSION))
    content = buffer.finished(buffer.table([(FIELDS.index(name), kind, value) for name, kind, value in fields]))
    return content + fnv1a(content).to_bytes(8, "little")
