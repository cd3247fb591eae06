#!/usr/bin/env python3
"""Trains the lighting network (SPEC 3.2) on data sets made by `sandglass dataset`.

DenseNet-121 (pretrained, or as initialised), a layer of 512 with batch normalisation and ELU, and four heads: direction
(tanh, normalised), light colour, ambient colour (sigmoid), contrast (sigmoid). Loss (5.26): mean squares weighted 5, 2, 2, 1.

Folds follow locations: a location of the test fold never trains, and rows of fold -1 only ever train. Two ways to train:
  --layers last   everything up to the third transition is computed once, for each image, its mirror image and a few
                  augmented copies of both, and kept on disk; the last layers of the last dense block (--learn) and the heads learn. For a CPU.
  --layers all    every layer learns, with fresh augmentation of every image in every epoch. For a GPU.
Statistics of the pretrained batch normalisations stay as they are (--free-norm: they follow the data), their factors
learn. What is kept at the end is the mean of the weights over the last quarter of the epochs.

Checkpoints are written after every epoch, under a temporary name and then renamed; --resume goes on from the last one and
gives what an uninterrupted run gives. Images are 256 x 192 sRGB; directions are in the camera's frame (x right, y down).

Of a network whose heads are ridge regressions nothing needs more than its features. With --features they are those of the
runtime, in bytes (`sandglass light-features`), so that the heads know the rounding; how strong the ridges are is chosen
within the folds that train. So is, with --or-features, whose features they are: each test fold is estimated from the set that was
best for the direction when the other folds were estimated from one another.

ImageNet's features have forgotten how bright which part of an image is, which tells most of where light comes from. --lanes keeps
that: the channels of the pretrained network that are used least, LANES at each of its four widths, carry brightness above
thresholds past its layers, and the last LAYOUT_LAYERS layers move it about, so that the averages over all pixels are also
those over parts. All else stays pretrained; how far its features are trusted is chosen, with the ridges, within the folds.

--export FILE writes the float weights as the pretrained file names them (convolutions HWIO; every batch normalisation apart
as gamma, beta, moving_mean, moving_variance; epsilon 1.001e-5), without fc1000, and behind them
  latent/kernel (1024, 512), latent/bias, latent/bn/{gamma,beta,moving_mean,moving_variance} (epsilon 1e-5), then ELU,
  direction/kernel (512, 3), direction/bias (tanh, then normalised), light/..., ambient/... (3), contrast/... (1; sigmoid),
and data_hash (16 hexadecimal digits of the manifests' SHA-256), seed, training_images.
"""
import argparse
import csv
import hashlib
import io
import json
import math
import os
import sys
import zipfile
import zlib

import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F
from PIL import Image

LAYERS, GROWTH, BOTTLENECK, EPSILON = (6, 12, 24, 16), 32, 128, 1.001e-5
MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
NORM_NAMES = (("weight", "gamma"), ("bias", "beta"), ("running_mean", "moving_mean"), ("running_var", "moving_variance"))
LOSS_WEIGHTS = {"direction": 5.0, "light": 2.0, "ambient": 2.0, "contrast": 1.0}  # (5.26)
LABELS = ("direction_x", "direction_y", "direction_z", "light_r", "light_g", "light_b", "ambient_r", "ambient_g", "ambient_b",
          "contrast")
GROUPS = (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 10))  # of the labels: direction, light, ambient, contrast
TRUSTS = (0.03, 0.1, 0.3, 1.0)  # to choose from, of what is no lane's beside what is
RIDGES = tuple(10.0 ** (k / 2) for k in range(-6, 5))  # to choose from, of the standardised features
USUAL_RIDGES = (2.0, 4.0, 0.1, 2.0)  # of the groups, where there are no two folds to choose by
COPIES_OF_START, SHIFT_OF_START, EXTRA_WEIGHT, LEAST_DEVIATION = 16, 3.0, 0.5, 0.25
WIDTH, HEIGHT = 256, 192
LANES = tuple((channel, threshold) for threshold in (0.0, 0.5, 0.75, 0.9) for channel in range(3))  # brightness in sRGB
LAYOUT_LAYERS = 4  # moves by as many of the last map's 6 rows and of its 8 columns


class Regression:
    """Weighted ridge regressions of the labels on features, all in float64, for every ridge at the price of one."""

    def __init__(self, features, labels, weights, trust=1.0):
        targets = labels.copy()
        targets[:, :3] *= 0.5  # where tanh is almost the identity; the length does not matter
        targets[:, 3:] = np.log(targets[:, 3:].clip(0.02, 0.98) / (1 - targets[:, 3:].clip(0.02, 0.98)))
        weights = (weights / weights.sum())[:, None]
        self.mean, self.answer = (weights * features).sum(0), (weights * targets).sum(0)
        centred = features - self.mean
        deviation = np.sqrt((weights * centred ** 2).sum(0))
        self.deviation = np.maximum(deviation, LEAST_DEVIATION * np.median(deviation)) / trust  # bytes do not keep what hardly varies
        centred = centred / self.deviation
        self.values, self.vectors = np.linalg.eigh((weights * centred).T @ centred)
        self.products = self.vectors.T @ ((weights * centred).T @ (targets - self.answer))

    def slopes(self, ridges):
        """Of the features as they are, by columns; one ridge for each group of labels."""
        each = np.concatenate([np.full(g.stop - g.start, r) for g, r in zip(GROUPS, ridges)])
        return self.vectors @ (self.products / (self.values.clip(0)[:, None] + each)) / self.deviation[:, None]

    def errors(self, ridges, features, labels):
        """Of each group: the mean angle, then mean absolute differences."""
        out = self.answer + (features - self.mean) @ self.slopes(ridges)
        out = np.concatenate([np.tanh(out[:, :3]), 1 / (1 + np.exp(-out[:, 3:]))], 1)
        return [angles_deg(out[:, :3], labels[:, :3]).mean()] + [np.abs(out[:, g] - labels[:, g]).mean() for g in GROUPS[1:]]


