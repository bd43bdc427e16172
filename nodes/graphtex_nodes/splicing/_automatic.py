"""Choice of the elements that explain a texture best, where nobody has pointed at one."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context
from graphtex_nodes.splicing._detection import Detection, detect
from graphtex_nodes.splicing._proposals import LEAST_COUNT, Proposal, proposals
from graphtex_nodes.splicing._templates import Example

Array = NDArray[Any]

TRIED = 7  # proposals
OTHER = 0.25  # share of a proposal's parts that must be no elements yet, for it to be a second kind
GAIN = 1.1  # by which a second kind must explain more


def choose(image: Array, turn: float, growth: float, radius: float, ctx: Context) -> tuple[list[Example], float]:
    """Examples, one for each kind of element (at most two), and how sure they are, 0 to 1; none without elements."""

    def search(guesses: list[Proposal], trial: bool) -> tuple[float, Array]:
        examples = [guess.example for guess in guesses]
        found = detect(image, examples, turn=turn, growth=growth, radius=radius, floor=None, ctx=ctx, trial=trial)
        merit = min(guess.merit for guess in guesses)
        return merit * explained(found, examples, image.shape), found.poses.points

    guesses = proposals(image)[:TRIED]
    best: list[Proposal] = []
    score, points = 0.0, np.empty((0, 2))
    for guess in guesses:
        found, places = search([guess], True)
        if found > score:
            best, score, points = [guess], found, places
    if not best:
        return [], 0.0
    first = best[0]
    score, points = search(best, False)
    for guess in guesses:
        left = _left(guess, points)
        if guess is not first and len(left) >= OTHER * len(guess.likes):
            x, y = left[len(left) // 2]
            moved = replace(guess, example=guess.example.model_copy(update={"x": float(x), "y": float(y)}))
            found, _ = search([first, moved], False)
            if found > GAIN * score:
                best, score = [first, moved], found
    return [guess.example for guess in best], score


def explained(found: Detection, examples: list[Example], shape: tuple[int, ...]) -> float:
    """Mean correlation x root of the share of the picture in elements' boxes x regularity; 0 for too few."""
    poses = found.poses
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
