import numpy as np

from graphtex_nodes.numerics.sources import coherence, coverage, replay, source_map


def test_coherence_by_hand():
    """Two rows of two: the left column continues downwards, nothing else does."""
    source = np.array([[[0, 0], [5, 5]], [[1, 0], [9, 9]]])
    assert coherence(source) == 1 / 4
    assert coherence(np.zeros((1, 1, 2), int)) == 1
    assert coherence(np.stack(np.mgrid[:4, :5], axis=-1)) == 1


def test_coverage_counts_pixels_once():
    assert coverage(np.array([[[0, 0], [0, 0], [1, 2]]]), (2, 3)) == 2 / 6


def test_replay():
    exemplar = np.arange(12, dtype=np.float32).reshape(3, 4, 1)
    source = source_map(np.array([[[2, 3], [0, 1]]]))
    assert source.shape == (1, 2, 6)
    assert source.dtype == np.float32
    assert replay(source, exemplar)[..., 0].tolist() == [[11, 1]]