def ridge_errors(features, labels, weights, folds, judged, trust=1.0):
    """Of each ridge and group, the mean error of the `judged` rows of each fold, fitted on the other folds; None of one fold."""
    kinds = np.unique(folds[judged])
    if len(kinds) < 2:
        return None
    errors = np.zeros((len(RIDGES), len(GROUPS)))
    for fold in kinds:
        test, fitted = judged & (folds == fold), folds != fold
        regression = Regression(features[fitted], labels[fitted], weights[fitted], trust)
        for k, ridge in enumerate(RIDGES):
            errors[k] += test.sum() * np.array(regression.errors((ridge,) * len(GROUPS), features[test], labels[test]))
    return errors / judged.sum()


def best_ridges(errors):
    return USUAL_RIDGES if errors is None else tuple(RIDGES[k] for k in errors.argmin(0))


def expected(norm, at):
    """Mean and deviation of the channels `at` behind a batch normalisation and ReLU, were they distributed normally."""
    shift, spread = norm.bias[at].double(), norm.weight[at].double().abs() + 1e-9
    below = 0.5 * (1 + torch.erf(shift / spread / 2 ** 0.5))
    density = spread * torch.exp(-0.5 * (shift / spread) ** 2) / math.sqrt(2 * math.pi)
    mean = shift * below + density
    return mean, ((shift ** 2 + spread ** 2) * below + shift * density - mean ** 2).clamp(min=0).sqrt()


def pass_through(norm, at):
    """A batch normalisation that leaves the channels `at` as they are; they are not negative, nor does the ReLU change them."""
    norm.weight[at], norm.bias[at], norm.running_mean[at], norm.running_var[at] = 1.0, 0.0, 0.0, 1.0 - EPSILON


