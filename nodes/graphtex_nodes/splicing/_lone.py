"""Elements that stand alone in a picture."""

from graphtex_nodes.splicing._partitions import LEAST_COUNT, Even, Parts, measured, solids

LARGEST_ALONE = 0.5  # of the picture that one of them covers
ALONE = 0.9  # their least share of all that stands apart like them


def few_parts(even: Even) -> list[Parts]:
    """Parts that stand alone on a ground, too few for a texture: nothing else of their kind reaches the border."""
    from scipy.ndimage import label

    found = []
    for mask, contrast, rim in solids(even.picture):
        parts = measured(label(mask)[0], contrast, even.step, even.size, rim, 1, LARGEST_ALONE)
        if parts is not None:
            area = parts.areas[parts.fits]
            if len(area) < LEAST_COUNT and area.sum() >= ALONE * parts.areas.sum():
                found.append(parts)
    return sorted(found, key=lambda parts: -parts.merit)
