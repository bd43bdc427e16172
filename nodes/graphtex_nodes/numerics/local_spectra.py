"""Spectra of a picture's windows that are squares on a plane seen in perspective."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.plane import Plane

Array = NDArray[Any]

WINDOWS_A_SIDE = 7
MOST_A_SIDE = 14
LARGEST_GRID = 96
ANGLES = 12
RADII = 48
LOWEST = 2.0  # cycles in a window; fewer are the window's own
HIGHEST = 0.3  # cycles a pixel; more is what the camera and the resampling have blurred
ALONG = 0.5  # power of the scale with which windows shrink along the tilt
CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])
BLURS = (0.0, 0.6, 0.9, 1.3, 2.0, 3.0, 4.5)  # pixels


@dataclass(frozen=True)
class LocalSpectra:
    """Samples of the power spectra of `count` windows.

    Attributes
    ----------
    x, y
        Middles of the windows, array coordinates, (count,).
    window
        Which window each sample is of, (samples,), rising.
    right, down
        Frequency of each sample in the picture at the window's middle, cycles a pixel, (samples,).
    power
        Logarithm of its power per pixel and frequency, (samples,).
    """

    x: Array
    y: Array
    window: Array
    right: Array
    down: Array
    power: Array

    @property
    def count(self) -> int:
        """Return the number of windows."""
        return len(self.x)


def local_spectra(channels: Array, plane: Plane, usable: Array | None, work: Work) -> LocalSpectra:
    """Power spectra of windows all over a picture, as they are on a plane.

    Each window is a rectangle on the plane, its picture resampled by the plane's perspective; so if the plane is right,
    texels have one size inside of a window, and windows hold equally many of them. Windows keep within the picture, and
    at least nine tenths of each within `usable`. The picture has channels (n, h, w) of variance 1, whose powers are
    averaged: the more of them, the less noise.
    """
    from scipy import fft
    from scipy.ndimage import gaussian_filter, map_coordinates

    side = min(plane.width, plane.height) / 4
    grid = int(np.clip(side, 16, LARGEST_GRID))
    taper = np.outer(np.hanning(grid + 2)[1:-1], np.hanning(grid + 2)[1:-1])
    taper /= np.sqrt((taper**2).sum())
    steps = (np.arange(grid) - (grid - 1) / 2) / grid
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    blurred = [channels, *(gaussian_filter(channels, (0, blur, blur), mode="nearest") for blur in BLURS[1:])]
    places, parts = [], []
    for number, (across, along) in enumerate(_middles(plane, side)):
        work.check()
        scale = float(plane.scale_at(np.array(along)))
        size = np.array([side, side * scale**ALONG])
        x, y = _window(plane, across, along, size * offsets)
        if usable is not None:
            row = np.rint(y).astype(int).clip(0, plane.height - 1)
            if usable[row, np.rint(x).astype(int).clip(0, plane.width - 1)].mean() < 0.9:
                continue
        # pixels of the picture between samples; the picture is blurred before it is sampled more coarsely than that
        stride = float(np.max(size / grid * [scale, scale**2]))
        level = int(np.argmin(np.abs(np.array(BLURS) - 0.45 * np.sqrt(max(stride**2 - 1, 0)))))
        step = size / grid
        spectrum = np.zeros((2 * grid, 2 * grid))
        for channel in blurred[level]:
            patch = map_coordinates(channel, [y, x], order=1, mode="nearest").reshape(grid, grid)
            patch = (patch - (patch * taper**2).sum()) * taper
            # twice as fine as the window's own resolution, then smoothed to about that
            spectrum += np.abs(fft.fft2(patch, spectrum.shape)) ** 2 * (step[0] * step[1] / len(channels))
        spectrum = gaussian_filter(fft.fftshift(spectrum), 2.0, mode="wrap")
        u, v = _plane_frequencies(side, size, number)
        k_across, k_along = _picture_frequencies(plane, across, scale, u, v)
        seen = (
            (np.hypot(k_across, k_along) < HIGHEST)
            & (np.maximum(np.abs(u) * step[0], np.abs(v) * step[1]) < 0.42)
        )  # fmt: skip
        at = [grid + v[seen] * step[1] * 2 * grid, grid + u[seen] * step[0] * 2 * grid]
        right, down = _turned_back(plane, k_across[seen], k_along[seen])
        power = map_coordinates(spectrum, at, order=1) * scale**3 / _transfer(right, down, BLURS[level], stride)
        places.append(plane.to_picture(*plane.to_plane(np.array(across), np.array(along))))
        parts.append((right, down, power))
    if not places:
        none = np.empty(0)
        return LocalSpectra(none, none, none.astype(np.intp), none, none, none)
    power = np.concatenate([part[2] for part in parts])
    return LocalSpectra(
        np.array([place[0] for place in places]), np.array([place[1] for place in places]),
        np.repeat(np.arange(len(parts)), [len(part[2]) for part in parts]),
        np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts]),
        np.log(power + 1e-5 * power.mean()),
    )  # fmt: skip


def _window(plane: Plane, across: float, along: float, offsets: Array) -> tuple[Array, Array]:
    """Array coordinates x, y of plane offsets (n, 2) from what the picture shows at across, along."""
    u, v = plane.to_plane(np.array(across), np.array(along))
    u, v = u + offsets[:, 0], v + offsets[:, 1]
    if plane.steepness:
        v = np.maximum(v, -0.95 / plane.steepness)  # nearer than that lies behind the camera
    return plane.to_picture(u, v)


def _middles(plane: Plane, side: float) -> list[tuple[float, float]]:
    """(across, along) of windows on an even grid of the picture, moved as far as they need to lie inside of it."""
    shorter = min(plane.width, plane.height)
    columns, rows = (
        min(MOST_A_SIDE, round(WINDOWS_A_SIDE * length / shorter)) for length in (plane.width, plane.height)
    )
    found: dict[tuple[int, int], tuple[float, float]] = {}
    for row in range(rows):
        for column in range(columns):
            x, y = (column + 0.5) * plane.width / columns - 0.5, (row + 0.5) * plane.height / rows - 0.5
            for _ in range(6):  # a window's size changes as it moves
                across, along = (float(value) for value in plane.rotate(np.array(x), np.array(y)))
                size = np.array([side, side * float(plane.scale_at(np.array(along))) ** ALONG])
                corner_x, corner_y = _window(plane, across, along, size * CORNERS)
                x += float(max(-0.5 - corner_x.min(), 0) - max(corner_x.max() - plane.width + 0.5, 0))
                y += float(max(-0.5 - corner_y.min(), 0) - max(corner_y.max() - plane.height + 0.5, 0))
                x, y = min(max(x, 0.0), plane.width - 1.0), min(max(y, 0.0), plane.height - 1.0)
            inside = (corner_x > -1.5) & (corner_x < plane.width + 0.5) & (corner_y > -1.5)
            if (inside & (corner_y < plane.height + 0.5)).all():
                found.setdefault((round(x / 3), round(y / 3)), (across, along))
    return list(found.values())


def _plane_frequencies(side: float, size: Array, number: int) -> tuple[Array, Array]:
    """Frequencies (across, along) on the plane in ANGLES directions, from LOWEST cycles in a window of this size.

    Each window's grid lies elsewhere between two steps (by multiples of the golden ratio and of the root of 2): if they
    lay alike, the plane that windows were cut on would seem better than any other.
    """
    turn, shift = number * 0.6180339887 % 1, number * 0.4142135624 % 1
    radius = np.exp(np.log(LOWEST / side) * (1 - (np.arange(RADII) + shift) / RADII))[:, None]
    angle = (np.arange(ANGLES) + turn) * (np.pi / ANGLES)
    u, v = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()
    enough = np.maximum(np.abs(u) * size[0], np.abs(v) * size[1]) >= LOWEST
    return u[enough], v[enough]


def _picture_frequencies(plane: Plane, across: float, scale: float, u: Array, v: Array) -> tuple[Array, Array]:
    """Frequencies in the picture (across, along) of plane frequencies: the transposed Jacobian of `Plane.to_plane`."""
    return u / scale, (u * across * plane.steepness + v) / scale**2


def to_plane_frequencies(
    plane: Plane, across: Array, scale: Array, k_across: Array, k_along: Array
) -> tuple[Array, Array]:
    """Frequencies on a plane (of centre scale and foreshortening 1) of frequencies in its picture."""
    u = scale * k_across
    return u, scale**2 * k_along - across * plane.steepness * u


def _turned_back(plane: Plane, across: Array, along: Array) -> tuple[Array, Array]:
    """Frequencies to the right and down of frequencies across and along the tilt."""
    sin, cos = np.sin(np.radians(plane.tilt)), np.cos(np.radians(plane.tilt))
    return across * cos + along * sin, across * sin - along * cos


def _transfer(right: Array, down: Array, blur: float, stride: float) -> Array:
    """Power that is left of each frequency after the camera's pixels, the blur and linear interpolation."""
    pixels = np.sinc(right) ** 2 * np.sinc(down) ** 2
    left: Array = pixels * np.exp(-((2 * np.pi * blur) ** 2) * (right**2 + down**2))
    return np.maximum(left * pixels if stride < 1 else left, 1e-3)