class DenseLayer(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.before = nn.BatchNorm2d(channels, eps=EPSILON)
        self.narrow = nn.Conv2d(channels, BOTTLENECK, 1, bias=False)
        self.between = nn.BatchNorm2d(BOTTLENECK, eps=EPSILON)
        self.wide = nn.Conv2d(BOTTLENECK, GROWTH, 3, padding=1, bias=False)

    def forward(self, x):
        y = self.narrow(F.relu(self.before(x)))
        return torch.cat([x, self.wide(F.relu(self.between(y)))], 1)


class Transition(nn.Module):
    """Pools before the 1x1 convolution: both are linear, and a quarter of the multiplications is left."""

    def __init__(self, channels):
        super().__init__()
        self.before = nn.BatchNorm2d(channels, eps=EPSILON)
        self.narrow = nn.Conv2d(channels, channels // 2, 1, bias=False)

    def forward(self, x):
        return self.narrow(F.avg_pool2d(F.relu(self.before(x)), 2))


class LightNet(nn.Module):
    def __init__(self):
        super().__init__()
        self.stem = nn.Conv2d(3, 64, 7, stride=2, padding=3, bias=False)
        self.stem_norm = nn.BatchNorm2d(64, eps=EPSILON)
        channels, blocks, transitions = 64, [], []
        for i, count in enumerate(LAYERS):
            blocks.append(nn.Sequential(*[DenseLayer(channels + GROWTH * j) for j in range(count)]))
            channels += GROWTH * count
            if i < 3:
                transitions.append(Transition(channels))
                channels //= 2
        self.blocks, self.transitions = nn.ModuleList(blocks), nn.ModuleList(transitions)
        self.last = nn.BatchNorm2d(channels, eps=EPSILON)
        self.latent = nn.Sequential(nn.Linear(channels, 512), nn.BatchNorm1d(512), nn.ELU())
        self.dropout = 0.0  # of the 512, in training
        self.lanes = None  # which of the features are lanes', where there are lanes
        self.learned = LAYERS[3]  # layers of the last block behind the trunk that is kept on disk
        self.heads = nn.ModuleDict({k: nn.Linear(512, n) for k, n in
                                    (("direction", 3), ("light", 3), ("ambient", 3), ("contrast", 1))})

    def readers(self, stage):
        """What reads the maps of a width: a batch normalisation, the 1 x 1 convolution behind it, and the normalisations behind that."""
        layers = [(layer.before, layer.narrow, [layer.between]) for layer in self.blocks[stage]]
        if stage == 3:
            return layers + [(self.last, None, [])]
        transition = self.transitions[stage]
        return layers + [(transition.before, transition.narrow, [norm for norm, *_ in self.readers(stage + 1)])]

    def free(self, readers, at):
        """Of the channels `at` nothing is read but their means, and they pass all normalisations."""
        for before, narrow, behind in readers:
            if narrow is not None:
                constant = (narrow.weight[:, at, 0, 0].double() @ expected(before, at)[0]).float()
                for norm in behind:
                    norm.running_mean[:len(constant)] -= constant
                narrow.weight[:, at] = 0
            pass_through(before, at)

    @torch.no_grad()
    def give_lanes(self):
        count, places = len(LANES), []
        for stage, width in enumerate((64, 128, 256, 512)):
            use, every = torch.zeros(width, dtype=torch.float64), torch.arange(width)
            for before, narrow, _ in self.readers(stage)[:LAYERS[stage] + (stage < 3)]:
                share = expected(before, every)[1] * narrow.weight[:, :width, 0, 0].double().norm(dim=0)
                use += share / share.sum()
            places.append(use.argsort()[:count].sort().values)
        for stage, at in enumerate(places):
            self.free(self.readers(stage), at)
            into = self.stem if stage == 0 else self.transitions[stage - 1].narrow
            into.weight[at] = 0
            for place, (channel, threshold) in zip(at, LANES):
                if stage == 0:  # the mean of 7 x 7 pixels, from which the input's mean has been taken
                    self.stem.weight[place, channel] = DEVIATION[channel] / 49
                    pass_through(self.stem_norm, place)
                    self.stem_norm.running_mean[place] = threshold - MEAN[channel]
            if stage:
                into.weight[at, places[stage - 1]] = 1.0
        block, first = self.blocks[3], LAYERS[3] - LAYOUT_LAYERS
        made = [torch.arange(2 * count) + 512 + GROWTH * layer for layer in range(first, LAYERS[3])]
        for layer, at in zip(range(first, LAYERS[3]), made):
            self.free(self.readers(3)[layer + 1:], at)
            up, left = (places[3], places[3]) if layer == first else made[layer - first - 1].chunk(2)
            read = block[layer]
            read.narrow.weight[:2 * count] = 0
            read.narrow.weight[torch.arange(2 * count), torch.cat([up, left])] = 1.0
            pass_through(read.between, torch.arange(2 * count))
            read.wide.weight[:, :2 * count], read.wide.weight[:2 * count] = 0, 0
            for k in range(count):  # the row below, the column to the right
                read.wide.weight[k, k, 2, 1] = read.wide.weight[count + k, count + k, 1, 2] = 1.0
        self.lanes = np.isin(np.arange(self.last.num_features), torch.cat([places[3]] + made).numpy())

    def trunk(self, rgb):
        """sRGB 0..1 to what the last dense block reads, 512 x 6 x 8."""
        mean, deviation = (torch.tensor(t, device=rgb.device).view(1, 3, 1, 1) for t in (MEAN, DEVIATION))
        x = F.relu(self.stem_norm(self.stem((rgb - mean) / deviation)))
        x = F.max_pool2d(x, 3, 2, 1)
        for i in range(3):
            x = self.transitions[i](self.blocks[i](x))
        return x

    def prefix(self, trunk):
        """The layers of the last block that do not learn."""
        return self.blocks[3][:LAYERS[3] - self.learned](trunk)

    def features(self, prefix):
        return F.relu(self.last(self.blocks[3][LAYERS[3] - self.learned:](prefix))).mean((2, 3))

    def estimate(self, prefix):
        latent = F.dropout(self.latent(self.features(prefix)), self.dropout, self.training)
        out = {k: head(latent) for k, head in self.heads.items()}
        return {"direction": F.normalize(torch.tanh(out["direction"]), dim=1), "light": torch.sigmoid(out["light"]),
                "ambient": torch.sigmoid(out["ambient"]), "contrast": torch.sigmoid(out["contrast"])}

    def trusts(self):
        """What may be chosen: factors of the standardised features."""
        return [1.0] if self.lanes is None else [np.where(self.lanes, 1.0, trust) for trust in TRUSTS]

    def start_at(self, features, labels, weights, ridges, chosen_trusts=(0,) * len(GROUPS)):
        """Starts the heads from ridge regressions of the labels on features (float64, by rows, weighted): with few places,
        a start that gradient descent does not find. Of the latent units the first 10 * COPIES_OF_START carry the solutions, each
        COPIES_OF_START times because of the dropout, shifted to where ELU is the identity; the others begin without effect."""
        slopes = np.zeros((features.shape[1], len(LABELS)))
        for k in set(chosen_trusts):
            regression = Regression(features, labels, weights, self.trusts()[k])
            for group, its in zip(GROUPS, chosen_trusts):
                if its == k:
                    slopes[:, group] = regression.slopes(ridges)[:, group]
        answer = regression.answer
        weights = (weights / weights.sum())[:, None]
        spread = np.sqrt((weights * ((features - regression.mean) @ slopes) ** 2).sum(0)) + 1e-9
        linear, norm = self.latent[0], self.latent[1]
        to = torch.arange(10).repeat_interleave(COPIES_OF_START)
        with torch.no_grad():
            for head in self.heads.values():
                head.weight.zero_()
            linear.bias.zero_()
            linear.weight[:len(to)] = torch.from_numpy(slopes.T.astype(np.float32)).to(linear.weight.device)[to]
            outputs = torch.from_numpy(features.astype(np.float32)).to(linear.weight.device) @ linear.weight.T
            shares = torch.from_numpy(weights.astype(np.float32)).to(outputs.device)
            norm.running_mean.copy_((shares * outputs).sum(0))
            norm.running_var.copy_((shares * (outputs - norm.running_mean) ** 2).sum(0))
            norm.bias[:len(to)] = SHIFT_OF_START
            j = 0
            for head in self.heads.values():
                for row in range(len(head.bias)):
                    head.weight[row, j * COPIES_OF_START:(j + 1) * COPIES_OF_START] = float(spread[j]) / COPIES_OF_START
                    head.bias[row] = float(answer[j] - SHIFT_OF_START * spread[j])
                    j += 1

    def heads_of(self):
        return nn.ModuleList([self.latent, self.heads])

    def train_with(self, frozen_norm):
        """Training mode, but for the statistics of the extractor's batch normalisations where those are frozen."""
        self.train()
        if frozen_norm:
            for module in self.modules():
                if isinstance(module, nn.BatchNorm2d):
                    module.eval()

    def load(self, path):
        """The extractor of a pretrained or exported file; of an exported one the heads too. Whether there were heads."""
        these = "name densenet121_imagenet_keras_fp32.npz or what --export wrote"
        try:
            arrays = dict(np.load(path))
        except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, zlib.error):
            fail(f"'{path}' is no file of weights; {these}")

        def fill(parameter, name, axes=None):
            if name not in arrays:
                fail(f"'{path}' has no array {name}; {these}")
            values = arrays[name].transpose(axes) if axes and arrays[name].ndim == len(axes) else arrays[name]
            if values.shape != tuple(parameter.shape):
                fail(f"the array {name} of '{path}' has another shape than the network; {these}")
            parameter.data = torch.from_numpy(np.ascontiguousarray(values, np.float32))

        def norm(module, name):
            for ours, theirs in NORM_NAMES:
                fill(getattr(module, ours), f"{name}/{theirs}")

        def conv(module, name):  # HWIO to OIHW
            fill(module.weight, name + "/kernel", (3, 2, 0, 1))

        def linear(module, name):
            fill(module.weight, name + "/kernel", (1, 0)), fill(module.bias, name + "/bias")

        self.walk(norm, conv)
        if "lanes" in arrays:
            if arrays["lanes"].shape != (self.last.num_features,):
                fail(f"the array lanes of '{path}' has another shape than the network's features; {these}")
            self.lanes = arrays["lanes"] > 0
        if "latent/kernel" not in arrays:
            return False
        self.walk_heads(norm, linear)
        return True

    def exported(self):
        """The arrays of --export."""
        arrays = {}

        def norm(module, name):
            for ours, theirs in NORM_NAMES:
                arrays[f"{name}/{theirs}"] = getattr(module, ours).detach().cpu().numpy()

        def conv(module, name):
            arrays[name + "/kernel"] = np.ascontiguousarray(module.weight.detach().cpu().numpy().transpose(2, 3, 1, 0))

        def linear(module, name):
            arrays[name + "/kernel"] = np.ascontiguousarray(module.weight.detach().cpu().numpy().T)
            arrays[name + "/bias"] = module.bias.detach().cpu().numpy()

        self.walk(norm, conv), self.walk_heads(norm, linear)
        if self.lanes is not None:
            arrays["lanes"] = self.lanes.astype(np.float32)
        return arrays

    def walk_heads(self, norm, linear):
        linear(self.latent[0], "latent"), norm(self.latent[1], "latent/bn")
        for name, head in self.heads.items():
            linear(head, name)

    def walk(self, norm, conv):
        """Calls norm and conv with every layer of the extractor and its name in the pretrained file."""
        conv(self.stem, "conv1/conv"), norm(self.stem_norm, "conv1/bn"), norm(self.last, "bn")
        for i, block in enumerate(self.blocks):
            for j, layer in enumerate(block):
                name = f"conv{i + 2}_block{j + 1}"
                norm(layer.before, name + "_0_bn"), conv(layer.narrow, name + "_1_conv")
                norm(layer.between, name + "_1_bn"), conv(layer.wide, name + "_2_conv")
        for i, transition in enumerate(self.transitions):
            norm(transition.before, f"pool{i + 2}_bn"), conv(transition.narrow, f"pool{i + 2}_conv")


def fail(sentence):
    sys.exit(f"train.py: {sentence}")


def save(path, write):
    """Never a half-written file."""
    write(path + ".unfinished")
    os.replace(path + ".unfinished", path)


class Rows:
    """The lines of the manifests, and their labels as arrays. Folders of `tested` are tested on, by fold; those of
    `views` (more views of the same places) and `extra` (made-up rooms, outdoors) only train."""

    excluded = ()  # places that never train

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
        """Indices to train and to test on; None tests on nothing."""
        test = (self.fold == test_fold) & (self.kind == 0) if test_fold is not None else np.zeros(len(self.fold), bool)
        held_out = {self.location[i] for i in np.flatnonzero(test)}
        held_out.update(self.excluded)
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
    """Exposure and white balance: a factor of each linear channel."""
    return (2.0 ** random.normal(0.0, 0.25) * np.exp(random.normal(0.0, 0.06, 3))).astype(np.float32)


def augmented(rgb, random):
    """Exposure, white balance, noise, JPEG, field of view with the border filled."""
    gain = gain_of(random)
    x = rgb.astype(np.float32) / 255.0
    if random.random() < 0.5:  # a narrower camera, re-projected: what it does not see is the edge's colour
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
    """Copy 0 is the image, copy 1 its mirror image, further ones augmented, every other mirrored. A function of its
    arguments alone."""
    rgb = read_image(rows.image[index])
    if copy >= 2:
        rgb = augmented(rgb, np.random.default_rng([seed, rows.number[index], copy]))
    return np.ascontiguousarray(rgb[:, ::-1]) if copy % 2 == 1 else rgb


def label_of(rows, index, copy, seed):
    """The labels of that copy: a mirror image has the mirrored direction, and gains colour the light like the image."""
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
    """Of the images' bytes, in their order: whatever a folder is called, other images are other trunks."""
    whole = hashlib.sha256()
    for path in paths:
        whole.update(hashlib.sha256(read_bytes(path)).digest())
    return whole.hexdigest()


def cached_trunks(net, rows, arguments, device):
    """Half-precision trunks of every row and copy, one file for each folder and copy; what is there of the same images is
    not computed again. Returns a function from (row, copy) to a trunk."""
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
                     for at in range(0, len(file), 64)] if net.learned < LAYERS[3] else [file]
            trunks[key] = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return lambda i, c: trunks[rows.folder[i], c][rows.number[i]]


