"""Weighted ridge regressions of the labels on features. The heads of the lighting network start from them. With few places, they
also end as them."""

import numpy as np

from light_data import GROUPS

TRUSTS = (0.03, 0.1, 0.3, 1.0)  # to choose from: the trust in other features, where a lane's has 1
RIDGES = tuple(10.0 ** (k / 2) for k in range(-6, 5))  # to choose from, for standardised features
USUAL_RIDGES = (2.0, 4.0, 0.1, 2.0)  # for the groups of labels, if there are not two folds to choose by
LEAST_DEVIATION = 0.25


def angles_deg(a, b):
    return np.degrees(np.arccos(np.clip((a * b).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1), -1, 1)))


class Regression:
    """Weighted ridge regressions in float64. All ridges together cost as much as one."""

    def __init__(self, features, labels, weights, trust=1.0):
        targets = labels.copy()
        targets[:, :3] *= 0.5  # there tanh is almost the identity, and the length does not matter
        targets[:, 3:] = np.log(targets[:, 3:].clip(0.02, 0.98) / (1 - targets[:, 3:].clip(0.02, 0.98)))
        weights = (weights / weights.sum())[:, None]
        self.mean, self.answer = (weights * features).sum(0), (weights * targets).sum(0)
        centred = features - self.mean
        deviation = np.sqrt((weights * centred**2).sum(0))
        self.deviation = np.maximum(deviation, LEAST_DEVIATION * np.median(deviation)) / trust  # bytes lose what hardly varies
        centred = centred / self.deviation
        self.values, self.vectors = np.linalg.eigh((weights * centred).T @ centred)
        self.products = self.vectors.T @ ((weights * centred).T @ (targets - self.answer))

    def slopes(self, ridges):
        """The slopes for the features as they are, by columns. Each group of labels has its own ridge."""
        each = np.concatenate([np.full(g.stop - g.start, r) for g, r in zip(GROUPS, ridges)])
        return self.vectors @ (self.products / (self.values.clip(0)[:, None] + each)) / self.deviation[:, None]

    def errors(self, ridges, features, labels):
        """The errors by group of labels: the mean angle first, then mean absolute differences."""
        out = self.answer + (features - self.mean) @ self.slopes(ridges)
        out = np.concatenate([np.tanh(out[:, :3]), 1 / (1 + np.exp(-out[:, 3:]))], 1)
        return [angles_deg(out[:, :3], labels[:, :3]).mean()] + [np.abs(out[:, g] - labels[:, g]).mean() for g in GROUPS[1:]]


def ridge_errors(features, labels, weights, folds, judged, trust=1.0):
    """The mean errors of the `judged` rows, by ridge and group. Each fold is estimated from the others. None if there is one fold."""
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
    return tuple(RIDGES[k] for k in errors.argmin(0))
