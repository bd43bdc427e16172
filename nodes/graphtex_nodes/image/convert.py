"""Between pictures, masks and the pictures of maps; channels of a picture."""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import AngleMap, Displacement, Image, LabelMap, Mask, SourceMap, node
from graphtex_nodes.image import views
from graphtex_nodes.image.files.colour import decode_srgb, encode_srgb

GreyMethod = Literal["luma", "luminance", "mean"]
_REC709 = np.array([0.2126, 0.7152, 0.0722], np.float32)


@node
def grey(
    image: Image,
    *,
    method: Annotated[GreyMethod, Field(description="weights on encoded values, on linear light, or none")] = "luma",
) -> Image:
    """Make one channel of a picture.

    ``luma`` weighs the encoded R, G, B by (0.2126, 0.7152, 0.0722); ``luminance`` weighs linear light and encodes the
    sum; ``mean`` is for maps that are not colour. Alpha (of 2 and 4 channels) is left out.

    Raises
    ------
    ValueError
        If the picture has more than 4 channels and the method is not ``mean``.
    """
    return _grey(image, method)[..., None]


def _grey(image: NDArray[np.float32], method: GreyMethod) -> NDArray[np.float32]:
    channels = image.shape[2]
    colour = image[..., : {2: 1, 4: 3}.get(channels, channels)]
    if colour.shape[2] == 1:
        return colour[..., 0].copy()
    if method == "mean":
        mean: NDArray[np.float32] = colour.mean(axis=2, dtype=np.float64).astype(np.float32)
        return mean
    if colour.shape[2] != 3:
        raise ValueError(f"method: {method} is for up to 4 channels, got {channels}: use mean or PickChannels")
    if method == "luminance":
        return encode_srgb(decode_srgb(colour) @ _REC709)
    weighed: NDArray[np.float32] = colour @ _REC709
    return weighed


@node
def pick_channels(
    image: Image,
    *,
    channels: Annotated[
        list[Annotated[int, Field(ge=0, lt=16)]],
        Field(min_length=1, max_length=16, description="which channels, from 0, in the new order"),
    ],
) -> Image:
    """Take channels of a picture in a given order: [2, 1, 0] swaps red and blue, [0, 0, 0] makes grey RGB.

    Raises
    ------
    ValueError
        If the picture has no such channel.
    """
    if max(channels) >= image.shape[2]:
        raise ValueError(f"channels: the picture has 0 to {image.shape[2] - 1}, got {max(channels)}")
    return image[..., channels]


@node
def mask_from_image(
    image: Image,
    *,
    threshold: Annotated[float, Field(description="True is at or above it")] = 0.5,
    channel: Annotated[
        Literal["grey", "alpha"] | Annotated[int, Field(ge=0, lt=16)],
        Field(description="grey (luma), alpha, or a channel's number from 0"),
    ] = "grey",
    invert: Annotated[bool, Field(description="True is below the threshold")] = False,
) -> Mask:
    """Make a mask of the bright places of a picture.

    Raises
    ------
    ValueError
        If the picture lacks the channel.
    """
    count = image.shape[2]
    if channel == "grey":
        values = _grey(image, "luma" if count <= 4 else "mean")
    elif channel == "alpha":
        if count not in (2, 4):
            raise ValueError(f"channel: alpha is the last of 2 or 4 channels, got {count}")
        values = image[..., -1]
    else:
        if channel >= count:
            raise ValueError(f"channel: the picture has 0 to {count - 1}, got {channel}")
        values = image[..., channel]
    # in double, so that 0.1 as float32 is not below 0.1
    mask = values >= np.float32(threshold)
    return ~mask if invert else mask


@node
def image_from_mask(mask: Mask) -> Image:
    """Make a grey picture of a mask: True is 1, False is 0."""
    return mask[..., None].astype(np.float32)


@node
def image_from_labels(labels: LabelMap) -> Image:
    """Picture of a label map: a colour for each label."""
    return _floats(views.view_labels(labels))


@node
def image_from_angles(angles: AngleMap) -> Image:
    """Picture of an angle map: hue is the direction, right red and left cyan."""
    return _floats(views.view_angles(angles))


@node
def image_from_displacement(displacement: Displacement) -> Image:
    """Picture of a displacement: hue is the direction, saturation the length in parts of the longest."""
    return _floats(views.view_displacement(displacement))


@node
def image_from_source(source: SourceMap) -> Image:
    """Picture of a source map: red grows with the source's column, green with its row, blue tells the exemplar."""
    return _floats(views.view_source(source))


def _floats(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    return (picture / np.float32(255)).astype(np.float32)