def packed(inputs):
    """In the order that convolutions like; features are not pixels."""
    return inputs.contiguous(memory_format=torch.channels_last) if inputs.dim() == 4 else inputs


def read_features(net, rows, arguments, paths):
    """Features made elsewhere in the place of trunks: a file for each folder, copy behind copy."""
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


def loss_of(estimate, labels):
    truth = {"direction": labels[:, :3], "light": labels[:, 3:6], "ambient": labels[:, 6:9], "contrast": labels[:, 9:]}
    return sum(w * F.mse_loss(estimate[k], truth[k]) for k, w in LOSS_WEIGHTS.items())


def angles_deg(a, b):
    return np.degrees(np.arccos(np.clip((a * b).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1), -1, 1)))


def measures(estimate, truth):
    angle = angles_deg(estimate[:, :3], truth[:, :3])
    return {"angle_mean": float(angle.mean()), "angle_median": float(np.median(angle)),
            "angle_p90": float(np.percentile(angle, 90)), "light": float(np.abs(estimate[:, 3:6] - truth[:, 3:6]).mean()),
            "ambient": float(np.abs(estimate[:, 6:9] - truth[:, 6:9]).mean()),
            "contrast": float(np.abs(estimate[:, 9] - truth[:, 9]).mean())}


def start_rows(arguments, rows, train_rows, net, trunk_of, device):
    """What heads start from: features and labels of every copy of the images to train on, weights (captured ones count 1
    together, others EXTRA_WEIGHT), and the errors of ridges within these folds."""
    last = arguments.layers == "last"
    pairs = [(i, c) for c in range(arguments.copies if last else 2) for i in train_rows]
    net.eval()
    parts = []
    with torch.no_grad():
        for at in range(0, len(pairs), 64):
            batch = pairs[at:at + 64]
            if last:
                inputs = packed(torch.from_numpy(np.stack([trunk_of(i, c) for i, c in batch]).astype(np.float32)).to(device))
            else:
                inputs = net.trunk(to_tensor([prepared(rows, i, c, arguments.seed) for i, c in batch], device))
            parts.append(net.features(inputs).cpu().numpy())
    labels = np.stack([label_of(rows, i, c, arguments.seed) for i, c in pairs]).astype(np.float64)
    extra = rows.kind[[i for i, _ in pairs]] == 2
    weights = np.where(extra, EXTRA_WEIGHT / max(1, extra.sum()), 1.0 / max(1, (~extra).sum()))
    features = np.concatenate(parts).astype(np.float64)
    folds = np.array([rows.fold[i] for i, _ in pairs])
    judged = (folds >= 0) & (extra if extra.all() else ~extra)
    errors = [ridge_errors(features, labels, weights, folds, judged, trust) for trust in net.trusts()]
    return features, labels, weights, None if errors[0] is None else np.stack(errors)


