"""The content-addressed cache: digests of values and of code, keys, and a store that processes share.

A node's result is known by its key, see `KeyParts`: the index maps a key to the digests of outputs, the store maps a
digest to bytes. Equal inputs that were reached in another way are hits, and an unchanged output cuts off what follows.

Typical use, as the scheduler does it::

    cache = Cache()                                       # or Cache("folder", "20 GiB")
    with cache.session():                                 # CacheUnavailable: go on without
        parts = KeyParts(format=1, node="FeatureMask", version=1, code=code_digest(function), params={...},
                         inputs={"image": digest}, entropy=None, environment=environment(code.packages))
        record = cache.lookup(parts.key())
        if record is None:
            outputs = {"mask": Output("Mask", cache.put("Mask", mask))}
            cache.record(parts.key(), node="FeatureMask", outputs=outputs, seconds=0.2)
        else:
            mask = cache.get("Mask", record.outputs["mask"].digest)  # EntryLost: compute again
        cache.record_run("/home/me/graph.yaml", {"mask": parts})

Nothing here imports scipy, numba, pydantic or any module of nodes.
"""

from graphtex.cache.code import code_digest, module_digest
from graphtex.cache.digest import canonical_json, digest_value, file_digest, files_below
from graphtex.cache.errors import BadSource, CacheUnavailable, DamagedEntry, EntryLost, MissingEntry, NoSource
from graphtex.cache.eviction import Pruned, parse_size
from graphtex.cache.facade import Cache, Info, Session, Verified, base_directory
from graphtex.cache.index import Output, Record
from graphtex.cache.key import Change, CodeDigest, KeyParts, environment, explain

__all__ = [
    "BadSource",
    "Cache",
    "CacheUnavailable",
    "Change",
    "CodeDigest",
    "DamagedEntry",
    "EntryLost",
    "Info",
    "KeyParts",
    "MissingEntry",
    "NoSource",
    "Output",
    "Pruned",
    "Record",
    "Session",
    "Verified",
    "base_directory",
    "canonical_json",
    "code_digest",
    "digest_value",
    "environment",
    "explain",
    "file_digest",
    "files_below",
    "module_digest",
    "parse_size",
]
