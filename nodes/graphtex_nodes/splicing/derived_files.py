"""What was derived from a texture, in the folder ``derived`` of its folder: arrays, and a page that says of what."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
from numpy.typing import NDArray

from graphtex import Texture, code_digest, file_digest
from graphtex_nodes.image.files.decode import load_npy
from graphtex_nodes.splicing.prepare_texture import PreparedTexture, prepare_texture
from graphtex_nodes.splicing.texture_folder import digests

FOLDER, PAGE = "derived", "derived.json"
FORMAT = 1
PARTS = PreparedTexture._fields[1:]  # all but the texture itself
Leaf = NDArray[Any] | int | float | str


class Stale(Exception):
    """Why derived files cannot be used."""


def write_derived(prepared: PreparedTexture, folder: Path) -> None:
    """Write all but the texture itself beside the files of the texture, which are there already."""
    (folder / FOLDER).mkdir()
    files: dict[str, dict[str, str]] = {}
    values: dict[str, Any] = {}
    stored: dict[str, str] = {}  # digest -> file: equal arrays, such as both factors of many textures, are kept once
    for name, leaf in (found for part in PARTS for found in _leaves(getattr(prepared, part), part)):
        if not isinstance(leaf, np.ndarray):
            values[name] = leaf
            continue
        file = folder / FOLDER / f"{name}.npy"
        np.save(file, leaf, allow_pickle=False)
        digest = file_digest(file)
        if stored.setdefault(digest, file.name) != file.name:
            file.unlink()
        files[name] = {"file": stored[digest], "sha256": digest}
    page = {"format": FORMAT, "code": _code(), "made_from": digests(folder), "values": values, "arrays": files}
    text = json.dumps({**page, "sha256": _digest_of(page)}, indent=1, sort_keys=True)
    (folder / FOLDER / PAGE).write_text(f"{text}\n", encoding="utf-8")


def read_derived(texture: Texture, folder: Path) -> PreparedTexture:
    """What was derived from the texture of a folder; `Stale` if it was not made of these files by this code."""
    try:
        page = _page(folder)
        if page["format"] != FORMAT or page["code"] != _code():
            raise Stale("its derived files were made by another version")
        before, now = page["made_from"], digests(folder)
        changed = sorted(name for name in now.keys() | before.keys() if now.get(name) != before.get(name))
        if changed:
            raise Stale(f"{', '.join(changed)} changed since files were derived")
        leaves = {**page["values"], **{name: _array(folder, entry) for name, entry in page["arrays"].items()}}
        kinds = get_type_hints(PreparedTexture)
        return PreparedTexture(texture, *(_built(kinds[part], part, leaves) for part in PARTS))
    except (OSError, ValueError, LookupError) as error:
        raise Stale(f"{FOLDER} is damaged ({error})") from error


def window(folder: Path) -> tuple[int, int]:
    """Width and height that derived files were made for; (0, 0) if they do not tell."""
    try:
        values = _page(folder)["values"]
        return values["extension.width"], values["extension.height"]
    except (OSError, ValueError, LookupError):
        return 0, 0


def _page(folder: Path) -> dict[str, Any]:
    """The page of a folder; ValueError if it is not as it was written."""
    page = json.loads((folder / FOLDER / PAGE).read_text(encoding="utf-8"))
    if not isinstance(page, dict) or page.pop("sha256", "") != _digest_of(page):
        raise ValueError(f"{PAGE} is not as it was written")
    return page


def _digest_of(page: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(page, sort_keys=True).encode()).hexdigest()


def _code() -> str:
    """Digest of the code that derives."""
    return code_digest(prepare_texture.function).digest


def _leaves(value: Any, name: str) -> Iterator[tuple[str, Leaf]]:
    """Dotted names and values of all arrays and scalars in nested named tuples."""
    if not isinstance(value, tuple):
        yield name, value
        return
    for key, item in value._asdict().items():  # type: ignore[attr-defined]
        yield from _leaves(item, f"{name}.{key}")


def _built(kind: type, name: str, leaves: Mapping[str, Leaf]) -> Any:
    """Named tuples of a type, of what `_leaves` gave; LookupError if something is not there."""
    return kind(
        *(
            _built(hint, f"{name}.{key}", leaves) if hasattr(hint, "_fields") else leaves[f"{name}.{key}"]
            for key, hint in get_type_hints(kind).items()
        )
    )


def _array(folder: Path, entry: Mapping[str, str]) -> NDArray[Any]:
    """An array as it was written; ValueError if its file holds anything else."""
    file = folder / FOLDER / Path(entry["file"]).name
    if file_digest(file) != entry["sha256"]:
        raise ValueError(f"{file} is damaged")
    return load_npy(file)