def start_heads(arguments, rows, train_rows, net, sources, device):
    """Of several sources of features, from the one whose direction is best within the folds that train. Which one that is, its
    ridges and trusts, and the least errors of each source within these folds."""
    starts = [start_rows(arguments, rows, train_rows, net, source, device) for source in sources]
    if len(sources) > 1 and starts[0][-1] is None:
        fail("--or-features chooses by the folds that train, and there are fewer than two; name more places")
    least = [errors.min((0, 1)).tolist() for *_, errors in starts if errors is not None]
    chosen = min(range(len(least)), key=lambda k: least[k][0], default=0)
    features, labels, weights, errors = starts[chosen]
    if errors is None:
        trusts, ridges = (len(net.trusts()) - 1,) * len(GROUPS), USUAL_RIDGES
    else:
        trusts = tuple(errors.min(1).argmin(0).tolist())
        ridges = tuple(best_ridges(errors[k])[group] for group, k in enumerate(trusts))
    net.start_at(features, labels, weights, ridges, trusts)
    return {"features": chosen, "ridges": ridges, "inner": least,
            **({} if net.lanes is None else {"trusts": [TRUSTS[k] for k in trusts]})}


def batches_of(rows, train_rows, epoch, arguments):
    """(row, copy) pairs of one epoch by batches: captured places `repeat` times, and a share of all else."""
    random = np.random.default_rng([arguments.seed, epoch])  # of the epoch: a resumed run draws what an unbroken one draws
    extra = rows.kind[train_rows] == 2
    drawn = random.permutation(train_rows[extra])[:round(arguments.share * extra.sum())]
    order = random.permutation(np.concatenate([drawn] + [train_rows[~extra]] * arguments.repeat))
    first, beyond = (0, arguments.copies) if arguments.layers == "last" else (2, 1 << 20)
    pairs = list(zip(order, random.integers(first, beyond, len(order))))
    batches = [pairs[at:at + arguments.batch] for at in range(0, len(pairs), arguments.batch)]
    return [b for b in batches if len(b) >= 2]  # batch normalisation needs two


