"""Several processes on one store: some compute and read back, one evicts all it can meanwhile."""

import multiprocessing

import numpy as np

from graphtex.cache import Cache, EntryLost, Output
from tests.graphtex.cache.helpers import key

ROUNDS = 60


def value_of(n: int) -> np.ndarray:
    return np.random.default_rng(n).integers(0, 255, (20, 1000)).astype(np.uint8)


def work(directory, seed, results):
    """Look up, compute what is missing, and read back what this run has touched: it must all be there."""
    rng = np.random.default_rng(seed)
    cache = Cache(directory, "100 kB")  # five values: prunes all the time by itself
    lost = hits = 0
    with cache.session():
        touched = {}
        for _ in range(ROUNDS):
            n = int(rng.integers(0, 12))
            found = cache.lookup(key(n))
            hits += found is not None
            if found is None:
                digest = cache.put("list[Map]", [value_of(n), value_of(n + 1)])
                found = cache.record(key(n), "Node", {"out": Output("list[Map]", digest)}, 0.1)
            touched[n] = found
            again = int(rng.choice(list(touched)))
            try:
                back = cache.load(touched[again])["out"]
            except EntryLost:
                lost += 1
            else:
                assert np.array_equal(back[0], value_of(again))
                assert np.array_equal(back[1], value_of(again + 1))
    results.put((lost, hits))


def evict(directory, over):
    cache = Cache(directory)
    while not over.is_set():
        cache.prune(0)


def test_writers_and_pruners_share_a_store(tmp_path):
    context = multiprocessing.get_context("spawn")
    results, over = context.Queue(), context.Event()
    workers = [context.Process(target=work, args=(tmp_path, seed, results)) for seed in (1, 2)]
    pruner = context.Process(target=evict, args=(tmp_path, over))
    for process in (*workers, pruner):
        process.start()
    told = [results.get(timeout=120) for _ in workers]
    over.set()
    for process in (*workers, pruner):
        process.join(timeout=60)
        assert process.exitcode == 0
    assert [lost for lost, _ in told] == [0, 0]
    assert sum(hits for _, hits in told) >= 2 * ROUNDS - 2 * 12  # each value is computed once by each at most
    cache = Cache(tmp_path)
    found = cache.verify()
    assert (found.damaged, found.dangling) == ((), ())
    assert list((tmp_path / "tmp").iterdir()) == []
    cache.prune(0)
    assert cache.info().bytes == 0
