"""What can go wrong with the cache; none of it may stop a run."""

from graphtex.errors import GraphtexError


class CacheUnavailable(GraphtexError):
    """The cache's folder cannot be written: read-only, full, not a folder. Run on without it, with one warning."""


class EntryLost(GraphtexError):
    """A stored value cannot be had any more: compute it again."""


class MissingEntry(EntryLost):
    """The store does not hold the value: evicted, or never stored."""


class DamagedEntry(EntryLost):
    """The stored bytes are not those that were stored; the entry has been removed."""


class NoSource(GraphtexError):
    """A function has no source file (typed at a prompt, made by `exec`): run its node without the cache."""


class BadSource(GraphtexError):
    """A source file that a node depends on cannot be parsed; the message has file and line."""
