import numpy as np
import pytest

from graphtex import Cancelled, Context
from graphtex_nodes.numerics import inpaint_kernels
from graphtex_nodes.numerics.cielab import lab_of
from graphtex_nodes.perspective.exemplar_inpaint import exemplar_inpaint
from tests.nodes.perspective.holes import KINDS, SHAPE, hole_of

QUIET = Context(threads=1, on_warning=lambda text: None)
NOISE = np.random.default_rng(3).random((*SHAPE, 3)).astype(np.float32)


def priorities(picture, filled, radius):
    """Priorities of all pixels of a grey picture, with confidence 1 where it is filled."""
    found = np.zeros(picture.shape, np.float32)
    planes, flags = picture[None].astype(np.float32), filled.astype(np.uint8)
    inpaint_kernels.prioritise(planes, flags, filled.astype(np.float32), radius, found, 0, len(filled), 0, 5)
    return found


def test_priority_by_hand():
    """A vertical edge runs into a hole of one row: confidence 6/9, and the gradient over two pixels is 1/2."""
    picture, filled = np.tile([0, 0, 0, 1, 1], (5, 1)), np.ones((5, 5), bool)
    picture[3:] = 0
    filled[3:] = False
    found = priorities(picture, filled, 1)
    assert (found[[0, 1, 2, 4]] == -1).all()
    np.testing.assert_allclose(found[3], np.array([2 / 6, 3 / 9, 3 / 9, 3 / 9, 2 / 6]) * [0.001, *[0.501] * 3, 0.501])


def test_edge_along_the_front_does_not_count():
    """The gradient turned by a right angle lies in the front then."""
    picture, filled = np.repeat([[0], [0], [1], [1], [0]], 5, axis=1), np.ones((5, 5), bool)
    filled[4] = False
    np.testing.assert_allclose(priorities(picture, filled, 2)[4, 2], 10 / 15 * 0.001)


def test_strong_edge_goes_on_first():
    """A step from dark to bright crosses a hole in noise much weaker than it, and stays straight."""
    photo = NOISE[..., :1] * 0.1
    photo[:, 25:] += 0.8
    hole = np.zeros(SHAPE, bool)
    hole[10:30, 15:35] = True
    image = exemplar_inpaint(photo, hole, patch=7, ctx=QUIET).image
    np.testing.assert_array_equal(image[..., 0] > 0.5, photo[..., 0] > 0.5)


def filled_slowly(photo, hole, patch):
    """The same algorithm written out pixel by pixel."""
    height, width = hole.shape
    radius = patch // 2
    image, known = np.where(hole[..., None], 0, photo).astype(np.float64), ~hole
    confidence = known.astype(np.float32)

    def window(y, x):
        return [
            (v, u)
            for v in range(max(0, y - radius), min(height, y + radius + 1))
            for u in range(max(0, x - radius), min(width, x + radius + 1))
        ]

    def slope(y, x, c, down, right):
        ends = []
        for sign in (-1, 1):
            v, u = y + sign * down, x + sign * right
            inside = 0 <= v < height and 0 <= u < width and known[v, u]
            ends.append((v, u, sign) if inside else (y, x, 0))
        (v0, u0, s0), (v1, u1, s1) = ends
        return (image[v1, u1, c] - image[v0, u0, c]) / max(1, s1 - s0)

    def priority(y, x):
        patch = window(y, x)
        seen = [(v, u) for v, u in patch if known[v, u]]
        total = np.float32(0)
        best = (0.0, 0.0, 0.0)
        for v, u in seen:
            total += confidence[v, u]
            for c in range(photo.shape[2]):
                dy, dx = slope(v, u, c, 1, 0), slope(v, u, c, 0, 1)
                if dy * dy + dx * dx > best[0]:
                    best = (dy * dy + dx * dx, dy, dx)
        around = np.pad(known, 1, mode="edge")[y : y + 3, x : x + 3].astype(float)
        normal = np.array([(around[2] - around[0]) @ [1, 2, 1], (around[:, 2] - around[:, 0]) @ [1, 2, 1]])
        length = np.float32(np.hypot(*normal))
        data = abs(best[2] * normal[0] - best[1] * normal[1]) / length if length else 0.0
        return np.float32(total / len(patch) * (data + np.float32(1e-3))), total / len(patch)

    sources = [
        (v, u)
        for v in range(radius, height - radius)
        for u in range(radius, width - radius)
        if not hole[v - radius : v + radius + 1, u - radius : u + radius + 1].any()
    ]
    while not known.all():
        front = [
            (y, x)
            for y, x in np.argwhere(~known)
            if any(
                0 <= v < height and 0 <= u < width and known[v, u]
                for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1))
            )
        ]
        found = [priority(*place) for place in front]
        chosen = int(np.argmax([value for value, _ in found]))
        y, x = front[chosen]
        seen = [place for place in window(y, x) if known[place]]

        def cost(source, seen=seen, y=y, x=x):
            v, u = source
            squares = sum(((image[b, a] - image[b + v - y, a + u - x]) ** 2).sum() for b, a in seen)
            return squares, (v - y) ** 2 + (u - x) ** 2, v, u

        _, _, v, u = min(cost(source) for source in sources)
        missing = [place for place in window(y, x) if not known[place]]
        for b, a in missing:
            image[b, a] = image[b + v - y, a + u - x]
            confidence[b, a] = found[chosen][1]
        for place in missing:
            known[place] = True
    return image


