"""What training reads: the manifests of `sandglass dataset`, their images and labels, and the features of the images."""

import csv
import hashlib
import math
import os
import sys

import numpy as np
import torch
from PIL import Image

WIDTH, HEIGHT = 256, 192
COPIES = 2  # of an image: itself and its mirror image
LABELS = ("direction_x", "direction_y", "direction_z", "light_r", "light_g", "light_b", "ambient_r", "ambient_g", "ambient_b", "contrast")
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
                    self.folder.append(folder)
                    self.number.append(number)
                    self.kind.append(kind)
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
        train = ~test & np.array([place not in held_out for place in self.location])
        return np.flatnonzero(train), np.flatnonzero(test)


def read_image(path):
    try:
        image = Image.open(path).convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        fail(f"'{path}' is missing, or no image; make the data set again")
    if image.size != (WIDTH, HEIGHT):
        fail(f"'{path}' is {image.size[0]} x {image.size[1]}, not {WIDTH} x {HEIGHT}; make the data set again")
    return np.asarray(image)


def label_of(rows, index, copy):
    """The labels of an image (copy 0), or of its mirror image (copy 1): the direction is mirrored too."""
    label = rows.labels[index].copy()
    if copy == 1:
        label[0] = -label[0]
    return label


def to_tensor(rgb):
    rgb = torch.from_numpy(np.stack(rgb)).permute(0, 3, 1, 2)
    return rgb.float().div(255.0).contiguous(memory_format=torch.channels_last)


def read_features(net, rows, paths):
    """Each folder has a file with the features of its images, then those of their mirror images. Returns a function from (row, copy)
    to features."""
    folders = list(dict.fromkeys(rows.folder))
    if len(paths) != len(folders):
        fail(f"{len(paths)} files of features for {len(folders)} folders; name one for each, in their order")
    files = {}
    for folder, path in zip(folders, paths):
        try:
            values = np.load(path)
        except (OSError, ValueError, EOFError):
            fail(f"'{path}' is no file of features; make it with `sandglass light-features`")
        expected = (COPIES * rows.folder.count(folder), net.last.num_features)
        if values.shape != expected:
            fail(f"'{path}' holds {values.shape}, not {expected}; make it again from '{folder}', with --mirror")
        files[folder] = values.reshape(COPIES, -1, expected[1])
    return lambda i, c: files[rows.folder[i]][c, rows.number[i]]
