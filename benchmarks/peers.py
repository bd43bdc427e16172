"""Other tools from the package index (``pip install 'graphtex[bench]'``): called alike, left out when missing."""

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Synthesiser = Callable[[Array, tuple[int, int], int], Array]
Filler = Callable[[Array, Array, int], Array]

RADIUS = 3  # of pypatchmatch's patches: what its own examples take
COLOURS = 3  # channels that every tool understands


def synthesisers() -> dict[str, Synthesiser]:
    """Tools that make a larger texture of (exemplar, (height, width), seed): those that are installed."""
    return {"G'MIC": gmic_matchpatch} if installed("gmic") else {}


def fillers() -> dict[str, Filler]:
    """Tools that fill the hole (True) of (picture, hole, seed): those that are installed."""
    found: dict[str, Filler] = {}
    if installed("patchmatch_cython"):
        found["patchmatch-cython"] = patchmatch_cython
    if installed("patchmatch"):
        found["pypatchmatch"] = pypatchmatch
    if installed("cv2") and hasattr(importlib.import_module("cv2"), "xphoto"):
        found["OpenCV FSR"] = opencv_fsr
        found["OpenCV shift map"] = opencv_shiftmap
    return found


def installed(module: str) -> bool:
    """Whether a module can be imported."""
    try:
        importlib.import_module(module)
    except ImportError:
        return False
    return True


def gmic_matchpatch(exemplar: Array, size: tuple[int, int], seed: int) -> Array:
    """G'MIC's ``syntexturize_matchpatch`` with its own defaults."""
    gmic: Any = importlib.import_module("gmic")
    picture = gmic.Image.from_yxc(np.ascontiguousarray(exemplar * 255, np.float32))
    height, width = size
    result = gmic.run(f"srand {seed} syntexturize_matchpatch {width},{height}", gmic.ImageList([picture]))
    columns_first = np.array(result[0].to_numpy())[:, :, 0]
    return np.ascontiguousarray(columns_first.transpose(1, 0, 2) / np.float32(255)).clip(0, 1)


def patchmatch_cython(picture: Array, hole: Array, seed: int) -> Array:
    """``inpaint_pyramid`` of patchmatch-cython with its own defaults."""
    tool: Any = importlib.import_module("patchmatch_cython")
    return _restored(tool.inpaint_pyramid(_bytes(picture), hole, seed=seed), picture, hole)


def pypatchmatch(picture: Array, hole: Array, seed: int) -> Array:
    """``inpaint`` of PyPatchMatch with the patches of its own examples."""
    tool: Any = importlib.import_module("patchmatch")
    tool.set_random_seed(seed)
    return _restored(tool.inpaint(_bytes(picture), hole, patch_size=RADIUS), picture, hole)


def opencv_fsr(picture: Array, hole: Array, seed: int) -> Array:
    """Frequency selective reconstruction of OpenCV's xphoto, the fast one; it draws nothing at random."""
    return _xphoto(picture, hole, "INPAINT_FSR_FAST")


def opencv_shiftmap(picture: Array, hole: Array, seed: int) -> Array:
    """Shift maps (He & Sun 2012) of OpenCV's xphoto, in CIELab as it asks for."""
    return _xphoto(picture, hole, "INPAINT_SHIFTMAP")


def _xphoto(picture: Array, hole: Array, method: str) -> Array:
    cv2: Any = importlib.import_module("cv2")
    source = _bytes(picture)
    known = np.where(hole, 0, 255).astype(np.uint8)
    lab = method == "INPAINT_SHIFTMAP"
    source = cv2.cvtColor(source, cv2.COLOR_RGB2LAB) if lab else source
    filled = np.zeros_like(source)
    cv2.xphoto.inpaint(source, known, filled, getattr(cv2.xphoto, method))
    return _restored(cv2.cvtColor(filled, cv2.COLOR_LAB2RGB) if lab else filled, picture, hole)


def _bytes(picture: Array) -> Array:
    """Three channels of 8 bits."""
    colour = np.repeat(picture, COLOURS, axis=2) if picture.shape[2] == 1 else picture[..., :COLOURS]
    return np.ascontiguousarray(np.rint(colour.clip(0, 1) * 255).astype(np.uint8))


def _restored(filled: Array, picture: Array, hole: Array) -> Array:
    """What was filled, in the picture's own channels; what was known is as it was."""
    values = filled.astype(np.float32) / 255
    if picture.shape[2] == 1:
        values = values.mean(axis=2, keepdims=True)
    result: Array = np.where(hole[..., None], values, picture)
    return result
