"""Textures and prepared textures from folders and to folders, and prepared ones from samples and archives."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from graphtex import QUIET, Context, FilePath, Texture, node, opener, writer
from graphtex_nodes.image.exemplars.sample_texture import Name, sample_texture
from graphtex_nodes.image.load_data import load_texture
from graphtex_nodes.splicing.prepare_texture import PreparedTexture, prepare_texture

SUFFIX = ".texture"
Folder = Annotated[FilePath, Field(description="the texture's folder")]


@opener(Texture, suffixes=(SUFFIX,), folder=True)
@node
def load_texture_folder(*, path: Folder, ctx: Context = QUIET) -> Texture:
    """Read an entry of a texture database: a folder with ``image.*``, ``mask.png``, ``points.csv`` and ``tag.txt``.

    All are plain files to be edited: white is foreground, each line of points is ``x,y`` of an element's centre in
    pixels, the tag is F=c, F=d or B=c (Liu et al. 2009, section 3.1). What is in ``derived`` is not looked at.

    Raises
    ------
    ValueError
        A file is missing or damaged, the mask has another size than the picture or is all or nothing, points lie
        outside, or the tag is not known; the message names the file.
    """
    from graphtex_nodes.splicing.texture_folder import read_texture

    return read_texture(path, ctx)


@opener(PreparedTexture, suffixes=(SUFFIX,), folder=True)
@node
def load_prepared(*, path: Folder, ctx: Context = QUIET) -> PreparedTexture:
    """Read an entry of a texture database with what was derived from it; see `LoadTextureFolder`.

    Files in ``derived`` say of which files, and by which code, they were made. Where that is no longer so, or where
    they are damaged, they are not used: the texture is prepared anew, with a warning. Without any it is prepared.

    Raises
    ------
    ValueError
        As `LoadTextureFolder`; or the texture cannot be prepared.
    """
    from graphtex_nodes.splicing.derived_files import FOLDER, Stale, read_derived, window
    from graphtex_nodes.splicing.texture_folder import read_texture

    texture = read_texture(path, ctx)
    if not (path / FOLDER).exists():
        return prepare_texture(texture, ctx=ctx)
    try:
        return read_derived(texture, path)
    except Stale as reason:
        ctx.warn(f"{path}: {reason}: the texture is prepared anew; splicing/database-update keeps that")
    width, height = window(path)
    return prepare_texture(texture, width=width, height=height, ctx=ctx)


@opener(PreparedTexture, scheme="sample")
@node
def sample_prepared(
    *, name: Annotated[Name, Field(description="which sample")], ctx: Context = QUIET
) -> PreparedTexture:
    """A sample texture, prepared for splicing: `SampleTexture`, then `PrepareTexture`."""
    return prepare_texture(sample_texture(name=name), ctx=ctx)


@opener(PreparedTexture, suffixes=(".npz",))
@node
def load_prepared_archive(*, path: FilePath, ctx: Context = QUIET) -> PreparedTexture:
    """A texture from an archive, prepared for splicing: `LoadTexture`, then `PrepareTexture`."""
    return prepare_texture(load_texture(path=path), ctx=ctx)


@writer(Texture, suffixes=(SUFFIX,), default=SUFFIX, folder=True)
def save_texture_folder(value: Texture, path: Path) -> None:
    """Write the folder that `load_texture_folder` reads."""
    from graphtex_nodes.splicing.texture_folder import write_texture

    write_texture(value, path)


@writer(PreparedTexture, suffixes=(SUFFIX,), default=SUFFIX, folder=True)
def save_prepared(value: PreparedTexture, path: Path) -> None:
    """Write the folder that `load_prepared` reads."""
    from graphtex_nodes.splicing.derived_files import write_derived
    from graphtex_nodes.splicing.texture_folder import write_texture

    write_texture(value.texture, path)
    write_derived(value, path)
