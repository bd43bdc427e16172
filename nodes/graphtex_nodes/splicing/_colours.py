"""Colours of two classes of pixels, and the cut between them that costs least."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

STEPS = 12  # of k-means
STEADY = 2e-3  # added to each variance of a colour, as sensors' noise would
SAMPLES = 20_000  # pixels that a mixture is made from
DARK = 0.03  # added before a logarithm is taken
SHADING = 0.4  # weight of brightness against hue and saturation: elements are shaded, and cast shadows
TELLING = 8  # groups of colours, of which some are the background's
LITERAL_SAMPLES = 2000  # colours of a literal set


def told_by_hue(pixels: Array) -> Array:
    """Logarithms of pixels (n, c), the first three turned to brightness, which counts less, and two colour axes.

    Shading multiplies all channels alike, so in logarithms it moves a colour along the first axis only.
    """
    logs: Array = np.log(np.maximum(pixels, 0) + DARK)
    if logs.shape[1] < 3:
        return logs
    red, green, blue = logs[:, :3].T
    bright = SHADING * (red + green + blue) / np.sqrt(3)
    hues = [(red - green) / np.sqrt(2), (red + green - 2 * blue) / np.sqrt(6)]
    return np.concatenate([np.stack([bright, *hues], axis=1), logs[:, 3:]], axis=1)


def mixture_cost(pixels: Array, samples: Array, clusters: int) -> Array:
    """-log p of pixels (n, c) under a mixture of Gaussians fitted to samples (m, c), the likeliest one counting.

    Clusters are those of k-means from places along the samples' longest axis, so nothing is random.
    """
    samples = samples[:: -(-len(samples) // SAMPLES)].astype(np.float64)
    labels = clustered(samples, clusters)
    costs = np.full(len(pixels), np.inf)
    channels = samples.shape[1]
    for index in range(labels.max() + 1):
        members = samples[labels == index]
        if not len(members):
            continue
        middle = members.mean(axis=0)
        apart = members - middle
        spread = np.einsum("ni,nj->ij", apart, apart) / len(members) + STEADY * np.eye(channels)
        whitening = np.linalg.inv(np.linalg.cholesky(spread))
        square = np.zeros(len(pixels))
        for row in range(channels):
            white = sum(whitening[row, k] * (pixels[:, k] - middle[k]) for k in range(row + 1))
            square += white * white
        cost = 0.5 * square + 0.5 * np.linalg.slogdet(spread)[1] - np.log(len(members) / len(samples))
        np.minimum(costs, cost, out=costs)
    return costs


def clustered(samples: Array, count: int) -> Array:
    """Cluster of each sample (n,), by k-means."""
    middle = samples.mean(axis=0)
    axis = int(np.argmax(samples.var(axis=0)))
    order = np.argsort(samples[:, axis], kind="stable")
    centres = np.stack([part.mean(axis=0) for part in np.array_split(samples[order], min(count, len(samples)))])
    centres = np.unique(np.concatenate([centres, middle[None]])[: len(centres)], axis=0)
    labels = np.zeros(len(samples), np.int64)
    for _ in range(STEPS):
        before, labels = labels, nearest_of(samples, centres)
        if (labels == before).all():
            break
        sizes = np.bincount(labels, minlength=len(centres))
        sums = np.stack([np.bincount(labels, samples[:, k], len(centres)) for k in range(samples.shape[1])], axis=1)
        centres = np.where(sizes[:, None] > 0, sums / np.maximum(sizes, 1)[:, None], centres)
    return labels


def nearest_of(samples: Array, centres: Array) -> Array:
    """Index of the nearest centre (k, c) of each sample (n, c); the first of several."""
    labels = np.zeros(len(samples), np.int64)
    nearest = np.full(len(samples), np.inf)
    for index, centre in enumerate(centres):
        square = sum((samples[:, k] - centre[k]) ** 2 for k in range(samples.shape[1]))
        closer = square < nearest
        labels[closer], nearest[closer] = index, square[closer]
    return labels


def nearest_cost(pixels: Array, samples: Array) -> Array:
    """Squared distance of pixels (n, c) to the nearest of a set of colours (m, c)."""
    from scipy.spatial import cKDTree

    colours = samples[:: -(-len(samples) // LITERAL_SAMPLES)]
    found: Array = np.asarray(cKDTree(colours).query(pixels)[0]) ** 2
    return found


def smoothness_costs(image: Array, sigma: float | None) -> tuple[Array, Array]:
    """exp(-|a - b|² / 2 sigma²) for each pixel (h, w) and its right and its lower neighbour, 0 where there is none.

    Without a sigma its square is the picture's mean squared difference of neighbours.
    """
    right = ((image[:, 1:] - image[:, :-1]) ** 2).sum(axis=2)
    down = ((image[1:] - image[:-1]) ** 2).sum(axis=2)
    count = max(right.size + down.size, 1)
    square = sigma**2 if sigma is not None else max(float(right.sum() + down.sum()) / count, 1e-9)
    costs = np.zeros((2, *image.shape[:2]))
    costs[0, :, :-1], costs[1, :-1] = np.exp(-right / (2 * square)), np.exp(-down / (2 * square))
    return costs[0], costs[1]


def least_cut(costs: Array, right: Array, down: Array) -> Array:
    """Labelling (h, w) of least total cost, True where it is foreground.

    `costs` (h, w) is what a pixel costs as foreground less what it costs as background.
    """
    import maxflow

    graph = maxflow.Graph[float](costs.size, 2 * costs.size)
    nodes = graph.add_grid_nodes(costs.shape)
    graph.add_grid_edges(nodes, right, structure=np.array([[0, 0, 0], [0, 0, 1], [0, 0, 0]]), symmetric=True)
    graph.add_grid_edges(nodes, down, structure=np.array([[0, 0, 0], [0, 0, 0], [0, 1, 0]]), symmetric=True)
    graph.add_grid_tedges(nodes, np.maximum(-costs, 0), np.maximum(costs, 0))
    graph.maxflow()
    return ~np.asarray(graph.get_grid_segments(nodes), bool)


def typical_of(pixels: Array, outside: Array, inside: Array, limit: float) -> Array:
    """Which of the pixels outside (n,) have a colour that is rarer inside.

    Of `TELLING` groups of alike colours those count whose share inside is below `limit` times their share outside; if
    there are none all pixels outside count.
    """
    places = np.flatnonzero(inside | outside)
    places = places[:: -(-len(places) // SAMPLES)]
    groups = clustered(pixels[places].astype(np.float64), TELLING)
    centres = np.stack([pixels[places[groups == k]].mean(axis=0) for k in np.unique(groups)])
    nearest = nearest_of(pixels, centres)
    shares = [np.bincount(nearest[side], minlength=len(centres)) / max(side.sum(), 1) for side in (inside, outside)]
    rare = shares[0] < limit * shares[1]
    found: Array = outside & rare[nearest]
    return found if found.any() else outside


def sharpened(mask: Array, light: Array) -> Array:
    """A mask whose border pixels are foreground if more of their light is that of the foreground beside them.

    A pixel on the border between colours F and B has alpha F + (1 - alpha) B in linear light (h, w, c); F and B are
    means over what lies within two pixels and not on the border itself.
    """
    from scipy.ndimage import binary_dilation, binary_erosion, uniform_filter

    square = np.ones((3, 3), bool)
    inner, outer = binary_erosion(mask, square, border_value=1), ~binary_dilation(mask, square)
    means, counts = [], []
    for side in (inner, outer):
        weight = uniform_filter(side.astype(np.float64), 5, mode="constant")
        sums = [uniform_filter(channel * side, 5, mode="constant") for channel in np.moveaxis(light, -1, 0)]
        means.append(np.stack(sums, axis=-1) / np.maximum(weight, 1e-9)[..., None])
        counts.append(weight > 1e-6)
    span = means[0] - means[1]
    alpha = ((light - means[1]) * span).sum(axis=2) / np.maximum((span**2).sum(axis=2), 1e-9)
    told = ~inner & ~outer & counts[0] & counts[1]
    result: Array = np.where(told, alpha > 0.5, mask)
    return result
