#!/usr/bin/env python3
"""Fits the lighting network's heads to data sets made by `sandglass dataset`.

The network is DenseNet-121 with a layer of 512 (batch normalisation, ELU) and four heads: direction (tanh, normalised), light
colour and ambient colour (sigmoid), and contrast (sigmoid). The DenseNet's weights stay as --initial writes them.

Folds follow locations. A location of the test fold never trains. Rows of fold -1 are for training only.

The heads are ridge regressions. --features takes the features of the runtime, in bytes (`sandglass light-features --mirror`), so
that the heads allow for the rounding. The training folds choose the strength of the ridges. With --or-features they also choose
between sets of features. The training folds estimate one another, and the set with the best direction wins.

ImageNet's features do not tell how bright each part of an image is. But that tells most about where light comes from. --lanes
keeps it. At each of the four widths, the LANES channels that are used least carry brightness above thresholds past the layers.
The last LAYOUT_LAYERS layers shift it. So averages over all pixels are also averages over parts. All other channels stay as they
are. The training folds choose how far those are trusted.

--export FILE writes the weights in float (light_network.py), data_hash (16 hexadecimal digits of the manifests' SHA-256), seed
and training_images.
"""

import argparse
import json
import os
import sys

import numpy as np
import torch

sys.dont_write_bytecode = True
from light_data import COPIES, GROUPS, LABELS, Rows, fail, label_of, read_features, save, save_arrays
from light_network import LightNet
from light_ridge import TRUSTS, USUAL_RIDGES, angles_deg, best_ridges, ridge_errors

EXTRA_WEIGHT = 0.5  # weight of made-up rooms; captured ones together have 1


def measures(estimate, truth):
    angle = angles_deg(estimate[:, :3], truth[:, :3])
    return {
        "angle_mean": float(angle.mean()),
        "angle_median": float(np.median(angle)),
        "angle_p90": float(np.percentile(angle, 90)),
        "light": float(np.abs(estimate[:, 3:6] - truth[:, 3:6]).mean()),
        "ambient": float(np.abs(estimate[:, 6:9] - truth[:, 6:9]).mean()),
        "contrast": float(np.abs(estimate[:, 9] - truth[:, 9]).mean()),
    }


def fitted_rows(rows, train_rows, net, features_of):
    """Returns what the heads are fitted to: features and labels of the training images and their mirror images, their weights, and
    the errors of the ridges within these folds. Captured images together have the weight 1, others EXTRA_WEIGHT."""
    pairs = [(i, c) for c in range(COPIES) for i in train_rows]
    features, labels = (
        np.stack([of(i, c) for i, c in pairs]).astype(np.float64) for of in (features_of, lambda i, c: label_of(rows, i, c))
    )
    extra = rows.kind[[i for i, _ in pairs]] == 2
    weights = np.where(extra, EXTRA_WEIGHT / max(1, extra.sum()), 1.0 / max(1, (~extra).sum()))
    folds = np.array([rows.fold[i] for i, _ in pairs])
    judged = (folds >= 0) & (extra if extra.all() else ~extra)
    errors = [ridge_errors(features, labels, weights, folds, judged, trust) for trust in net.trusts()]
    return features, labels, weights, None if errors[0] is None else np.stack(errors)


def fit_heads(rows, train_rows, net, sources):
    """Fits the heads to the source of features whose direction is best within the training folds. Returns the number of that
    source, its ridges and trusts, and the least errors of every source."""
    fits = [fitted_rows(rows, train_rows, net, source) for source in sources]
    if len(sources) > 1 and fits[0][-1] is None:
        fail("--or-features chooses by the folds that train, and there are fewer than two; name more places")
    least = [errors.min((0, 1)).tolist() for *_, errors in fits if errors is not None]
    chosen = min(range(len(least)), key=lambda k: least[k][0], default=0)
    features, labels, weights, errors = fits[chosen]
    if errors is None:
        trusts, ridges = (len(net.trusts()) - 1,) * len(GROUPS), USUAL_RIDGES
    else:
        trusts = tuple(errors.min(1).argmin(0).tolist())
        ridges = tuple(best_ridges(errors[k])[group] for group, k in enumerate(trusts))
    net.give_heads(features, labels, weights, ridges, trusts)
    return {"features": chosen, "ridges": ridges, "inner": least, **({} if net.lanes is None else {"trusts": [TRUSTS[k] for k in trusts]})}


def initial(arguments):
    torch.manual_seed(arguments.seed)
    net = LightNet().eval()
    if arguments.weights:
        net.load(arguments.weights)
    return net


def write_initial(arguments):
    net = initial(arguments)
    if arguments.lanes:
        net.give_lanes()
    save_arrays(arguments.export, **net.exported(), seed=np.array([arguments.seed], np.float32))


