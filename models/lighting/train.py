#!/usr/bin/env python3
"""Trains the lighting network on data sets made by `sandglass dataset`.

The network is DenseNet-121 with a layer of 512 (batch normalisation, ELU) and four heads: direction (tanh, normalised), light
colour and ambient colour (sigmoid), and contrast (sigmoid). The loss is (5.26) of the dissertation: mean squares with the weights
5, 2, 2 and 1.

Folds follow locations. A location of the test fold never trains. Rows of fold -1 are for training only. There are two ways:
  --layers last   For a CPU. Everything up to the third transition is computed once and kept on disk: for each image, its mirror
                  image, and a few augmented copies. The last layers of the last dense block (--learn) and the heads learn.
  --layers all    For a GPU. Every layer learns. Every epoch augments every image anew.
The statistics of the DenseNet's batch normalisations stay as they are. Their factors learn. The result is the mean of the weights
over the last quarter of the epochs.

Every epoch ends with a checkpoint. --resume goes on from the last one and gives the same result as a run without a break. Images
are 256 x 192 sRGB. Directions are in the camera's frame (x right, y down).

Heads that are ridge regressions need only features. --features takes those of the runtime, in bytes (`sandglass light-features`),
so that the heads allow for the rounding. The training folds choose the strength of the ridges. With --or-features they also
choose between sets of features. The training folds estimate one another, and the set with the best direction wins.

ImageNet's features do not tell how bright each part of an image is. But that tells most about where light comes from. --lanes
keeps it. At each of the four widths, the LANES channels that are used least carry brightness above thresholds past the layers.
The last LAYOUT_LAYERS layers shift it. So averages over all pixels are also averages over parts. All other channels stay as they
are. The training folds choose how far those are trusted.

--export FILE writes the weights in float (light_network.py), data_hash (16 hexadecimal digits of the manifests' SHA-256), seed
and training_images.
"""
import argparse
import json
import math
import os
import sys

import numpy as np
import torch
import torch.nn.functional as F

sys.dont_write_bytecode = True
from light_data import (GROUPS, LABELS, Rows, cached_trunks, fail, label_of, prepared, read_features, save, save_arrays, to_tensor)
from light_network import LAYERS, LightNet
from light_ridge import TRUSTS, USUAL_RIDGES, angles_deg, best_ridges, ridge_errors

LOSS_WEIGHTS = {"direction": 5.0, "light": 2.0, "ambient": 2.0, "contrast": 1.0}  # (5.26)
EXTRA_WEIGHT = 0.5  # weight of made-up rooms; captured ones together have 1


def packed(inputs):
    """Puts pixels into the memory order that convolutions prefer. Features stay as they are."""
    return inputs.contiguous(memory_format=torch.channels_last) if inputs.dim() == 4 else inputs


def loss_of(estimate, labels):
    truth = {"direction": labels[:, :3], "light": labels[:, 3:6], "ambient": labels[:, 6:9], "contrast": labels[:, 9:]}
    return sum(w * F.mse_loss(estimate[k], truth[k]) for k, w in LOSS_WEIGHTS.items())


def measures(estimate, truth):
    angle = angles_deg(estimate[:, :3], truth[:, :3])
    return {"angle_mean": float(angle.mean()), "angle_median": float(np.median(angle)),
            "angle_p90": float(np.percentile(angle, 90)), "light": float(np.abs(estimate[:, 3:6] - truth[:, 3:6]).mean()),
            "ambient": float(np.abs(estimate[:, 6:9] - truth[:, 6:9]).mean()),
            "contrast": float(np.abs(estimate[:, 9] - truth[:, 9]).mean())}


def start_rows(arguments, rows, train_rows, net, trunk_of, device):
    """Returns what the heads start from: features and labels of all copies of the training images, their weights, and the
    errors of the ridges within these folds. Captured images together have the weight 1, others EXTRA_WEIGHT."""
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
    """Starts the heads from the source of features whose direction is best within the training folds. Returns the number of
    that source, its ridges and trusts, and the least errors of every source."""
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
    """The (row, copy) pairs of one epoch, in batches."""
    random = np.random.default_rng([arguments.seed, epoch])  # by epoch, so that a resumed run draws the same as an unbroken one
    extra = rows.kind[train_rows] == 2
    order = random.permutation(np.concatenate([random.permutation(train_rows[extra]), train_rows[~extra]]))
    first, beyond = (0, arguments.copies) if arguments.layers == "last" else (2, 1 << 20)
    pairs = list(zip(order, random.integers(first, beyond, len(order))))
    batches = [pairs[at:at + arguments.batch] for at in range(0, len(pairs), arguments.batch)]
    return [b for b in batches if len(b) >= 2]  # batch normalisation needs two


