"""Appearance vectors of a picture (Lefebvre & Hoppe 2006), which self-similarity is measured on."""

from typing import Annotated, NamedTuple

from pydantic import Field

from graphtex import Image, Number, node


class Appearance(NamedTuple):
    """A map of appearance vectors, and the share of the neighbourhoods' variance that they keep."""

    appearance: Image
    kept: Number


@node
def appearance_vectors(
    image: Image, *, channels: Annotated[int, Field(ge=1, le=16, description="numbers for each pixel")] = 8
) -> Appearance:
    """Project each pixel's 5 x 5 neighbourhood, weighted by a Gaussian, onto its first principal components.

    Channels of the result stand for colour, edges and small patterns rather than for single pixels, so comparing a few
    pixels of it compares whole neighbourhoods (Liu et al. 2009, section 3.2, take the first 8 channels).

    Parameters
    ----------
    image
        Shape (h, w, c). Beyond its border the picture is mirrored.

    Returns
    -------
    appearance
        Shape (h, w, channels), mean 0 but for sampling, in the picture's units, in the order of falling variance. Fewer
        channels where neighbourhoods have fewer dimensions; a constant picture has one, of zeros.
    kept
        Share of the variance of the weighted neighbourhoods, 0 to 1.

    Examples
    --------
    >>> step = np.repeat(np.float32([[0, 0, 0, 1, 1, 1]]), 6, axis=0)[..., None]
    >>> appearance, kept = appearance_vectors(step, channels=2)
    >>> appearance.shape, kept > 0.9
    ((6, 6, 2), True)
    """
    from graphtex_nodes.numerics.appearance import appearance_space

    space = appearance_space(image, channels)
    return Appearance(space.project(image), space.kept)
