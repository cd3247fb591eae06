"""What training reads: the manifests of `sandglass dataset`, and their images with their labels. Both are augmented together.
The outputs of layers that do not learn are kept on disk."""
import csv
import hashlib
import io
import json
import math
import os
import sys

import numpy as np
import torch
from PIL import Image

WIDTH, HEIGHT = 256, 192
LABELS = ("direction_x", "direction_y", "direction_z", "light_r", "light_g", "light_b", "ambient_r", "ambient_g", "ambient_b",
          "contrast")
GROUPS = (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 10))  # columns of the labels: direction, light, ambient, contrast


def fail(sentence):
    sys.exit(f"{os.path.basename(sys.argv[0])}: {sentence}")


def save(path, write):
    """Calls `write` with another name, then renames the file. So nobody ever reads half a file."""
    write(path + ".unfinished")
    os.replace(path + ".unfinished", path)


def save_arrays(path, **arrays):
    def write(unfinished):
        with open(unfinished, "wb") as file:  # a name would get another ending
            np.savez(file, **arrays)
    save(path, write)


class Rows:
    """The lines of the manifests, with their labels as arrays. Folders in `tested` are for tests, by fold. Two kinds are for
    training only: `views` (more views of the same places) and `extra` (made-up rooms)."""

    def __init__(self, tested, views=(), extra=()):
        self.image, self.location, self.fold, self.folder, self.number, self.kind, labels = [], [], [], [], [], [], []
        for kind, folders in enumerate((tested, views, extra)):
            for folder in folders:
                path = os.path.join(folder, "manifest.csv")
                if not os.path.exists(path):
                    fail(f"'{folder}' has no manifest.csv; make it with `sandglass dataset`")
                for number, row in enumerate(csv.DictReader(open(path, newline="", encoding="utf-8", errors="replace"))):
                    missing = [k for k in ("image", "location", "fold") + LABELS if not row.get(k)]
                    if missing:
                        fail(f"line {number + 2} of '{path}' has no {missing[0]}; make the data set again")
                    try:
                        fold, values = int(row["fold"]), [float(row[k]) for k in LABELS]
                    except ValueError:
                        fail(f"line {number + 2} of '{path}' has words in the place of numbers; make the data set again")
                    if not all(map(math.isfinite, values)) or not any(values[:3]):
                        fail(f"line {number + 2} of '{path}' has labels that are no light; make the data set again")
                    self.image.append(os.path.join(folder, row["image"]))
                    self.location.append(row["location"])
                    self.fold.append(fold)
                    self.folder.append(folder), self.number.append(number), self.kind.append(kind)
                    labels.append(values)
        if not labels:
            fail("the manifests have no lines; make the data set again")
        self.fold, self.kind, self.labels = np.array(self.fold), np.array(self.kind), np.array(labels, np.float32)

    def hash(self):
        text = hashlib.sha256()
        for folder in dict.fromkeys(self.folder):
            text.update(open(os.path.join(folder, "manifest.csv"), "rb").read())
        return text.hexdigest()[:16]

    def split(self, test_fold):
        """The indices to train on, and those to test on. With None, none are for tests."""
        test = (self.fold == test_fold) & (self.kind == 0) if test_fold is not None else np.zeros(len(self.fold), bool)
        held_out = {self.location[i] for i in np.flatnonzero(test)}
        train = ~test & np.array([l not in held_out for l in self.location])
        return np.flatnonzero(train), np.flatnonzero(test)


