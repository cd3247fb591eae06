"""The lighting network in PyTorch: DenseNet-121 with lanes for brightness, and its heads.

An exported file holds the weights in float. The DenseNet's arrays have the names of the pretrained file, without fc1000.
Convolutions are HWIO. Every batch normalisation is gamma, beta, moving_mean and moving_variance (epsilon 1.001e-5). The heads:
  latent/kernel (1024, 512), latent/bias, latent/bn/{gamma,beta,moving_mean,moving_variance} (epsilon 1e-5), then ELU,
  direction/kernel (512, 3), direction/bias (tanh, then normalised), light/..., ambient/... (3), contrast/... (1; sigmoid).
"""

import math
import zipfile
import zlib

import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

from light_data import GROUPS, LABELS, fail
from light_ridge import TRUSTS, Regression

LAYERS, GROWTH, BOTTLENECK, EPSILON = (6, 12, 24, 16), 32, 128, 1.001e-5
MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
NORM_NAMES = (("weight", "gamma"), ("bias", "beta"), ("running_mean", "moving_mean"), ("running_var", "moving_variance"))
COPIES_OF_START, SHIFT_OF_START = 16, 3.0
LANES = tuple((channel, threshold) for threshold in (0.0, 0.5, 0.75, 0.9) for channel in range(3))  # brightness in sRGB
LAYOUT_LAYERS = 4  # shifts by so many of the last map's 6 rows and 8 columns


def expected(norm, at):
    """The mean and the deviation of the channels `at` after a batch normalisation and ReLU. Assumes normal distributions."""
    shift, spread = norm.bias[at].double(), norm.weight[at].double().abs() + 1e-9
    below = 0.5 * (1 + torch.erf(shift / spread / 2**0.5))
    density = spread * torch.exp(-0.5 * (shift / spread) ** 2) / math.sqrt(2 * math.pi)
    mean = shift * below + density
    return mean, ((shift**2 + spread**2) * below + shift * density - mean**2).clamp(min=0).sqrt()


