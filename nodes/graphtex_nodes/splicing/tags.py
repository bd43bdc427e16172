"""Which part of a texture keeps its shape when it is spliced (Liu et al. 2009, section 3.1)."""

from typing import Annotated, Literal, get_args

from pydantic import Field

RigidPart = Literal["F=c", "F=d", "B=c"]
Tag = Annotated[
    RigidPart,
    Field(description="what is rigid: F=c a connected foreground, F=d a disjoint one, B=c a connected background"),
]


def checked_tag(tag: str, name: str) -> RigidPart:
    """Return a tag as it is; ValueError with the name of what holds it if it is none of the three."""
    for known in get_args(RigidPart):
        if tag == known:
            found: RigidPart = known
            return found
    raise ValueError(f"{name}: expected one of {', '.join(get_args(RigidPart))}, got {tag!r}")
