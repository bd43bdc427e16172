"""Choice of the elements that explain a texture best, where nobody has pointed at one."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Elements
from graphtex_nodes.splicing._detection import Detection, Search
from graphtex_nodes.splicing._doubts import DOUBTFUL, SHOWN_ALONE, hardly_shown, trust
from graphtex_nodes.splicing._lone import few_parts
from graphtex_nodes.splicing._nearness import common_offset
from graphtex_nodes.splicing._packed import outline_fit, touching
from graphtex_nodes.splicing._partitions import (
    LARGEST_SHARE,
    LEAST_COUNT,
    SIDE,
    Even,
    Parts,
    even_and_small,
    partitions,
)
from graphtex_nodes.splicing._pattern import regularity
from graphtex_nodes.splicing._peaks import score_floor
from graphtex_nodes.splicing._poses import Poses
from graphtex_nodes.splicing._proposals import Proposal, enlarged, from_parts, from_repeats, proposals
from graphtex_nodes.splicing._templates import Example, OneColourError, mean_size

Array = NDArray[Any]

FINE = 6  # pixels of the picture between those of a reduced one that is fine enough
TRIED = 7  # proposals
OTHER = 0.25  # share of the parts that must have been missed for them to be a second kind
GAIN = 1.1  # by which a second kind must explain more
VARIED = 0.2  # deviation of logarithms of areas from which parts are not all alike
SPECK = 0.1  # of the typical area: smaller parts are no elements
ASTRAY = 0.25  # share of elements that may lie off the parts: on a plain ground likenesses of elements are found
CUT_OFF = 0.5  # of it: smaller parts at the border are not counted, their centres are too uncertain
PACKED, LEAST_MERIT = 0.5, 0.25  # share of the picture in parts between joints, and merit, where all may be elements
SAME_BOX = 0.7  # overlap (IoU) of an example with its part
MANY = 0.5  # share of the parts that one example does not look like


@dataclass(frozen=True)
class Choice:
    """Examples, one for each kind of element (at most two), what was found, and how sure this is, 0 to 1.

    Elements are those found with a score of at least `floor`.
    """

    examples: list[Example]
    found: Detection
    floor: float
    confidence: float

    @property
    def points(self) -> Array:
        """Where the elements are, (n, 2)."""
        points: Array = _likely(self.found.poses, self.floor).points
        return points


def choose(image: Array, search: Search) -> Choice | None:
    """The elements that explain a picture best; None without any.

    Either all that looks like an example, or parts of the picture that stand apart, however unlike they are. Parts are
    taken if they look more like elements than the others explain, and the others miss some of them or all have one
    size where the parts have not. They have no angles.

    The picture is divided at a low resolution first. Where that leaves doubts, and elements may have been too small to
    be made out, it is done again at twice that.
    """
    coarse = even = even_and_small(image)
    side, best = SIDE, None
    while best is None or best.confidence < DOUBTFUL:
        search.ctx.check()
        choice = _judged(even, search)
        if choice is not None and (best is None or choice.confidence > best.confidence):
            best = choice
        if max(image.shape[:2]) <= FINE * side:
            break
        side *= 2
        even = even_and_small(image, side)
    if best is None or best.confidence < DOUBTFUL:
        few = _few(coarse, search)
        best = few if best is None or (few is not None and few.confidence > best.confidence) else best
    return best


def _few(even: Even, search: Search) -> Choice | None:
    """One to three elements that are nearly all there is to see."""
    for parts in few_parts(even):
        choice = _of_parts(parts, search)
        poses, (width, height) = choice.found.poses, mean_size(choice.examples)
        elements = Elements(poses.points / even.step, poses.angles, poses.scales)
        if hardly_shown(even.picture, elements, width / even.step, height / even.step, SHOWN_ALONE) is None:
            return choice
    return None


def _judged(even: Even, search: Search) -> Choice | None:
    """What is chosen at one resolution; where that is doubtful, and the picture repeats itself, perhaps its cells."""
    choice = _trusted(_chosen(even, search), even)
    if choice is not None and choice.confidence >= DOUBTFUL:
        return choice
    guess = from_repeats(even)
    if guess is None:
        return choice
    try:
        cells = _trusted(_searched([guess.example], guess.merit, search, even.size), even)
    except OneColourError:
        return choice
    return max((each for each in (choice, cells) if each is not None), key=lambda each: each.confidence)


def _trusted(choice: Choice | None, even: Even) -> Choice | None:
    """A choice with a confidence that takes doubts into account."""
    if choice is None:
        return None
    kept = _likely(choice.found.poses, choice.floor)
    width, height = mean_size(choice.examples)
    elements = Elements(kept.points / even.step, kept.angles, kept.scales)
    share = trust(even, elements, kept.scores, width / even.step, height / even.step)
    return replace(choice, confidence=share * choice.confidence)


def _chosen(even: Even, search: Search) -> Choice | None:
    """The better of what looks alike and of parts that stand apart."""
    divided = partitions(even)
    alike = _alike(even, divided, search)
    alike = None if alike is None else _centred(alike, even)
    if not divided:
        return alike
    parts = divided[0]
    if alike is None:
        return _of_parts(parts, search)
    same = not _missed(alike, parts).any() and _astray(alike, parts) <= ASTRAY
    if same and (search.growth > 1 or len(alike.examples) > 1 or parts.spread <= VARIED):
        return replace(alike, confidence=max(alike.confidence, parts.merit))
    return alike if alike.confidence >= parts.merit else _of_parts(parts, search)


def _centred(choice: Choice, even: Even) -> Choice:
    """The same with its elements' outlines where colours change most; pairs stay as they are."""
    if len(choice.examples) > 1:
        return choice
    step = even.step
    example, poses = choice.examples[0], choice.found.poses
    kept = _likely(poses, choice.floor)
    elements = Elements(kept.points / step, kept.angles, kept.scales)
    width, height = example.width / step, example.height / step
    if touching(elements, width, height):
        offset, width, height = outline_fit(even.picture, elements, width, height)
    else:
        offset = common_offset(even.picture, elements, width, height)
    last = np.array(even.size[::-1]) - 1
    x, y = np.clip(np.array([example.x, example.y]) + offset * step, 0, last)
    outlined = Example(x=float(x), y=float(y), width=max(3.0, width * step), height=max(3.0, height * step))
    moved = replace(choice.found, poses=replace(poses, points=poses.points + offset * step))
    return replace(choice, examples=[outlined], found=moved)