def fit(arguments):
    rows = Rows(arguments.dataset, arguments.views, arguments.train_only)
    folds = [None] if arguments.all else arguments.test_fold
    for fold in folds:
        trained, tested = (len(part) for part in rows.split(fold))
        if trained == 0 or (tested == 0 and fold is not None):
            fail(f"fold {fold} leaves {trained} images to train on and {tested} to test on; choose another fold")
    net = initial(arguments)
    sources = [read_features(net, rows, paths) for paths in [arguments.features] + arguments.or_features]
    for fold in folds:
        fit_fold(arguments, fold, rows, net, sources)


def fit_fold(arguments, fold, rows, net, sources):
    train_rows, test_rows = rows.split(fold)
    captured = train_rows[rows.kind[train_rows] < 2]
    mean_light = rows.labels[captured if len(captured) else train_rows].mean(0)
    found = fit_heads(rows, train_rows, net, sources)
    name = "all" if fold is None else f"fold_{fold}"
    result = {
        "fold": name,
        "train_images": len(train_rows),
        "test_images": len(test_rows),
        "test_locations": len({rows.location[i] for i in test_rows}),
        **found,
        "arguments": vars(arguments),
    }
    if len(test_rows):
        with torch.no_grad():
            made = net.estimate(torch.from_numpy(np.stack([sources[found["features"]](i, 0) for i in test_rows]))).numpy()
        truth = rows.labels[test_rows]
        mean = mean_light[None].repeat(len(test_rows), 0)
        result.update(network=measures(made, truth), mean_training_light=measures(mean, truth))
        lines = ["image," + ",".join(LABELS)] + [
            os.path.basename(rows.image[i]) + "".join(f",{x:.6f}" for x in made[at]) for at, i in enumerate(test_rows)
        ]
        save(os.path.join(arguments.output, name + "_estimates.csv"), lambda path: open(path, "w").write("\n".join(lines) + "\n"))
        for k in ("network", "mean_training_light"):
            print(k, json.dumps(result[k]), flush=True)
    save(os.path.join(arguments.output, name + ".json"), lambda path: open(path, "w").write(json.dumps(result, indent=1)))
    if arguments.export:
        save_arrays(
            arguments.export,
            **net.exported(),
            data_hash=np.frombuffer(rows.hash().encode(), np.uint8),
            seed=np.array([arguments.seed], np.float32),
            training_images=np.array([len(train_rows)], np.float32),
        )


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"train.py: {message}; see train.py --help\n")


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("dataset", nargs="*", help="folders made by `sandglass dataset`")
    parser.add_argument("--views", nargs="*", default=[], help="folders with more views of the same places, to train on")
    parser.add_argument("--train-only", nargs="*", default=[], help="further folders that never test (made-up rooms)")
    parser.add_argument("--weights", help="densenet121_imagenet_keras_fp32.npz or an exported file; without it, random")
    parser.add_argument("-o", "--output", default=".", help="folder for results")
    parser.add_argument("--export", metavar="FILE", help="write the weights as .npz")
    parser.add_argument(
        "--features", nargs="*", default=[], metavar="FILE", help="of each folder, in their order, by `sandglass light-features --mirror`"
    )
    parser.add_argument(
        "--or-features",
        nargs="+",
        action="append",
        default=[],
        metavar="FILE",
        help="another such set, of another trunk: for each test fold the other folds choose; may be repeated",
    )
    parser.add_argument("--initial", action="store_true", help="only write the weights of the trunk")
    parser.add_argument("--lanes", action="store_true", help="with --initial: channels that carry brightness past the pretrained layers")
    parser.add_argument("--test-fold", type=int, nargs="+", default=[1], help="one run for each")
    parser.add_argument("--all", action="store_true", help="train on every fold and test on none: for the shipped weights")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    if arguments.lanes and not (arguments.initial and arguments.weights):
        fail("--lanes changes weights as they begin; name them with --weights, beside --initial")
    if arguments.initial:
        if not arguments.export:
            fail("--initial writes weights; name the file with --export")
        write_initial(arguments)
        return 0
    if not arguments.features:
        fail("the heads are fitted to features; make them with `sandglass light-features --mirror` and name them with --features")
    if arguments.or_features and arguments.export:
        fail("--or-features only tests a choice; leave out --export, or name what was chosen with --features")
    if not arguments.dataset and not (arguments.all and arguments.train_only):
        fail("no data set is named; make one with `sandglass dataset`")
    try:
        os.makedirs(arguments.output, exist_ok=True)
    except OSError:
        fail(f"the folder '{arguments.output}' cannot be made; name another with -o")
    fit(arguments)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as error:
        fail(f"{error}; check the path, its permissions and the space left")
    except KeyboardInterrupt:
        sys.exit(130)
