"""Textures with their elements by name, for what splices them."""

from typing import Annotated, Literal

from pydantic import Field

from graphtex import QUIET, Context, Texture, node, opener
from graphtex_nodes.image.exemplars.sample import ELEMENTS

Name = Literal["berries", "blossoms", "leaves", "oranges", "tiles"]

TAGS: dict[Name, str] = {"berries": "F=d", "blossoms": "F=d", "leaves": "F=d", "oranges": "F=d", "tiles": "B=c"}


@opener(Texture, scheme="sample")
@node
def sample_texture(*, name: Annotated[Name, Field(description="which sample")], ctx: Context = QUIET) -> Texture:
    """A texture with its true mask and texton points: ``sample:oranges`` where a graph wants a texture.

    Its picture is that of `Sample`. ``tiles`` are bricks in mortar (tag ``B=c``), the elements of the others keep
    their shape (``F=d``), also those of ``berries``, which touch: moved as one piece (``F=c``) they would be torn.

    Returns
    -------
    Texture
        192 x 192, in colour.
    """
    made = ELEMENTS[name](ctx=ctx)
    return Texture(made.image, made.mask, made.centres, TAGS[name])
