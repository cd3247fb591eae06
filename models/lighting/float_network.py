#!/usr/bin/env python3
"""Rebuilds the float network from which models/lights/room.light was made. Computes its estimates for the excerpts.

The trunk is the pretrained DenseNet-121 with lanes (train.py --initial --lanes). The heads are in excerpts/heads.npz: 160 of the
512 latent units carry the ten ridge regressions, with 16 equal copies of each. The other units have no effect. PyTorch 1.13 drew
them from seed 1. Every array equals, bit for bit, the one from which the shipped bytes were made (MODEL_CARD.md).

  float_network.py weights PRETRAINED.npz WEIGHTS.npz
      Puts trunk and heads together, as train.py exports a network. PRETRAINED is densenet121_imagenet_keras_fp32.npz.
  float_network.py estimates WEIGHTS.npz PIXELS OUT.csv
      Writes PyTorch's estimates of the excerpts. PIXELS has the bytes of all excerpts by name, as the tests' reader decodes them,
      because decoders of JPEG differ.
"""

import argparse
import csv
import glob
import hashlib
import os
import sys

import numpy as np
import torch

sys.dont_write_bytecode = True
import light_data
import light_network
from light_file import fnv1a

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "excerpts")
SEED = 1
WEIGHTS_SHA256 = "496f06301a07febe357dd257197fb2ed295310c3436892c41bee7b68de1be123"  # of every array, by name
EXIT_OTHER_PYTORCH = 77


def sha256_of(arrays):
    digest = hashlib.sha256()
    for name in sorted(arrays):
        digest.update(name.encode() + np.ascontiguousarray(arrays[name]).tobytes())
    return digest.hexdigest()


def write_weights(pretrained, path):
    torch.manual_seed(SEED)
    network = light_network.LightNet()
    network.load(pretrained)
    network.give_lanes()
    arrays = network.exported()  # as train.py --initial --lanes --seed 1 has it
    heads = np.load(os.path.join(FOLDER, "heads.npz"))
    copies, j = light_network.COPIES_OF_START, 0
    used = 10 * copies
    arrays["latent/kernel"][:, :used] = np.repeat(heads["slopes"], copies, 1)
    arrays["latent/bias"][:] = 0
    arrays["latent/bn/beta"][:used] = light_network.SHIFT_OF_START
    for name in ("moving_mean", "moving_variance"):
        arrays["latent/bn/" + name] = heads[name]
    for name in ("direction", "light", "ambient", "contrast"):
        kernel, bias = arrays[name + "/kernel"], arrays[name + "/bias"]
        kernel[:] = 0
        for o in range(len(bias)):
            kernel[copies * j : copies * (j + 1), o], bias[o] = heads["spread"][j], heads["bias"][j]
            j += 1
    for name in ("data_hash", "seed", "training_images"):
        arrays[name] = heads[name]
    if sha256_of(arrays) != WEIGHTS_SHA256:
        print(f"PyTorch {torch.__version__} draws other numbers from seed {SEED}, or sums otherwise, than the one that made the network")
        sys.exit(EXIT_OTHER_PYTORCH)
    np.savez(path, **arrays)


def write_estimates(weights, pixels, path):
    names = sorted(os.path.basename(name) for name in glob.glob(FOLDER + "/*.jpg"))
    images = np.fromfile(pixels, np.uint8).reshape(len(names), light_data.HEIGHT, light_data.WIDTH, 3)
    network = light_network.LightNet()
    if not network.load(weights):
        sys.exit(f"'{weights}' has no heads; make it with `float_network.py weights`")
    network.eval()
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["image", "fnv1a"] + list(light_data.LABELS))
        for name, image in zip(names, images):
            with torch.no_grad():
                values = network.estimate(network.features(light_data.to_tensor([image])))[0].tolist()
            out.writerow([name, f"{fnv1a(image.tobytes()):016x}"] + [f"{x:.7f}" for x in values])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    steps = parser.add_subparsers(dest="step", required=True)
    weights = steps.add_parser("weights")
    for name in ("pretrained", "weights"):
        weights.add_argument(name)
    estimates = steps.add_parser("estimates")
    for name in ("weights", "pixels", "output"):
        estimates.add_argument(name)
    options = parser.parse_args()
    if options.step == "weights":
        write_weights(options.pretrained, options.weights)
    else:
        write_estimates(options.weights, options.pixels, options.output)


if __name__ == "__main__":
    main()
