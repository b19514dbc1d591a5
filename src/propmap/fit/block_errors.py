"""Errors of parameters from residuals that are alike within stretches of the data."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.fit.search import NOISE_FLOOR
from propmap.typing import Floats

MOST_ALONE = 0.9
"""Share of what is known of a direction that one stretch is taken to tell, at most: what a single
stretch alone determines has no error that could be told from the others."""


class BlockErrors(NamedTuple):
    """What G stretches tell of P parameters.

    ``middle`` (P, P) is the covariance of the slopes of half the sum of squares; ``freedom`` (P,)
    the degrees of freedom of each parameter's variance.
    """

    middle: Floats
    freedom: Floats


def block_errors(
    slopes: Floats,
    residual: Floats,
    group: NDArray[np.intp],
    whole: Floats,
    by_priors: Floats,
) -> BlockErrors:
    """Cluster-robust errors, each stretch's residuals being those of a fit that left it out.

    Residuals of few stretches and many parameters are too small, most in the stretches that
    decide.  Left out by the linear model they are not (the jackknife, CR3 of Bell and McCaffrey,
    Survey Methodology 28, 2002, page 169); degrees of freedom are Satterthwaite's, by how evenly
    the stretches share in each parameter.

    Parameters
    ----------
    slopes, residual, group : ndarray, shape (M, P), (M,) and (M,)
        Of rows with weight.
    whole : ndarray, shape (P, P)
        Information of data and priors.
    by_priors : ndarray, shape (P, P)
        Covariance of what priors add to the slopes of half the sum of squares.
    """
    labels, index = np.unique(group, return_inverse=True)
    floor = np.where(np.abs(residual) < NOISE_FLOOR, NOISE_FLOOR * np.sign(residual), residual)
    values, vectors = np.linalg.eigh(whole)
    seen = values > 1e-12 * max(float(values[-1]), 1e-300)
    root = vectors[:, seen] * np.sqrt(values[seen])
    back = (vectors[:, seen] / np.sqrt(values[seen])).T
    middle, evenness = np.zeros_like(whole), np.zeros((labels.size, whole.shape[0]))
    for k in range(labels.size):
        mine = slopes[index == k]
        score = back @ (mine.T @ floor[index == k])
        share = back @ mine.T @ mine @ back.T
        alone, ways = np.linalg.eigh(share)
        apart = ways @ ((ways.T @ score) / (1.0 - np.minimum(alone, MOST_ALONE)))
        one = root @ apart
        middle += np.outer(one, one)
        evenness[k] = np.einsum("sp,st,tp->p", back, share, back)
    small = max(labels.size - 1, 1) / labels.size
    inverse = back.T @ back
    of_data = np.einsum("pq,qr,rp->p", inverse, small * middle, inverse)
    of_priors = np.einsum("pq,qr,rp->p", inverse, by_priors, inverse)
    squares = np.sum(evenness**2, axis=0)
    counted = np.sum(evenness, axis=0) ** 2 / np.where(squares > 0.0, squares, 1.0)
    counted = np.clip(counted, 1.0, max(labels.size - 1, 1))
    # The variance that priors bring is known.
    both = of_data + of_priors
    unknown = np.where(both > 0.0, of_data / np.where(both > 0.0, both, 1.0), 1.0)
    return BlockErrors(small * middle, counted / np.maximum(unknown, 1e-3) ** 2)