def train(arguments):
    torch.set_num_threads(arguments.threads)
    device = torch.device("cuda" if torch.cuda.is_available() and not arguments.cpu else "cpu")
    rows = Rows(arguments.dataset, arguments.views, arguments.train_only)
    rows.excluded = arguments.exclude
    folds = [None] if arguments.all else arguments.test_fold
    for fold in folds:
        trained, tested = (len(part) for part in rows.split(fold))
        if trained == 0 or (tested == 0 and fold is not None):
            fail(f"fold {fold} leaves {trained} images to train on and {tested} to test on; choose another fold")
    torch.manual_seed(arguments.seed)
    net = LightNet()
    net.learned = arguments.learn if arguments.layers == "last" else LAYERS[3]
    has_heads = net.load(arguments.weights) if arguments.weights else False
    net.to(device, memory_format=torch.channels_last)
    sources = [None]
    if arguments.features:
        sets = [arguments.features] + arguments.or_features
        sources, has_heads = [read_features(net, rows, arguments, paths) for paths in sets], False
    elif arguments.layers == "last":
        sources = [cached_trunks(net, rows, arguments, device)]
    start = {k: v.clone() for k, v in net.state_dict().items()}
    for fold in folds:
        net.load_state_dict(start)
        train_fold(arguments, fold, rows, net, has_heads, sources, device)


def write_initial(arguments):
    torch.manual_seed(arguments.seed)
    net = LightNet()
    if arguments.weights:
        net.load(arguments.weights)
    if arguments.lanes:
        net.give_lanes()
    arrays = net.exported()

    def write(path):
        with open(path, "wb") as file:
            np.savez(file, **arrays, seed=np.array([arguments.seed], np.float32))
    save(arguments.export, write)


