"""When a spliced pair counts as sound."""

import numpy as np
import pytest

from benchmarks.pairs import PAIRS, PHOTOGRAPHS, Outcome, figures

GOOD = Outcome("F=d", False, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, np.ones((2, 2, 3), np.float32))


@pytest.mark.parametrize(
    ("change", "sound"),
    [
        ({}, True),
        ({"cut": 0.2}, False),
        ({"cut": 0.2, "fidelity": 0.5, "tag": "B=c"}, True),  # its elements may be deformed
        ({"unlike": 2.0}, True),  # elements farther apart leave more ground
        ({"unlike": 2.0, "tag": "B=c"}, False),
        ({"bent": 0.5, "tag": "B=c"}, False),  # squashed
        ({"empty": 0.5}, False),
        ({"holes": 0.5}, False),
        ({"doubtful": True}, False),
    ],
)
def test_sound(change, sound):
    assert GOOD._replace(**change).sound == sound


def test_pairs_are_of_photographs_that_are_known():
    assert {name for pair in PAIRS for name in pair} <= set(PHOTOGRAPHS)


def test_a_folder_without_the_pictures(tmp_path, capsys):
    assert list(figures(None, tmp_path)) == []
    assert list(figures(None, None)) == []
    told = capsys.readouterr().err
    assert "elements-coins.png" in told
    assert "expected --textures" in told