def train(arguments):
    torch.set_num_threads(arguments.threads)
    device = torch.device("cuda" if torch.cuda.is_available() and not arguments.cpu else "cpu")
    rows = Rows(arguments.dataset, arguments.views, arguments.train_only)
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
    save_arrays(arguments.export, **net.exported(), seed=np.array([arguments.seed], np.float32))


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
    halving = torch.optim.lr_scheduler.StepLR(optimiser, max(1, arguments.epochs // 4), 0.5)  # the dissertation: every 15 of 60 epochs
    name = "all" if fold is None else f"fold_{fold}"
    checkpoint = os.path.join(arguments.output, name + ".checkpoint")
    log, first, sums = [], 0, None
    if arguments.resume and os.path.exists(checkpoint):
        try:
            state = torch.load(checkpoint, map_location=device)
            net.load_state_dict(state["net"]), optimiser.load_state_dict(state["optimiser"])
            halving.load_state_dict(state["halving"])
            log, first, sums = state["log"], state["epoch"], state["sums"]
        except Exception:  # torch.load may raise anything on damaged bytes
            fail(f"the checkpoint '{checkpoint}' is damaged or of another training; remove it to begin anew")

    def inputs_of(items, epoch):
        """The inputs and labels of (row, copy) pairs, as tensors."""
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
        net.train_with_frozen_statistics()
        total, images = 0.0, 0
        batches = batches_of(rows, train_rows, epoch, arguments)
        if not batches:
            fail("an epoch shows fewer than two images; name more data sets")
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
        save_arrays(arguments.export, **net.exported(), data_hash=np.frombuffer(rows.hash().encode(), np.uint8),
                    seed=np.array([arguments.seed], np.float32), training_images=np.array([len(train_rows)], np.float32))


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"train.py: {message}; see train.py --help\n")


def number(kind, low, high=math.inf, above=False):
    """The type of an option: a number from `low` to `high`. With `above`, it is greater than `low`."""
    def read(text):
        value = kind(text)
        if not (low < value if above else low <= value) or not value <= high or not math.isfinite(value):
            bound = f"above {low}" if above else f"from {low}"
            raise argparse.ArgumentTypeError(f"'{text}' is not a number {bound}" + ("" if high == math.inf else f" to {high}"))
        return value
    read.__name__ = "number"
    return read


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("dataset", nargs="*", help="folders made by `sandglass dataset`")
    parser.add_argument("--views", nargs="*", default=[], help="folders with more views of the same places, to train on")
    parser.add_argument("--train-only", nargs="*", default=[], help="further folders that never test (made-up rooms)")
    parser.add_argument("--weights", help="densenet121_imagenet_keras_fp32.npz or an exported file; without it, random")
    parser.add_argument("-o", "--output", default=".", help="folder for checkpoints, results and cached trunks")
    parser.add_argument("--cache", help="another folder for the cached trunks")
    parser.add_argument("--export", metavar="FILE", help="write the trained weights as .npz")
    parser.add_argument("--features", nargs="*", default=[], metavar="FILE",
                        help="of each folder, in their order, by `sandglass light-features`: only the heads are fitted")
    parser.add_argument("--or-features", nargs="+", action="append", default=[], metavar="FILE",
                        help="another such set, of another trunk: for each test fold the other folds choose; may be repeated")
    parser.add_argument("--initial", action="store_true", help="only write the weights that training starts from")
    parser.add_argument("--lanes", action="store_true", help="with --initial: channels that carry brightness past the pretrained layers")
    parser.add_argument("--test-fold", type=number(int, 0), nargs="+", default=[1], help="one run for each")
    parser.add_argument("--all", action="store_true", help="train on every fold and test on none: for the shipped weights")
    parser.add_argument("--layers", choices=("last", "all"), default="last")
    parser.add_argument("--learn", type=int, choices=range(17), default=6, metavar="N",
                        help="how many of the last block's 16 layers learn with --layers last")
    parser.add_argument("--copies", type=number(int, 1), default=4, help="cached copies of an image, its mirror image among them")
    parser.add_argument("--epochs", type=number(int, 0), default=24, help="0 only tests the weights")
    parser.add_argument("--batch", type=number(int, 2), default=64)
    parser.add_argument("--rate", type=number(float, 0.0, above=True), default=1e-3, help="of the heads")
    parser.add_argument("--extractor-rate", type=number(float, 0.0), default=0.3, help="of the DenseNet's layers, over that of the heads")
    parser.add_argument("--decay", type=number(float, 0.0), default=1e-2, help="of the weights, decoupled")
    parser.add_argument("--dropout", type=number(float, 0.0, 0.99), default=0.3)
    parser.add_argument("--seed", type=number(int, 0, 2**32 - 1), default=1)
    parser.add_argument("--threads", type=number(int, 1, 256), default=1)
    parser.add_argument("--cpu", action="store_true", help="even where there is a GPU")
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
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
    if not arguments.dataset and not (arguments.all and arguments.train_only):
        fail("no data set is named; make one with `sandglass dataset`")
    try:
        os.makedirs(arguments.output, exist_ok=True)
    except OSError:
        fail(f"the folder '{arguments.output}' cannot be made; name another with -o")
    train(arguments)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as error:
        fail(f"{error}; check the path, its permissions and the space left")
    except KeyboardInterrupt:
        sys.exit(130)
