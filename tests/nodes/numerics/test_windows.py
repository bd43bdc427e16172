import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics.windows import Basis, Grid, evened, leading_directions, principal_basis

RNG = np.random.default_rng(3)


@pytest.mark.parametrize(("size", "expected"), [((8, 8), (1, 1)), ((9, 12), (2, 3)), ((1, 30), (1, 12))])
def test_grid_covers(size, expected):
    grid = Grid.covering(*size, window=8, step=2)
    assert (grid.rows, grid.columns) == expected
    assert grid.canvas[0] >= size[0]
    assert grid.canvas[1] >= size[1]


@pytest.mark.parametrize("step", [1, 3])
def test_projection_is_a_matrix_product(step):
    """Second method: gather the windows and multiply."""
    image = RNG.random((13, 11, 2)).astype(np.float32)
    directions = RNG.standard_normal((4 * 4 * 2, 6)).astype(np.float32)
    mean = RNG.standard_normal(6).astype(np.float32)
    views = np.lib.stride_tricks.sliding_window_view(image, (4, 4), axis=(0, 1))[::step, ::step]
    windows = np.moveaxis(views, 2, -1).reshape(*views.shape[:2], -1)
    found = Basis(4, directions, mean).project(image, step, Context())
    np.testing.assert_allclose(found, windows @ directions - mean, atol=1e-5)


def test_leading_directions_against_lapack():
    """The kept share of variance is that of the eigenvectors, and no column too many."""
    square = RNG.standard_normal((40, 40)) * np.geomspace(1, 0.01, 40)
    covariance = square.T @ square
    values, vectors = np.linalg.eigh(covariance)
    count = int(np.searchsorted(np.cumsum(values[::-1]) / values.sum(), 0.95)) + 1
    found = leading_directions(covariance, 0.95)
    np.testing.assert_allclose(found.T @ found, np.eye(found.shape[1]), atol=1e-10)
    assert found.shape[1] in (count, count + 1)
    best = values[::-1][: found.shape[1]].sum()
    assert np.trace(found.T @ covariance @ found) > 0.995 * best
    overlap = np.linalg.svd(found.T @ vectors[:, -3:], compute_uv=False)
    assert overlap.min() > 0.99


def test_basis_keeps_distances():
    """With nearly all variance kept, distances between coordinates are those between windows."""
    image = np.cumsum(RNG.standard_normal((30, 30, 3)), axis=1).astype(np.float32)
    basis = principal_basis(image, 4, [(slice(0, 2), 0.0), (slice(2, 3), 0.0)], 0.9999, Context())
    places = basis.project(image, 1, Context())
    true = ((image[2:6, 3:7] - image[20:24, 11:15]) ** 2).sum()
    assert ((places[2, 3] - places[20, 11]) ** 2).sum() == pytest.approx(true, rel=0.02)


def test_large_windows_are_pooled():
    """16 x 16 x 3 is over the limit: coordinates are those of windows whose blocks of 2 x 2 are replaced by their mean."""
    image = RNG.random((40, 41, 3)).astype(np.float32)
    basis = principal_basis(image, 16, [(slice(0, 3), 0.0)], 0.5, Context())
    kept = basis.directions[:, np.abs(basis.directions).sum(axis=0) > 0]
    np.testing.assert_allclose(kept.T @ kept, np.eye(kept.shape[1]), atol=1e-5)
    blocks = image[3:19, 5:21].reshape(8, 2, 8, 2, 3)
    means = blocks.mean(axis=(1, 3), keepdims=True)
    smooth = image.copy()
    smooth[3:19, 5:21] = np.broadcast_to(means, blocks.shape).reshape(16, 16, 3)
    found = basis.project(image, 1, Context())[3, 5]
    np.testing.assert_allclose(found, basis.project(smooth, 1, Context())[3, 5], atol=1e-5)
    np.testing.assert_allclose(found, 2 * means.ravel() @ basis.directions - basis.mean, atol=1e-4)


def test_constant_image():
    basis = principal_basis(np.full((9, 9, 1), 0.5, np.float32), 4, [(slice(0, 1), 0.3)], 0.95, Context())
    assert np.abs(basis.project(np.full((6, 6, 1), 0.5, np.float32), 1, Context())).max() < 1e-6


@pytest.mark.parametrize(("share", "ratio"), [(0.0, 2.0), (0.5, 2**0.5), (1.0, 1.0)])
def test_evened_components(share, ratio):
    """Deviations 2 and 1 keep their ratio, its root, or become equal; the sum of variances stays."""
    covariance = np.diag([4.0, 1.0])
    columns = evened(np.eye(2), covariance, share)
    variances = np.diag(columns.T @ covariance @ columns)
    np.testing.assert_allclose(np.sqrt(variances[0] / variances[1]), ratio)
    np.testing.assert_allclose(variances.sum(), 5)
