"""Choice of the elements that explain a texture best, where nobody has pointed at one."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.splicing._detection import Detection, Search, thinned
from graphtex_nodes.splicing._peaks import score_floor
from graphtex_nodes.splicing._poses import Poses
from graphtex_nodes.splicing._proposals import LEAST_COUNT, Proposal, proposals
from graphtex_nodes.splicing._templates import Example

Array = NDArray[Any]

TRIED = 7  # proposals
OTHER = 0.25  # share of a proposal's parts that must be no elements yet, for it to be a second kind
GAIN = 1.1  # by which a second kind must explain more


@dataclass(frozen=True)
class Choice:
    """Examples, one for each kind of element (at most two), what looks like them, and how sure this is, 0 to 1."""

    examples: list[Example]
    found: Detection
    confidence: float


def choose(image: Array, search: Search) -> Choice | None:
    """The examples that explain a picture best; None without elements.

    Guesses are compared by quick trials; the winner is searched with care, and so is the best pair if it wins.
    """
    guesses = proposals(image)[:TRIED]
    trials = [search.tried(guess.example) for guess in guesses]
    merits = [_merit([guess], [trial], search, image.shape) for guess, trial in zip(guesses, trials, strict=True)]
    if not merits or max(merits) <= 0:
        return None
    first = int(np.argmax(merits))
    one = _chosen([guesses[first]], search, image.shape)
    pair, best = None, GAIN * one.confidence
    points = _kept(one.found.poses).points
    for index, guess in enumerate(guesses):
        left = _left(guess, points)
        if index == first or len(left) < OTHER * len(guess.likes):
            continue
        x, y = left[len(left) // 2]
        moved = replace(guess, example=guess.example.model_copy(update={"x": float(x), "y": float(y)}))
        both = [guesses[first], moved]
        merit = _merit(both, [one.found.poses, search.tried(moved.example)], search, image.shape)
        if merit > best:
            pair, best = both, merit
    return one if pair is None else _chosen(pair, search, image.shape)


def _chosen(guesses: list[Proposal], search: Search, shape: tuple[int, ...]) -> Choice:
    """Proposals together, searched with care."""
    examples = [guess.example for guess in guesses]
    found = search.detect(examples)
    return Choice(examples, found, min(g.merit for g in guesses) * explained(_kept(found.poses), examples, shape))


def _merit(guesses: list[Proposal], trials: list[Poses], search: Search, shape: tuple[int, ...]) -> float:
    """How much proposals explain together, by their trials."""
    examples = [guess.example for guess in guesses]
    both = Poses.joined([replace(poses, kinds=poses.kinds + kind) for kind, poses in enumerate(trials)])
    return min(guess.merit for guess in guesses) * explained(
        _kept(thinned(both, examples, search.radius)), examples, shape
    )


def _kept(poses: Poses) -> Poses:
    return poses.take(poses.scores >= score_floor(poses.scores))


def explained(poses: Poses, examples: list[Example], shape: tuple[int, ...]) -> float:
    """Mean correlation x root of the share of the picture in elements' boxes x regularity; 0 for too few."""
    if len(poses.points) < LEAST_COUNT:
        return 0.0
    covered = np.zeros(shape[:2], bool)
    for (x, y), scale, kind in zip(poses.points, poses.scales, poses.kinds, strict=True):
        across, down = examples[kind].width * scale / 2, examples[kind].height * scale / 2
        top, left = max(0, round(y - down)), max(0, round(x - across))
        covered[top : max(0, round(y + down)), left : max(0, round(x + across))] = True
    return float(poses.scores.mean() * np.sqrt(covered.mean()) * regularity(poses.points))


def regularity(points: Array) -> float:
    """1 where all points are equally far from their nearest neighbour, less the more these distances vary."""
    from scipy.spatial import cKDTree

    nearest = np.asarray(cKDTree(points).query(points, 2)[0])[:, 1]
    return float(1 / (1 + nearest.std() / max(nearest.mean(), 1e-9)))


def _left(guess: Proposal, points: Array) -> Array:
    """The parts of a proposal that are none of the elements found."""
    from scipy.spatial import cKDTree

    apart = np.asarray(cKDTree(points).query(guess.likes)[0])
    left: Array = guess.likes[apart > min(guess.example.width, guess.example.height) / 2]
    return left