@pytest.mark.parametrize("patch", [3, 5])
@pytest.mark.parametrize("channels", [1, 2])
@pytest.mark.parametrize("number", range(4))
def test_agrees_with_the_algorithm_written_out(patch, channels, number):
    """On small integers, so that sums of squares are exact and ties abound."""
    rng = np.random.default_rng(number)
    photo = rng.integers(0, 4, (13, 15, channels)).astype(np.float32)
    hole = np.zeros((13, 15), bool)
    top, left = rng.integers(0, 8, 2)
    hole[top : top + 5, left : left + 7] = True
    hole[rng.integers(0, 13), rng.integers(0, 15)] = True
    result = exemplar_inpaint(photo, hole, patch=patch, colours="channels", ctx=QUIET)
    np.testing.assert_array_equal(result.image, filled_slowly(photo, hole, patch))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("channels", [1, 3, 5])
def test_any_hole(kind, channels):
    """Known pixels stay, all others are copies of known ones."""
    hole = hole_of(kind)
    photo = np.ascontiguousarray(NOISE[..., np.arange(channels) % 3])
    result = exemplar_inpaint(np.where(hole[..., None], np.float32(9), photo), hole, ctx=QUIET)
    np.testing.assert_array_equal(result.image[~hole], photo[~hole])
    rows, columns = (result.source[..., k].astype(int) for k in (1, 2))
    assert not hole[rows, columns].any()
    np.testing.assert_array_equal(result.image, photo[rows, columns])
    np.testing.assert_array_equal(result.source[~hole, 1:3], np.argwhere(~hole))


def test_smaller_patches_where_none_is_free():
    told = []
    exemplar_inpaint(NOISE, hole_of("sprinkled"), patch=9, ctx=Context(threads=1, on_warning=told.append))
    assert len(told) == 1
    assert "no patch of 9 pixels is free of the hole" in told[0]


@pytest.mark.parametrize("shape", [(1, 2), (2, 1), (5, 4)])
def test_picture_smaller_than_the_patch(shape):
    hole = np.zeros(shape, bool)
    hole[0, 0] = True
    photo = NOISE[: shape[0], : shape[1]]
    assert exemplar_inpaint(photo, hole, ctx=QUIET).image[0, 0] in photo[~hole]


def test_takes_from_the_source_only():
    hole, source = hole_of("corner"), np.zeros(SHAPE, bool)
    source[25:, 30:] = True
    found = exemplar_inpaint(NOISE, hole, source, ctx=QUIET).source[hole]
    assert (found[:, 1] >= 25).all()
    assert (found[:, 2] >= 30).all()


def test_takes_from_the_surroundings_only():
    found = exemplar_inpaint(NOISE, hole_of("corner"), surroundings=12, ctx=QUIET).source[hole_of("corner")]
    assert found[:, 1].max() < 12 + 12
    assert found[:, 2].max() < 9 + 12


def test_same_bytes_with_two_threads():
    photo = np.tile(NOISE, (4, 4, 1))
    hole = np.zeros(photo.shape[:2], bool)
    hole[60:90, 70:100] = True
    first, second = (exemplar_inpaint(photo, hole, ctx=Context(threads=threads)) for threads in (1, 2))
    np.testing.assert_array_equal(first.image, second.image)
    np.testing.assert_array_equal(first.source, second.source)


def test_no_hole_changes_nothing():
    result = exemplar_inpaint(NOISE, np.zeros(SHAPE, bool), ctx=QUIET)
    np.testing.assert_array_equal(result.image, NOISE)


def test_can_be_cancelled():
    with pytest.raises(Cancelled):
        exemplar_inpaint(NOISE, hole_of("corner"), ctx=Context(threads=1, cancelled=lambda: True))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"hole": np.ones(SHAPE, bool)}, "hole: expected some pixels outside"),
        ({"hole": np.ones((4, 5), bool)}, "hole"),
        ({"source": hole_of("corner")}, "source: expected some pixels"),
        ({"patch": 8}, "patch: expected an odd number, got 8"),
        ({"photo": np.full((*SHAPE, 1), np.nan, np.float32)}, "photo"),
    ],
)
def test_refuses(wrong, message):
    sockets = {"photo": NOISE, "hole": hole_of("corner"), **wrong}
    with pytest.raises(ValueError, match=message):
        exemplar_inpaint(ctx=QUIET, **sockets)


def test_lab_is_scikit_images():
    from skimage.color import rgb2lab

    np.testing.assert_allclose(lab_of(NOISE), rgb2lab(NOISE), atol=0.05)