def as_parts(even: Even, search: Search, examples: list[Example], found: Detection) -> Choice | None:
    """All parts that joints leave of a picture, where the examples are such parts; None where they are not.

    Bricks and stones differ too much for one to look like the others. Where many of the parts were `found` because
    they look like the examples, only those are meant.
    """
    divided = [parts for parts in partitions(even) if all(_marked(parts, each) >= 0 for each in examples)]
    parts = max(divided, key=lambda parts: parts.merit, default=None)
    if parts is None or parts.merit < LEAST_MERIT or np.count_nonzero(parts.labels) < PACKED * parts.labels.size:
        return None
    alike = Choice(examples, found, score_floor(found.poses.scores), 0.0)
    if np.count_nonzero(_missed(alike, parts)) < MANY * np.count_nonzero(parts.fits):
        return None
    return replace(_of_parts(parts, search, _marked(parts, examples[0])), examples=examples)


def _marked(parts: Parts, example: Example) -> int:
    """Index of the part that lies in an example's box and fills it; -1 without."""
    row, column = (
        min(round(place / parts.step), side - 1)
        for place, side in zip((example.y, example.x), parts.labels.shape, strict=True)
    )
    index = int(parts.labels[row, column]) - 1
    if index < 0:
        return -1
    top, bottom, left, right = parts.boxes[index]
    box = np.array([left, top, right, bottom]) - 0.5 + parts.rim / 2 * np.array([-1, -1, 1, 1])
    half = np.array([example.width, example.height]) / 2
    middle = np.array([example.x, example.y])
    wanted = np.concatenate([middle - half, middle + half]) / parts.step
    common = np.prod(np.maximum(np.minimum(box, wanted)[2:] - np.maximum(box, wanted)[:2], 0))
    areas = np.prod(box[2:] - box[:2]) + np.prod(wanted[2:] - wanted[:2])
    return index if common >= SAME_BOX * (areas - common) else -1