def read_bytes(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError:
        fail(f"the image '{path}' of the manifest cannot be read; make the data set again")


def read_image(path):
    try:
        image = Image.open(io.BytesIO(read_bytes(path))).convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        fail(f"'{path}' is no image; make the data set again")
    if image.size != (WIDTH, HEIGHT):
        fail(f"'{path}' is {image.size[0]} x {image.size[1]}, not {WIDTH} x {HEIGHT}; make the data set again")
    return np.asarray(image)


def gain_of(random):
    """A random exposure and white balance: one factor for each linear channel."""
    return (2.0 ** random.normal(0.0, 0.25) * np.exp(random.normal(0.0, 0.06, 3))).astype(np.float32)


def augmented(rgb, random):
    """Changes exposure, white balance and field of view at random, and adds noise and JPEG's losses."""
    gain = gain_of(random)
    x = rgb.astype(np.float32) / 255.0
    if random.random() < 0.5:  # re-projects a narrower camera; outside its view the edge's colour continues
        scale = random.uniform(0.6, 1.0)
        u = np.clip(np.rint(np.clip((np.arange(WIDTH) - 127.5), -127.5 * scale, 127.5 * scale) + 127.5), 0, WIDTH - 1)
        v = np.clip(np.rint(np.clip((np.arange(HEIGHT) - 95.5), -95.5 * scale, 95.5 * scale) + 95.5), 0, HEIGHT - 1)
        x = x[v.astype(int)][:, u.astype(int)]
    linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    linear = np.clip(gain * linear + random.normal(0.0, 1.0, x.shape) * random.uniform(0.0, 0.01), 0.0, 1.0)
    x = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    x = np.rint(255.0 * x).astype(np.uint8)
    if random.random() < 0.5:
        packed = io.BytesIO()
        Image.fromarray(x).save(packed, "JPEG", quality=int(random.integers(50, 96)))
        x = np.asarray(Image.open(packed))
    return x


def prepared(rows, index, copy, seed):
    """Copy 0 is the image, and copy 1 is its mirror image. Further copies are augmented, and odd ones are mirrored too. The
    result depends on the arguments alone."""
    rgb = read_image(rows.image[index])
    if copy >= 2:
        rgb = augmented(rgb, np.random.default_rng([seed, rows.number[index], copy]))
    return np.ascontiguousarray(rgb[:, ::-1]) if copy % 2 == 1 else rgb


def label_of(rows, index, copy, seed):
    """The labels of that copy. A mirror image has the mirrored direction. A gain changes the colours of the light as it changes
    the image."""
    label = rows.labels[index].copy()
    if copy >= 2:
        gain = gain_of(np.random.default_rng([seed, rows.number[index], copy]))
        for at in (3, 6):  # as in the data set: hue kept, no channel above 1
            colour = label[at:at + 3] * gain
            label[at:at + 3] = colour / max(1.0, float(colour.max()))
    if copy % 2 == 1:
        label[0] = -label[0]
    return label


def to_tensor(rgb, device):
    rgb = torch.from_numpy(np.stack(rgb)).to(device).permute(0, 3, 1, 2)
    return rgb.float().div(255.0).contiguous(memory_format=torch.channels_last)


def images_hash(paths):
    """A hash of the bytes of the images, in their order. It ties trunks to images, whatever a folder is called."""
    whole = hashlib.sha256()
    for path in paths:
        whole.update(hashlib.sha256(read_bytes(path)).digest())
    return whole.hexdigest()


def cached_trunks(net, rows, arguments, device):
    """Computes the trunks of all rows and copies, in half precision. Each folder and copy has a file. Files of the same images
    are used again. Returns a function from (row, copy) to a trunk."""
    net.eval()
    files, trunk = {}, hashlib.sha256()
    for part in (net.stem, net.stem_norm, net.blocks[:3], net.transitions):
        for value in part.state_dict().values():
            trunk.update(value.cpu().contiguous().numpy().tobytes())
    for folder in dict.fromkeys(rows.folder):
        members = [i for i, f in enumerate(rows.folder) if f == folder]
        images = images_hash(rows.image[i] for i in members)
        key = hashlib.sha256(json.dumps([images, trunk.hexdigest(), arguments.seed]).encode()).hexdigest()[:16]
        cache = os.path.join(arguments.cache or arguments.output, "trunks_" + key)
        os.makedirs(cache, exist_ok=True)
        for copy in range(arguments.copies):
            path = os.path.join(cache, f"copy_{copy}.npy")
            if not os.path.exists(path):
                parts = []
                for at in range(0, len(members), 16):
                    batch = [prepared(rows, i, copy, arguments.seed) for i in members[at:at + 16]]
                    with torch.no_grad():
                        parts.append(net.trunk(to_tensor(batch, device)).cpu().numpy().astype(np.float16))
                with open(path + ".unfinished", "wb") as file:
                    np.save(file, np.concatenate(parts))
                os.replace(path + ".unfinished", path)
                print(f"{folder}: copy {copy + 1} of {arguments.copies}", flush=True)
            try:
                files[folder, copy] = np.load(path, mmap_mode="r")
            except (OSError, ValueError):
                fail(f"the cached trunks '{path}' are damaged; remove that file")
            if len(files[folder, copy]) != len(members):
                fail(f"the cached trunks '{path}' are of {len(files[folder, copy])} images, not {len(members)}; remove that file")
    trunks = {}
    with torch.no_grad():
        for key, file in files.items():
            parts = [net.prefix(torch.from_numpy(file[at:at + 64].astype(np.float32)).to(device)
                                .contiguous(memory_format=torch.channels_last)).cpu().numpy().astype(np.float16)
                     for at in range(0, len(file), 64)] if net.learned < len(net.blocks[3]) else [file]
            trunks[key] = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return lambda i, c: trunks[rows.folder[i], c][rows.number[i]]


def read_features(net, rows, arguments, paths):
    """Reads features that were made elsewhere, in place of trunks. Each folder has a file, with one copy after another."""
    folders = list(dict.fromkeys(rows.folder))
    if len(paths) != len(folders):
        fail(f"{len(paths)} files of features for {len(folders)} folders; name one for each, in their order")
    files = {}
    for folder, path in zip(folders, paths):
        try:
            values = np.load(path)
        except (OSError, ValueError, EOFError):
            fail(f"'{path}' is no file of features; make it with `sandglass light-features`")
        expected = (arguments.copies * rows.folder.count(folder), net.last.num_features)
        if values.shape != expected:
            fail(f"'{path}' holds {values.shape}, not {expected}; make it again from '{folder}', with --mirror for 2 copies")
        files[folder] = values.reshape(arguments.copies, -1, expected[1])
    net.features = lambda features: features
    return lambda i, c: files[rows.folder[i]][c, rows.number[i]]