def pass_through(norm, at):
    """Makes a batch normalisation leave the channels `at` as they are. They are not negative: the ReLU does not change them."""
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
    """Pools before the 1x1 convolution. Both are linear, so only a quarter of the multiplications is left."""

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
        self.lanes = None  # which features belong to lanes, if there are lanes
        self.heads = nn.ModuleDict({k: nn.Linear(512, n) for k, n in (("direction", 3), ("light", 3), ("ambient", 3), ("contrast", 1))})

    def readers(self, stage):
        """The layers that read the maps of one width. Each is a batch normalisation, the 1 x 1 convolution after it, and the
        normalisations after that."""
        layers = [(layer.before, layer.narrow, [layer.between]) for layer in self.blocks[stage]]
        if stage == 3:
            return layers + [(self.last, None, [])]
        transition = self.transitions[stage]
        return layers + [(transition.before, transition.narrow, [norm for norm, *_ in self.readers(stage + 1)])]

    def free(self, readers, at):
        """Makes the readers use only the means of the channels `at`. All normalisations then leave these channels as they are."""
        for before, narrow, behind in readers:
            if narrow is not None:
                constant = (narrow.weight[:, at, 0, 0].double() @ expected(before, at)[0]).float()
                for norm in behind:
                    norm.running_mean[: len(constant)] -= constant
                narrow.weight[:, at] = 0
            pass_through(before, at)

    @torch.no_grad()
    def give_lanes(self):
        count, places = len(LANES), []
        for stage, width in enumerate((64, 128, 256, 512)):
            use, every = torch.zeros(width, dtype=torch.float64), torch.arange(width)
            for before, narrow, _ in self.readers(stage)[: LAYERS[stage] + (stage < 3)]:
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
            self.free(self.readers(3)[layer + 1 :], at)
            up, left = (places[3], places[3]) if layer == first else made[layer - first - 1].chunk(2)
            read = block[layer]
            read.narrow.weight[: 2 * count] = 0
            read.narrow.weight[torch.arange(2 * count), torch.cat([up, left])] = 1.0
            pass_through(read.between, torch.arange(2 * count))
            read.wide.weight[:, : 2 * count], read.wide.weight[: 2 * count] = 0, 0
            for k in range(count):  # the row below, the column to the right
                read.wide.weight[k, k, 2, 1] = read.wide.weight[count + k, count + k, 1, 2] = 1.0
        self.lanes = np.isin(np.arange(self.last.num_features), torch.cat([places[3]] + made).numpy())

    def features(self, rgb):
        """Maps sRGB in 0..1 to the means of the last maps."""
        mean, deviation = (torch.tensor(t).view(1, 3, 1, 1) for t in (MEAN, DEVIATION))
        x = F.max_pool2d(F.relu(self.stem_norm(self.stem((rgb - mean) / deviation))), 3, 2, 1)
        for block, transition in zip(self.blocks, self.transitions):
            x = transition(block(x))
        return F.relu(self.last(self.blocks[3](x))).mean((2, 3))

    def estimate(self, features):
        latent = self.latent(features)
        out = {k: head(latent) for k, head in self.heads.items()}
        return torch.cat(
            [F.normalize(torch.tanh(out["direction"]), dim=1)] + [torch.sigmoid(out[k]) for k in ("light", "ambient", "contrast")], 1
        )

    def trusts(self):
        """The factors of the standardised features from which training chooses."""
        return [1.0] if self.lanes is None else [np.where(self.lanes, 1.0, trust) for trust in TRUSTS]

    def give_heads(self, features, labels, weights, ridges, chosen_trusts):
        """Makes the heads weighted ridge regressions of the labels on features (float64, by rows). The first 10 * COPIES_OF_START
        latent units carry the solutions, COPIES_OF_START copies of each, shifted to where ELU is the identity. The other units are
        without effect."""
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
            linear.weight[: len(to)] = torch.from_numpy(slopes.T.astype(np.float32))[to]
            outputs = torch.from_numpy(features.astype(np.float32)) @ linear.weight.T
            shares = torch.from_numpy(weights.astype(np.float32))
            norm.running_mean.copy_((shares * outputs).sum(0))
            norm.running_var.copy_((shares * (outputs - norm.running_mean) ** 2).sum(0))
            norm.bias[: len(to)] = SHIFT_OF_START
            j = 0
            for head in self.heads.values():
                for row in range(len(head.bias)):
                    head.weight[row, j * COPIES_OF_START : (j + 1) * COPIES_OF_START] = float(spread[j]) / COPIES_OF_START
                    head.bias[row] = float(answer[j] - SHIFT_OF_START * spread[j])
                    j += 1

    def load(self, path):
        """Loads a pretrained or an exported file. Returns whether it has heads. Without them the heads stay as they are."""
        these = "name densenet121_imagenet_keras_fp32.npz or what --export wrote"
        try:
            arrays = dict(np.load(path))
        except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, zlib.error):
            fail(f"'{path}' is no file of weights; {these}")
        if "lanes" in arrays:
            if arrays["lanes"].shape != (self.last.num_features,):
                fail(f"the array lanes of '{path}' has another shape than the network's features; {these}")
            self.lanes = arrays["lanes"] > 0
        has_heads = "latent/kernel" in arrays
        for name, parameter, axes in self.arrays(has_heads):
            if name not in arrays:
                fail(f"'{path}' has no array {name}; {these}")
            values = arrays[name].transpose(np.argsort(axes)) if arrays[name].ndim == len(axes) else arrays[name]
            if values.shape != tuple(parameter.shape):
                fail(f"the array {name} of '{path}' has another shape than the network; {these}")
            parameter.data = torch.from_numpy(np.ascontiguousarray(values, np.float32))
        return has_heads

    def exported(self):
        """The arrays of --export."""
        arrays = {
            name: np.ascontiguousarray(parameter.detach().cpu().numpy().transpose(axes)) for name, parameter, axes in self.arrays(True)
        }
        if self.lanes is not None:
            arrays["lanes"] = self.lanes.astype(np.float32)
        return arrays

    def arrays(self, with_heads):
        """The arrays of a file: the name, the parameter, and the parameter's axes in the file's order."""

        def norm(name, module):
            for ours, theirs in NORM_NAMES:
                yield f"{name}/{theirs}", getattr(module, ours), (0,)

        def conv(name, module):  # OIHW here, HWIO in the file
            yield name + "/kernel", module.weight, (2, 3, 1, 0)

        def linear(name, module):
            yield name + "/kernel", module.weight, (1, 0)
            yield name + "/bias", module.bias, (0,)

        yield from conv("conv1/conv", self.stem)
        yield from norm("conv1/bn", self.stem_norm)
        yield from norm("bn", self.last)
        for i, block in enumerate(self.blocks):
            for j, layer in enumerate(block):
                name = f"conv{i + 2}_block{j + 1}"
                yield from norm(name + "_0_bn", layer.before)
                yield from conv(name + "_1_conv", layer.narrow)
                yield from norm(name + "_1_bn", layer.between)
                yield from conv(name + "_2_conv", layer.wide)
        for i, transition in enumerate(self.transitions):
            yield from norm(f"pool{i + 2}_bn", transition.before)
            yield from conv(f"pool{i + 2}_conv", transition.narrow)
        if with_heads:
            yield from linear("latent", self.latent[0])
            yield from norm("latent/bn", self.latent[1])
            for name, head in self.heads.items():
                yield from linear(name, head)