def _of_parts(parts: Parts, search: Search, typical: int | None = None) -> Choice:
    """All parts of a partition that may be elements; the scale of each is the root of its area over the typical one.

    That is the one in the middle of the covered area, if it is not given.
    """
    fits = np.flatnonzero(parts.fits)
    by_size = fits[np.argsort(parts.areas[fits], kind="stable")]
    covered = np.cumsum(parts.areas[by_size])
    middle = int(by_size[np.searchsorted(covered, covered[-1] / 2)]) if typical is None else typical
    area = parts.areas[middle]
    scales = np.sqrt(parts.areas / area)
    sides = (parts.boxes[:, [3, 1]] - parts.boxes[:, [2, 0]]) / scales[:, None]
    width, height = np.median(sides[fits], axis=0) + parts.rim
    x, y = parts.points[middle]
    example = enlarged(Example.model_construct(x=x, y=y, width=width, height=height), parts.step, parts.size)
    kept = parts.fits & (parts.areas >= SPECK * area)
    kept |= ~parts.fits & (parts.areas >= CUT_OFF * area) & (parts.areas <= LARGEST_SHARE * parts.labels.size)
    scores = np.clip(2 * parts.roundness - 1, 0, 1)
    index = np.flatnonzero(kept)
    index = index[np.argsort(-scores[index], kind="stable")]
    nothing = np.zeros(len(index))
    poses = Poses(parts.points[index] * parts.step, nothing, scales[index], scores[index], nothing.astype(np.int64))
    return Choice([example], replace(search.coarsely([example]), poses=poses), 0.0, parts.merit)


def _alike(even: Even, divided: list[Parts], search: Search) -> Choice | None:
    """What looks like one example, or like two, and explains the picture best.

    Guesses are compared by quick trials; the winner is searched with care. A second kind is what of the best
    partition's parts it has missed.
    """
    guesses = proposals(even, divided)[:TRIED]
    merits = [_trial(guess, search, even.size) for guess in guesses]
    if not merits or max(merits) <= 0:
        return None
    first = guesses[int(np.argmax(merits))]
    one = _searched([first.example], first.merit, search, even.size)
    if not divided:
        return one
    missed = _missed(one, divided[0])
    second = from_parts(divided[0], missed) if missed.sum() >= OTHER * divided[0].fits.sum() else None
    if second is None:
        return one
    both = _searched([first.example, second.example], divided[0].merit, search, even.size)
    return both if both.confidence > GAIN * one.confidence else one


def _missed(choice: Choice, parts: Parts) -> Array:
    """Which of the parts (n,) fit and are yet none of the elements chosen."""
    from scipy.spatial import cKDTree

    missed = parts.fits.copy()
    if len(choice.points):
        short = min(min(example.width, example.height) for example in choice.examples)
        missed &= np.asarray(cKDTree(choice.points).query(parts.points * parts.step)[0]) > short / 2
    return missed


def _astray(choice: Choice, parts: Parts) -> float:
    """Share of the elements chosen whose centre lies on no part."""
    last = np.array(parts.labels.shape[::-1]) - 1
    column, row = np.clip(np.rint(choice.points / parts.step), 0, last).astype(np.intp).T
    return float((parts.labels[row, column] == 0).mean()) if len(row) else 0.0


def _trial(guess: Proposal, search: Search, shape: tuple[int, ...]) -> float:
    try:
        poses = search.tried(guess.example)
    except OneColourError:  # light was taken off before guessing: what is left may be white all over
        return 0.0
    return guess.merit * explained(_likely(poses, score_floor(poses.scores)), [guess.example], shape)


def _searched(examples: list[Example], merit: float, search: Search, shape: tuple[int, ...]) -> Choice:
    found = search.detect(examples)
    floor = score_floor(found.poses.scores)
    return Choice(examples, found, floor, merit * explained(_likely(found.poses, floor), examples, shape))


def _likely(poses: Poses, floor: float) -> Poses:
    return poses.take(poses.scores >= floor)


def explained(poses: Poses, examples: list[Example], shape: tuple[int, ...]) -> float:
    """Mean correlation x root of the share of the picture in elements' boxes x regularity; 0 for too few.

    What several boxes share counts against it.
    """
    if len(poses.points) < LEAST_COUNT:
        return 0.0
    covered = np.zeros(shape[:2], np.int32)
    for (x, y), scale, kind in zip(poses.points, poses.scales, poses.kinds, strict=True):
        across, down = examples[kind].width * scale / 2, examples[kind].height * scale / 2
        top, left = max(0, round(y - down)), max(0, round(x - across))
        covered[top : max(0, round(y + down)), left : max(0, round(x + across))] += 1
    share = max(0.0, float((covered > 0).mean() - (covered > 1).mean()))
    return float(poses.scores.mean() * np.sqrt(share) * regularity(poses.points))
