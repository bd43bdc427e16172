"""Sides of the maps that nodes make."""

from typing import Annotated

from pydantic import Field

MOST = 16384
Pixels = Annotated[int, Field(ge=1, le=MOST, description="size of the map in pixels")]