def layout_of(rgb):
    """Logarithms of the mean linear colours of 4 x 3 parts of an image."""
    x = rgb.astype(np.float32) / 255.0
    linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    parts = linear.reshape(3, HEIGHT // 3, 4, WIDTH // 4, 3).mean((1, 3))
    return np.log(parts + 0.02).reshape(-1)


def train_layout(arguments):
    """Pooling forgets where things are, and light labels of few places do not teach it; images do: the last layers learn
    to tell, from the pooled features alone, the colours of 4 x 3 parts of the image. No labels are used."""
    torch.set_num_threads(arguments.threads), torch.manual_seed(arguments.seed)
    device = torch.device("cuda" if torch.cuda.is_available() and not arguments.cpu else "cpu")
    rows = Rows((), (), arguments.train_only)
    net = LightNet()
    net.learned = arguments.learn
    net.load(arguments.weights)
    net.to(device, memory_format=torch.channels_last)
    trunk_of = cached_trunks(net, rows, arguments, device)
    pairs = [(i, c) for i in range(len(rows.image)) for c in range(arguments.copies)]
    layouts = torch.from_numpy(np.stack([layout_of(prepared(rows, i, c, arguments.seed)) for i, c in pairs])).to(device)
    layouts = (layouts - layouts.mean(0)) / layouts.std(0)
    read = nn.Sequential(nn.BatchNorm1d(1024, affine=False), nn.Linear(1024, layouts.shape[1])).to(device)
    extractor = list(net.blocks[3][LAYERS[3] - net.learned:].parameters()) + list(net.last.parameters())
    optimiser = torch.optim.AdamW([{"params": read.parameters(), "lr": arguments.rate},
                                   {"params": extractor, "lr": arguments.rate * arguments.extractor_rate}],
                                  weight_decay=arguments.decay)
    halving = torch.optim.lr_scheduler.StepLR(optimiser, max(1, arguments.epochs // 4), 0.5)
    for epoch in range(arguments.epochs):
        random = np.random.default_rng([arguments.seed, epoch])
        net.train_with(True), read.train()
        order, total = random.permutation(len(pairs)), 0.0
        for at in range(0, len(order) - 1, arguments.batch):
            chosen = order[at:at + arguments.batch]
            inputs = torch.from_numpy(np.stack([trunk_of(*pairs[i]) for i in chosen]).astype(np.float32)).to(device)
            loss = F.mse_loss(read(net.features(inputs.contiguous(memory_format=torch.channels_last))), layouts[chosen])
            optimiser.zero_grad(), loss.backward(), optimiser.step()
            total += float(loss.detach()) * len(chosen)
        halving.step()
        print(json.dumps({"epoch": epoch + 1, "unexplained": total / len(order)}), flush=True)
        arrays = {k: v for k, v in net.exported().items() if k.split("/")[0] not in ("latent", *LOSS_WEIGHTS)}
        def write(path):
            with open(path, "wb") as file:
                np.savez(file, **arrays)
        save(arguments.export, write)


def train_fold(arguments, fold, rows, net, has_heads, sources, device):
    torch.manual_seed(arguments.seed)
    train_rows, test_rows = rows.split(fold)
    captured = train_rows[rows.kind[train_rows] < 2]
    mean_light = rows.labels[captured if len(captured) else train_rows].mean(0)
    start = {} if has_heads else start_heads(arguments, rows, train_rows, net, sources, device)
    trunk_of = sources[start.get("features", 0)]
    last = arguments.layers == "last"
    net.dropout = arguments.dropout
    heads = {id(p) for p in net.heads_of().parameters()}
    extractor = list(net.blocks[3][LAYERS[3] - net.learned:].parameters()) + list(net.last.parameters()) if last else \
        [p for p in net.parameters() if id(p) not in heads]
    optimiser = torch.optim.AdamW([{"params": net.heads_of().parameters(), "lr": arguments.rate},
                                   {"params": extractor, "lr": arguments.rate * arguments.extractor_rate}],
                                  weight_decay=arguments.decay)
    halving = torch.optim.lr_scheduler.StepLR(optimiser, max(1, arguments.epochs // 4), 0.5)  # 15 of the source's 60
    name = "all" if fold is None else f"fold_{fold}"
    checkpoint = os.path.join(arguments.output, name + ".checkpoint")
    log, first, sums = [], 0, None
    if arguments.resume and os.path.exists(checkpoint):
        try:
            state = torch.load(checkpoint, map_location=device)
            net.load_state_dict(state["net"]), optimiser.load_state_dict(state["optimiser"])
            halving.load_state_dict(state["halving"])
            log, first, sums = state["log"], state["epoch"], state["sums"]
        except Exception:  # of bytes that are anything, torch.load raises anything
            fail(f"the checkpoint '{checkpoint}' is damaged or of another training; remove it to begin anew")

    def inputs_of(items, epoch):
        """Tensors and labels of (row, copy) pairs."""
        seed = arguments.seed if last else arguments.seed + epoch
        labels = torch.from_numpy(np.stack([label_of(rows, i, c, seed) for i, c in items])).to(device)
        if last:
            trunks = torch.from_numpy(np.stack([trunk_of(i, c) for i, c in items]).astype(np.float32)).to(device)
            return packed(trunks), labels
        return net.trunk(to_tensor([prepared(rows, i, c, seed) for i, c in items], device)), labels

    def estimates():
        net.eval()
        parts = []
        with torch.no_grad():
            for at in range(0, len(test_rows), 64):
                estimate = net.estimate(inputs_of([(i, 0) for i in test_rows[at:at + 64]], 0)[0])
                parts.append(torch.cat([estimate[k] for k in LOSS_WEIGHTS], 1).cpu().numpy())
        return np.concatenate(parts)

    if first == 0 and len(test_rows):
        log.append({"epoch": 0, **measures(estimates(), rows.labels[test_rows])})
        print(json.dumps(log[-1]), flush=True)
    for epoch in range(first, arguments.epochs):
        torch.manual_seed(arguments.seed * 1000 + epoch)
        net.train_with(not arguments.free_norm)
        total, images = 0.0, 0
        batches = batches_of(rows, train_rows, epoch, arguments)
        if not batches:
            fail("an epoch shows fewer than two images; raise --share or name more data sets")
        for chosen in batches:
            inputs, labels = inputs_of(chosen, epoch)
            loss = loss_of(net.estimate(inputs), labels)
            optimiser.zero_grad(), loss.backward(), optimiser.step()
            total, images = total + float(loss.detach()) * len(chosen), images + len(chosen)
        halving.step()
        log.append({"epoch": epoch + 1, "loss": total / images})
        if len(test_rows):
            log[-1].update(measures(estimates(), rows.labels[test_rows]))
        print(json.dumps(log[-1]), flush=True)
        if epoch >= arguments.epochs - max(1, arguments.epochs // 4):
            now = {k: v.double() for k, v in net.state_dict().items()}
            sums = now if sums is None else {k: sums[k] + v for k, v in now.items()}
        state = {"net": net.state_dict(), "optimiser": optimiser.state_dict(), "halving": halving.state_dict(), "log": log,
                 "epoch": epoch + 1, "sums": sums}
        save(checkpoint, lambda path: torch.save(state, path))
    if sums is not None:
        net.load_state_dict({k: (sums[k] / max(1, arguments.epochs // 4)).to(v.dtype) for k, v in net.state_dict().items()})
    result = {"fold": name, "train_images": len(train_rows), "test_images": len(test_rows),
              "test_locations": len({rows.location[i] for i in test_rows}), **start, "log": log,
              "arguments": vars(arguments)}
    if len(test_rows):
        made, truth = estimates(), rows.labels[test_rows]
        mean = mean_light[None].repeat(len(test_rows), 0)
        result.update(network=measures(made, truth), mean_training_light=measures(mean, truth))
        lines = ["image," + ",".join(LABELS)] + [
            os.path.basename(rows.image[i]) + "".join(f",{x:.6f}" for x in made[at]) for at, i in enumerate(test_rows)]
        save(os.path.join(arguments.output, name + "_estimates.csv"),
             lambda path: open(path, "w").write("\n".join(lines) + "\n"))
        for k in ("network", "mean_training_light"):
            print(k, json.dumps(result[k]), flush=True)
    save(os.path.join(arguments.output, name + ".json"), lambda path: open(path, "w").write(json.dumps(result, indent=1)))
    if arguments.export:
        def write(path):
            with open(path, "wb") as file:
                np.savez(file, **net.exported(), data_hash=np.frombuffer(rows.hash().encode(), np.uint8),
                         seed=np.array([arguments.seed], np.float32),
                         training_images=np.array([len(train_rows)], np.float32))
        save(arguments.export, write)


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"train.py: {message}; see train.py --help\n")


def number(kind, low, high=math.inf, above=False):
    """The type of an option: a number from `low` on, or above it, up to `high`."""
    def read(text):
        value = kind(text)
        if not (low < value if above else low <= value) or not value <= high or not math.isfinite(value):
            bound = f"above {low}" if above else f"from {low}"
            raise argparse.ArgumentTypeError(f"'{text}' is not a number {bound}" + ("" if high == math.inf else f" to {high}"))
        return value
    read.__name__ = "number"
    return read


def check_import(weights, reference):
    """The pretrained network against the reference outputs beside it: exit code 1 if a feature is off by over 1e-3."""
    net = LightNet()
    net.load(weights)
    net.eval()
    try:
        truth, worst = dict(np.load(reference)), 0.0
        assert all(name + end in truth for name in ("bird", "parrot", "cat") for end in ("/rgb_u8", "/feat1024"))
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, AssertionError):
        fail(f"'{reference}' holds no reference outputs; name densenet121_reference_outputs.npz")
    for name in ("bird", "parrot", "cat"):
        with torch.no_grad():
            features = net.features(net.prefix(net.trunk(to_tensor([truth[name + "/rgb_u8"]], "cpu"))))[0].numpy()
        worst = max(worst, float(np.abs(features - truth[name + "/feat1024"]).max()))
    print(f"greatest difference of a feature {worst:.2g}")
    return 0 if worst <= 1e-3 else 1


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("dataset", nargs="*", help="folders made by `sandglass dataset`")
    parser.add_argument("--views", nargs="*", default=[], help="folders with more views of the same places, to train on")
    parser.add_argument("--train-only", nargs="*", default=[], help="further folders that never test (made-up rooms)")
    parser.add_argument("--exclude", nargs="*", default=[], help="places that never train (their licence forbids it)")
    parser.add_argument("--weights", help="densenet121_imagenet_keras_fp32.npz or an exported file; without it, random")
    parser.add_argument("--check-import", metavar="REFERENCE", help="only compare the imported weights with this file")
    parser.add_argument("-o", "--output", default=".", help="folder for checkpoints, results and cached trunks")
    parser.add_argument("--cache", help="another folder for the cached trunks")
    parser.add_argument("--export", metavar="FILE", help="write the trained weights as .npz")
    parser.add_argument("--features", nargs="*", default=[], metavar="FILE",
                        help="of each folder, in their order, by `sandglass light-features`: only the heads are fitted")
    parser.add_argument("--or-features", nargs="+", action="append", default=[], metavar="FILE",
                        help="another such set, of another trunk: for each test fold the other folds choose; may be repeated")
    parser.add_argument("--initial", action="store_true", help="only write the weights that training starts from")
    parser.add_argument("--lanes", action="store_true", help="with --initial: channels that carry brightness past the pretrained layers")
    parser.add_argument("--layout", action="store_true", help="only teach the last layers where things are in images")
    parser.add_argument("--test-fold", type=number(int, 0), nargs="+", default=[1], help="one run for each")
    parser.add_argument("--all", action="store_true", help="train on every fold and test on none: for the shipped weights")
    parser.add_argument("--layers", choices=("last", "all"), default="last")
    parser.add_argument("--learn", type=int, choices=range(17), default=6, metavar="N",
                        help="how many of the last block's 16 layers learn with --layers last")
    parser.add_argument("--copies", type=number(int, 1), default=4, help="cached copies of an image, its mirror image among them")
    parser.add_argument("--repeat", type=number(int, 1), default=1, help="how often an epoch shows a captured image")
    parser.add_argument("--share", type=number(float, 0.0, 1.0), default=1.0, help="of the --train-only images that an epoch shows")
    parser.add_argument("--epochs", type=number(int, 0), default=24, help="0 only tests the weights")
    parser.add_argument("--batch", type=number(int, 2), default=64)
    parser.add_argument("--rate", type=number(float, 0.0, above=True), default=1e-3, help="of the heads")
    parser.add_argument("--extractor-rate", type=number(float, 0.0), default=0.3, help="of the DenseNet's layers, over that of the heads")
    parser.add_argument("--decay", type=number(float, 0.0), default=1e-2, help="of the weights, decoupled")
    parser.add_argument("--dropout", type=number(float, 0.0, 0.99), default=0.3)
    parser.add_argument("--free-norm", action="store_true", help="batch normalisations follow the data (random start)")
    parser.add_argument("--seed", type=number(int, 0, 2**32 - 1), default=1)
    parser.add_argument("--threads", type=number(int, 1, 256), default=1)
    parser.add_argument("--cpu", action="store_true", help="even where there is a GPU")
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
    if arguments.check_import:
        if not arguments.weights:
            fail("--check-import compares weights; name them with --weights")
        return check_import(arguments.weights, arguments.check_import)
    if arguments.lanes and not (arguments.initial and arguments.weights):
        fail("--lanes changes weights as they begin; name them with --weights, beside --initial")
    if arguments.initial:
        if not arguments.export:
            fail("--initial writes weights; name the file with --export")
        write_initial(arguments)
        return 0
    if arguments.features and (arguments.epochs or arguments.layers != "last"):
        fail("--features fits only the heads; give --epochs 0 and --layers last")
    if arguments.or_features and (not arguments.features or arguments.export):
        fail("--or-features only tests a choice, beside --features; leave out --export, or name what was chosen with --features")
    if not arguments.dataset and not ((arguments.all or arguments.layout) and arguments.train_only):
        fail("no data set is named; make one with `sandglass dataset`")
    try:
        os.makedirs(arguments.output, exist_ok=True)
    except OSError:
        fail(f"the folder '{arguments.output}' cannot be made; name another with -o")
    if arguments.layout:
        if not (arguments.train_only and arguments.export and arguments.weights):
            fail("--layout learns from the images of --train-only and --weights for --export; name all three")
        train_layout(arguments)
        return 0
    train(arguments)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as error:
        fail(f"{error}; check the path, its permissions and the space left")
    except KeyboardInterrupt:
        sys.exit(130)
