"""The lighting network in PyTorch: DenseNet-121 by the pretrained file's names, with lanes for brightness, and its heads.

An exported file holds the float weights as the pretrained file names them (convolutions HWIO; every batch normalisation apart
as gamma, beta, moving_mean, moving_variance; epsilon 1.001e-5), without fc1000, and behind them
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
    """The mean and deviation of the channels `at` behind a batch normalisation and ReLU, if they are distributed normally."""
    shift, spread = norm.bias[at].double(), norm.weight[at].double().abs() + 1e-9
    below = 0.5 * (1 + torch.erf(shift / spread / 2 ** 0.5))
    density = spread * torch.exp(-0.5 * (shift / spread) ** 2) / math.sqrt(2 * math.pi)
    mean = shift * below + density
    return mean, ((shift ** 2 + spread ** 2) * below + shift * density - mean ** 2).clamp(min=0).sqrt()


def pass_through(norm, at):
    """A batch normalisation that leaves the channels `at` as they are. They are not negative, so the ReLU does not change them."""
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
        self.dropout = 0.0  # share of the 512 units, in training
        self.lanes = None  # which features belong to lanes, if there are lanes
        self.learned = LAYERS[3]  # how many layers of the last block are not in the trunk that is kept on disk
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
        """Of the channels `at` only the means are read, and all normalisations leave them as they are."""
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
        """From sRGB 0..1 to the input of the last dense block, 512 x 6 x 8."""
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
        """The factors of the standardised features that may be chosen."""
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
