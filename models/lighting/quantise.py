#!/usr/bin/env python3
"""Turns the trained network, in float, into the bytes that the runtime reads (runtime/asset/light.fbs).

WEIGHTS is what `train.py --export` wrote. The images are those of data sets (`sandglass dataset`), evenly spread.

How bytes are chosen. Every channel of a feature map has a scale and a zero point of its own. Its range is that of the calibration
images and a tenth more on both sides (cutting off costs more than coarser steps: quantiles were worse by a fifth). The scale of an
input becomes part of the weights that read it. The weights of an output have one scale, which adds the least noise given how much
each input varies. They are rounded together (`rounded`), and the bias is corrected for the change of the output's mean. At the end
each feature is fitted to the float network's. For that the runtime itself runs the bytes (`sandglass light-features`).

Exit code 1: the bytes are further from the float network than the limits, on images that did not calibrate.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from types import SimpleNamespace

import numpy as np
import torch
import torch.nn.functional as F

sys.dont_write_bytecode = True
from light_data import Rows, fail, read_image, save, to_tensor
from light_file import Convolution, light_file_bytes
from light_network import DEVIATION, LAYERS, MEAN, LightNet

MARGIN = 0.1  # the share of a range that is added beyond the observed values
SAMPLES_AN_IMAGE = 128  # samples of products
RIDGE = 0.5  # added to a byte's variance; rounding alone makes a variance of 1/12
BIAS_LIMIT = 2.0**28
FLOAT_LIMIT = 1e9  # greatest number of a float network in a file
FIT_SLOPES = 0.5, 1.5
ANGLE_LIMIT_DEG, DIFFERENCE_LIMIT = 1.0, 0.01  # of medians over images: the direction; colours and contrast


class Seen:
    """The observed values of the channels at one place in the network."""

    count = 0

    def note(self, values):
        """`values`: pixels x channels."""
        x = values.astype(np.float64)
        least, greatest, sums = x.min(0), x.max(0), np.stack([x.sum(0), (x * x).sum(0), (x == 0).sum(0)])
        first = self.count == 0
        self.least = least if first else np.minimum(self.least, least)
        self.greatest = greatest if first else np.maximum(self.greatest, greatest)
        self.sums = sums if first else self.sums + sums
        self.count += len(x)

    def moments(self):
        mean = self.sums[0] / self.count
        return mean, np.maximum(0.0, self.sums[1] / self.count - mean * mean)


class Products:
    """Sums of the inputs of a convolution, and of their products."""

    count = 0

    def note(self, samples):
        x = samples.astype(np.float64)
        sums, products = x.sum(0), x.T @ x
        self.sums, self.products = (sums, products) if self.count == 0 else (self.sums + sums, self.products + products)
        self.count += len(x)

    def factor(self, units):
        """M of covariance + RIDGE = M D M^T, unit upper triangular, for inputs divided by `units` (0: an input that does not count)."""
        mean, units = self.sums / self.count, np.resize(units, len(self.sums))
        divided = np.divide(1.0, units, out=np.zeros_like(units), where=units != 0)
        covariance = (self.products / self.count - np.outer(mean, mean)) * np.outer(divided, divided)
        lower = np.linalg.cholesky((covariance + RIDGE * np.eye(len(units)))[::-1, ::-1])  # from the last input to the first
        return (lower / np.diag(lower))[::-1, ::-1]


def pixels_of(values):
    """A tensor 1 x channels x rows x columns as pixels x channels."""
    return np.ascontiguousarray(values[0].permute(1, 2, 0).reshape(-1, values.shape[1]).numpy())


def windows_of(values):
    """The 3 x 3 windows around all pixels: row, column, channel. Beyond the edge lie zeros."""
    padded = F.pad(values, (1, 1, 1, 1))[0].permute(1, 2, 0)
    rows, columns = values.shape[2:]
    parts = [padded[y : y + rows, x : x + columns] for y in range(3) for x in range(3)]
    return torch.cat(parts, 2).reshape(rows * columns, -1).numpy()


class Observations:
    """What the places of a float network hold while it runs on images."""

    def __init__(self, net):
        layers, transitions = [layer for block in net.blocks for layer in block], len(net.transitions)
        self.images, self.hooks, self.stem, self.last = 0, [], Seen(), Seen()
        self.narrow_inputs, self.bottlenecks, self.growths = ([Seen() for _ in layers] for _ in range(3))
        self.transition_inputs, self.transitions = ([Seen() for _ in range(transitions)] for _ in range(2))
        self.narrow_products, self.wide_products = ([Products() for _ in layers] for _ in range(2))
        self.transition_products = [Products() for _ in range(transitions)]
        self.watch(net.stem, lambda given, made: self.next_image())
        self.watch_rectified(net.stem_norm, self.stem)
        for at, layer in enumerate(layers):
            self.watch_rectified(layer.before, self.narrow_inputs[at])
            self.watch_rectified(layer.between, self.bottlenecks[at])
            self.watch(layer.narrow, self.products(self.narrow_products[at], pixels_of))
            self.watch(layer.wide, self.products(self.wide_products[at], windows_of, self.growths[at]))
        for at, transition in enumerate(net.transitions):
            self.watch_rectified(transition.before, self.transition_inputs[at])
            self.watch(transition.narrow, self.products(self.transition_products[at], pixels_of, self.transitions[at]))
        self.watch_rectified(net.last, self.last)

    def next_image(self):
        self.images += 1

    def watch(self, module, note):
        self.hooks.append(module.register_forward_hook(lambda _, given, made: note(given[0], made)))

    def watch_rectified(self, norm, seen):
        self.watch(norm, lambda given, made: seen.note(pixels_of(F.relu(made))))

    def products(self, products, rows_of, outputs=None):
        """Some rows of a convolution's inputs, at equal distances; each image has different ones. And what it makes."""

        def note(given, made):
            rows = rows_of(given)
            products.note(rows[(np.arange(len(rows)) + 7 * self.images) % max(1, len(rows) // SAMPLES_AN_IMAGE) == 0])
            if outputs is not None:
                outputs.note(pixels_of(made))

        return note

    def end(self):
        for hook in self.hooks:
            hook.remove()


def features_of(net, rgb):
    return net.features(to_tensor([rgb]))[0].numpy()


def affine_of(norm):
    """A batch normalisation as a factor and a summand of each channel."""
    scale = (norm.weight / torch.sqrt(norm.running_var + norm.eps)).numpy()
    return scale, norm.bias.numpy() - norm.running_mean.numpy() * scale


def kernel_of(convolution):
    """Places (row, column, input) x outputs."""
    weights = convolution.weight.permute(2, 3, 1, 0)
    return weights.reshape(-1, weights.shape[3]).numpy().astype(np.float64)


def latent_of(net):
    """The latent layer with its batch normalisation: features x outputs, and the bias."""
    scale, shift = affine_of(net.latent[1])
    linear = net.latent[0]
    return (linear.weight.numpy() * scale[:, None]).T, (linear.bias.numpy() - net.latent[1].running_mean.numpy()) * scale + net.latent[
        1
    ].bias.numpy()


def heads_of(net):
    return tuple(torch.cat([getattr(head, part) for head in net.heads.values()]).numpy() for part in ("weight", "bias"))


# --- Bytes


def grid_of(seen, rectified):
    """The bytes of a channel stand for step * (byte - zero)."""
    margin = MARGIN * (seen.greatest - seen.least)
    low, high = np.zeros_like(margin) if rectified else seen.least - margin, seen.greatest + margin
    width = np.maximum(high - low, 1e-6 * np.maximum(1.0, np.abs(high)))
    return SimpleNamespace(step=width / 255, zero=-low * 255 / width)


def inputs_of(slope, origin=0.0, constant=0.0, mean=0.0, variance=0.0, low=None, high=None):
    """Inputs enter a convolution as slope * (clamped byte - origin) + constant. Mean and variance are those of the byte."""
    wide = [np.broadcast_to(np.asarray(v, np.float64), slope.shape) for v in (origin, constant, mean, variance)]
    return SimpleNamespace(slope=slope, origin=wide[0], constant=wide[1], mean=wide[2], variance=wide[3], low=low, high=high)


def rectified_inputs(grid, norm, seen):
    """The inputs max(0, scale x + shift) of bytes of the grid."""
    scale, shift = (v.astype(np.float64) for v in affine_of(norm))
    slope, (mean, variance) = scale * grid.step, seen.moments()
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        threshold = grid.zero - shift / slope  # the byte at which it crosses zero
    never = np.where(slope > 0, threshold >= 255, threshold <= 0)
    depends = np.abs(slope) > 1e-12
    used = depends & np.isfinite(threshold) & ~never
    slope, threshold = np.where(used, slope, 1.0), np.where(used, threshold, 0.0)
    whole = np.clip(np.rint(threshold), 0, 255)
    cuts = (threshold > 0) & (threshold < 255)
    # Below the threshold the result is not zero but the threshold's rounding error. On average that is a constant.
    constant = -np.where(cuts, seen.sums[2] / seen.count, 0.0) * slope * (whole - threshold)
    byte = np.clip(threshold + (mean - constant) / slope, 0.0, 255.0)
    return inputs_of(
        np.where(used, slope, 0.0),
        threshold,
        np.where(used, constant, np.where(depends & never, 0.0, mean)),
        np.where(used, byte, 0.0),
        np.where(used, variance / (slope * slope), 0.0),
        np.where(used & (slope > 0), whole, 0).astype(np.uint8),
        np.where(used & (slope < 0), whole, 255).astype(np.uint8),
    )


def plain_inputs(grid, seen):
    """Inputs without a rectifier. Byte 0 stands for the value 0."""
    mean, variance = seen.moments()
    return inputs_of(grid.step, mean=mean / grid.step, variance=variance / (grid.step * grid.step))


def image_inputs():
    mean, deviation = 255 * np.array(MEAN), 255 * np.array(DEVIATION)
    return inputs_of(1 / deviation, mean, mean=mean, variance=deviation * deviation)


def rounded(aims, factor):
    """Integers in -127..127 for `aims` (places x outputs) that change the outputs least.

    Rounding to nearest is best for each weight alone. For their sum it is better that each weight makes up for the errors of those
    before it, as far as their inputs vary together. With the inputs' covariance H = M D M^T, the errors e of an output's weights
    cost e H e^T = sum_k D_k ((e M)_k)^2. So weight k aims at aims_k - sum_{j<k} e_j M_jk."""
    if factor is None:
        return np.clip(np.rint(aims), -127, 127)
    integers, owed = np.empty_like(aims), np.zeros((aims.shape[0], aims.shape[1]), factor.dtype)
    for k in range(len(aims)):
        integers[k] = np.clip(np.rint(aims[k] - owed[k]), -127, 127)
        errors = (integers[k] - aims[k]).astype(factor.dtype)
        owed[k + 1 :] += factor[k, k + 1 :, None] * errors
    return integers


def byte_rows(weights, constant, inputs, factor=None):
    """Integers (places x outputs), scales and biases of outputs scale * (sum of integer * byte) + bias. `weights` are those of the
    inputs' values, for all places; `constant` is added."""
    each = {name: np.resize(getattr(inputs, name), len(weights))[:, None] for name in ("slope", "origin", "constant", "mean", "variance")}
    of_bytes = weights * each["slope"]
    bias = constant + (weights * (each["constant"] - each["slope"] * each["origin"])).sum(0)
    largest = np.abs(of_bytes).max(0)
    reach, best, least, share = np.where(largest > 0, largest, 127.0), 1.0, np.inf, 1.0
    while share > 0.35:
        scale = share * reach / 127
        errors = of_bytes - scale * np.clip(np.rint(of_bytes / scale), -127, 127)
        noise = (errors * errors * each["variance"]).sum(0)
        best, least, share = np.where(noise < least, scale, best), np.minimum(noise, least), share - 0.05
    integers = rounded(of_bytes / best, factor)
    return integers, best, bias + ((of_bytes - best * integers) * each["mean"]).sum(0)


def byte_convolution(convolution, behind, inputs, outputs, products=None):
    """`behind`: the normalisation after it, or None. `outputs`: the grid of what it writes."""
    weights, shift = kernel_of(convolution), 0.0
    if behind is not None:
        scale, shift = (v.astype(np.float64) for v in affine_of(behind))
        weights = weights * scale
    integers, scale, bias = byte_rows(weights, shift, inputs, None if products is None else products.factor(inputs.slope))
    bias = bias + outputs.step * outputs.zero
    # The bias may be at most 2^28 steps. So an output that hardly depends on its inputs gets coarser steps.
    scale = np.maximum(scale, np.abs(bias) / BIAS_LIMIT)
    return Convolution(
        np.ascontiguousarray(integers.T).astype(np.int8),
        np.rint(bias / scale).astype(np.int32),
        (scale / outputs.step).astype(np.float32),
        inputs.low,
        inputs.high,
    )


def put_latent(net, inputs, file):
    weights, bias = latent_of(net)
    integers, scale, bias = byte_rows(weights.astype(np.float64), bias.astype(np.float64), inputs)
    file.latent_weights = np.ascontiguousarray(integers.T).astype(np.int8)
    file.latent_scale, file.latent_bias = scale.astype(np.float32), bias.astype(np.float32)


def quantised(net, seen):
    file = SimpleNamespace(layers=LAYERS, narrow=[], wide=[], transition=[], border=np.rint(255 * np.array(MEAN)).astype(np.uint8))
    block, at = grid_of(seen.stem, True), 0
    file.stem = byte_convolution(net.stem, net.stem_norm, image_inputs(), block)
    for b, layers in enumerate(net.blocks):
        for layer in layers:
            bottleneck, growth = grid_of(seen.bottlenecks[at], True), grid_of(seen.growths[at], False)
            inputs = rectified_inputs(block, layer.before, seen.narrow_inputs[at])
            file.narrow.append(byte_convolution(layer.narrow, layer.between, inputs, bottleneck, seen.narrow_products[at]))
            inputs = plain_inputs(bottleneck, seen.bottlenecks[at])
            file.wide.append(byte_convolution(layer.wide, None, inputs, growth, seen.wide_products[at]))
            block = SimpleNamespace(step=np.append(block.step, growth.step), zero=np.append(block.zero, growth.zero))
            at += 1
        if b == len(net.transitions):
            break
        inputs = rectified_inputs(block, net.transitions[b].before, seen.transition_inputs[b])
        block = grid_of(seen.transitions[b], False)
        file.transition.append(byte_convolution(net.transitions[b].narrow, None, inputs, block, seen.transition_products[b]))
    inputs = rectified_inputs(block, net.last, seen.last)
    file.last_low, file.last_high = inputs.low, inputs.high
    file.feature_scale = inputs.slope.astype(np.float32)
    file.feature_shift = (inputs.constant - inputs.slope * inputs.origin).astype(np.float32)
    put_latent(net, inputs, file)
    file.heads_weights, file.heads_bias = heads_of(net)
    file.calibration_images, file.angle_deg, file.difference, file.float_parameters = seen.images, 0.0, 0.0, None
    return file


def byte_features(file, averages):
    return file.feature_scale * averages + file.feature_shift


def fit_features(net, truth, averages, file):
    """Fits each feature's scale and shift to the float network's, and adapts the layer that reads them. Rounding everywhere shifts a
    feature on average and makes it flatter or steeper. `truth` and `averages` have one row for each calibration image."""
    scale, shift = file.feature_scale.astype(np.float64), file.feature_shift.astype(np.float64)
    features, truth = byte_features(file, averages).astype(np.float64), truth.astype(np.float64)
    mean, answer = (features / len(features)).sum(0), (truth / len(truth)).sum(0)
    x = features - mean
    squares = (x * x).sum(0)
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.where(squares > 0, np.clip((x * (truth - answer)).sum(0) / squares, *FIT_SLOPES), 1.0)
        byte = np.where(scale != 0, (mean - shift) / scale, 0.0)
        variance = np.where(scale != 0, squares / len(features) / (scale * scale), 0.0)
    inputs = inputs_of(slope * scale, constant=answer + slope * (shift - mean), mean=byte, variance=variance)
    file.feature_scale, file.feature_shift = inputs.slope.astype(np.float32), inputs.constant.astype(np.float32)
    put_latent(net, inputs, file)


# --- The float network beside the bytes


def float_parameters(net):
    """As light.fbs describes them: rounded only to float, and not calibrated."""
    parts = []

    def add_convolution(convolution, slope, constant, behind):
        weights, bias = kernel_of(convolution), 0.0
        if behind is not None:
            scale, bias = (v.astype(np.float64) for v in affine_of(behind))
            weights = weights * scale
        slope, constant = (np.resize(v, len(weights))[:, None] for v in (slope, constant))
        parts.extend([(weights * slope).T.ravel(), bias + (weights * constant).sum(0)])

    def add_clamps(norm):
        """The input max(0, scale x + shift) is scale * clamped x + shift. Returns factor and summand."""
        scale, shift = (v.astype(np.float64) for v in affine_of(norm))
        crosses = np.abs(shift) < FLOAT_LIMIT * np.abs(scale)  # if not, the shift alone decides
        zero = -shift / np.where(crosses, scale, 1.0)
        parts.append(np.where(crosses & (scale > 0), zero, -FLOAT_LIMIT))
        parts.append(np.where(crosses & (scale < 0), zero, FLOAT_LIMIT))
        used = crosses | (shift > 0)
        return np.where(used, scale, 0.0), np.where(used, shift, 0.0)

    mean, deviation = 255 * np.array(MEAN), 255 * np.array(DEVIATION)
    parts.append(mean)
    add_convolution(net.stem, 1 / deviation, -mean / deviation, net.stem_norm)
    for b, block in enumerate(net.blocks):
        for layer in block:
            add_convolution(layer.narrow, *add_clamps(layer.before), layer.between)
            add_convolution(layer.wide, 1.0, 0.0, None)
        if b < len(net.transitions):
            add_convolution(net.transitions[b].narrow, *add_clamps(net.transitions[b].before), None)
    parts.extend(add_clamps(net.last))
    weights, bias = latent_of(net)
    parts.extend([weights.ravel(), bias])
    return np.concatenate(parts).astype(np.float32)


# --- The command


def pictures_in(folders):
    paths = sorted(Rows(folders).image)
    if len(paths) < 4:
        fail(f"'{folders[0]}' has fewer than 4 images; name larger data sets")
    return paths


def spread_over(paths, count):
    count = min(count, len(paths))
    return [paths[i * len(paths) // count] for i in range(count)]


def averages_of(program, file, images):
    """The averages in bytes that the runtime's features are made of, for each image."""
    scale, shift = file.feature_scale, file.feature_shift
    file.feature_scale, file.feature_shift = np.ones_like(scale), np.zeros_like(shift)
    with tempfile.TemporaryDirectory() as folder:
        network, data_set, features = (os.path.join(folder, name) for name in ("averages.light", "set", "features.npy"))
        with open(network, "wb") as out:
            out.write(light_file_bytes(file))
        os.mkdir(data_set)
        for i, image in enumerate(images):
            os.symlink(os.path.abspath(image), os.path.join(data_set, f"{i}.png"))
        with open(os.path.join(data_set, "manifest.csv"), "w") as out:
            out.write("image\n" + "".join(f"{i}.png\n" for i in range(len(images))))
        try:
            subprocess.run([program, "light-features", network, data_set, "-o", features], check=True, stdout=subprocess.DEVNULL)
        except (OSError, subprocess.CalledProcessError) as error:
            fail(f"the runtime did not run the bytes ({error}); name the program `sandglass` with --program")
        averages = np.load(features)
    file.feature_scale, file.feature_shift = scale, shift
    return averages


def estimates_of(net, features):
    """In float, from float features: ten numbers an image."""
    with torch.no_grad():
        return net.estimate(torch.from_numpy(features)).double().numpy()


def byte_estimates(file, averages):
    """The same as the runtime gives it."""
    latent = averages.astype(np.float64) @ file.latent_weights.T.astype(np.float64) * file.latent_scale + file.latent_bias
    out = np.where(latent > 0, latent, np.expm1(np.minimum(latent, 0))) @ file.heads_weights.T.astype(np.float64) + file.heads_bias
    direction = np.tanh(out[:, :3])
    return np.concatenate([direction / np.linalg.norm(direction, axis=1, keepdims=True), 1 / (1 + np.exp(-out[:, 3:]))], 1)


def quantile(values, share):
    return float(np.sort(values)[int(share * (len(values) - 1) + 0.5)])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("weights", help="what `train.py --export` wrote")
    parser.add_argument("--calibrate", nargs="+", required=True, metavar="FOLDER", help="data sets whose images give the ranges")
    parser.add_argument(
        "--measure",
        nargs="+",
        default=[],
        metavar="FOLDER",
        help="data sets to compare with the float network on; without them, every other image of --calibrate",
    )
    parser.add_argument("--images", type=int, default=96, metavar="N", help="images to calibrate with, and as many to measure on")
    parser.add_argument("--name", default="lighting", help="the name of the network in its file")
    parser.add_argument("--keep-float", action="store_true", help="keep the float network beside the bytes, for XNNPACK in float (30 MB)")
    parser.add_argument("--program", default="sandglass", help="the program `sandglass`, whose runtime runs the bytes")
    parser.add_argument("-o", "--output", required=True, help="the lighting file to write")
    options = parser.parse_args()
    if options.images < 2:
        fail("--images is the number of images to calibrate with; give at least 2")
    if options.measure:
        calibration = spread_over(pictures_in(options.calibrate), options.images)
        measured = spread_over(pictures_in(options.measure), options.images)
    else:
        both = spread_over(pictures_in(options.calibrate), 2 * options.images)
        calibration, measured = both[::2], both[1::2]
    net = LightNet()
    if not net.load(options.weights):
        fail(f"'{options.weights}' has no heads; name what train.py --export wrote")
    arrays = np.load(options.weights)
    net.eval().requires_grad_(False)
    seen = Observations(net)
    truth = np.stack([features_of(net, read_image(path)) for path in calibration])
    seen.end()
    features = np.stack([features_of(net, read_image(path)) for path in measured])
    file = quantised(net, seen)
    file.name = options.name
    file.data_hash = int(bytes(arrays["data_hash"]).decode(), 16) if "data_hash" in arrays else 0
    file.seed, file.training_images = (int(arrays[name][0]) if name in arrays else 0 for name in ("seed", "training_images"))
    averages = averages_of(options.program, file, calibration + measured)
    fit_features(net, truth, averages[: len(calibration)], file)
    averages = averages[len(calibration) :]
    expected, made = estimates_of(net, features), byte_estimates(file, averages)
    angles = np.degrees(np.arccos(np.clip((expected[:, :3] * made[:, :3]).sum(1), -1, 1)))
    others = np.abs(expected[:, 3:] - made[:, 3:]).max(1)
    off = np.linalg.norm(byte_features(file, averages) - features, axis=1) / np.linalg.norm(features, axis=1)
    file.angle_deg, file.difference = quantile(angles, 0.5), quantile(others, 0.5)
    if options.keep_float:
        file.float_parameters = float_parameters(net)
    content = light_file_bytes(file)
    save(options.output, lambda path: open(path, "wb").write(content))
    print(f"{options.output}: {len(content)} bytes, calibrated on {seen.images} images; int8 against float on {len(measured)} others:")
    print(
        f"direction            median {file.angle_deg:.3f} deg, 90th percentile {quantile(angles, 0.9):.3f}, greatest "
        f"{angles.max():.3f} (limit of the median {ANGLE_LIMIT_DEG:g})"
    )
    print(
        f"colours, contrast    median {file.difference:.4f}, 90th percentile {quantile(others, 0.9):.4f}, greatest {others.max():.4f} "
        f"(limit of the median {DIFFERENCE_LIMIT:g})"
    )
    print(f"features             median of the relative error {quantile(off, 0.5):.4f}")
    return 0 if file.angle_deg <= ANGLE_LIMIT_DEG and file.difference <= DIFFERENCE_LIMIT else 1


if __name__ == "__main__":
    sys.exit(main())
