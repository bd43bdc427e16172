import dataclasses
import importlib.metadata
import json
import math
import platform
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphtex.cache import CodeDigest, KeyParts, canonical_json, environment, explain

BASE = KeyParts(
    format=1,
    node="FeatureMask",
    version=1,
    code=CodeDigest.of({"pack.masks": "1" * 64, "pack.helper": "2" * 64}, ["numpy"]),
    params={"window": 16, "method": "ridges", "strokes": {"radius": 2.0, "lines": [[0, 1], [2, 3]]}},
    inputs={"image": "a" * 64, "layers": ["b" * 64, "c" * 64]},
    entropy=(7, 123),
    environment={"numpy": "2.4.6", "machine": "x86_64"},
)


def but(**changed):
    return dataclasses.replace(BASE, **changed)


def changes(new, old=BASE):
    return [str(change) for change in explain(old, new)]


def params(**changed):
    return but(params={**BASE.params, **changed})


def test_equal_parts_equal_key():
    """Order of parameters and inputs, and tuples for lists, do not count."""
    twin = but(params=dict(reversed(BASE.params.items())), inputs=dict(reversed(BASE.inputs.items())), entropy=(7, 123))
    assert twin.key() == BASE.key()
    assert params(strokes={"lines": ((0, 1), (2, 3)), "radius": 2.0}).key() == BASE.key()
    assert len(BASE.key()) == 64
    assert explain(BASE, twin) == []


@pytest.mark.parametrize(
    ("new", "told"),
    [
        (but(format=2), "format of graphtex: 1 -> 2"),
        (but(node="Masks"), "node: FeatureMask -> Masks"),
        (but(version=3), "version of FeatureMask: 1 -> 3"),
        (params(window=32), "parameter window: 16 -> 32"),
        (params(window=16.0), "parameter window: 16 -> 16.0"),
        (params(window="16"), "parameter window: 16 -> 16"),
        (params(window=True), "parameter window: 16 -> true"),
        (params(window=math.nan), "parameter window: 16 -> NaN"),
        (params(clip=None), "parameter clip: (absent) -> null"),
        (params(strokes={"radius": 3.0, "lines": [[0, 1], [2, 3]]}), "parameter strokes.radius: 2.0 -> 3.0"),
        (params(strokes={"radius": 2.0, "lines": []}), "parameter strokes.lines: [[0,1],[2,3]] -> []"),
        (but(inputs={**BASE.inputs, "image": "d" * 64}), "input image has changed"),
        (but(inputs={**BASE.inputs, "layers": ["b" * 64, "d" * 64]}), "input layers[1] has changed"),
        (but(inputs={**BASE.inputs, "layers": ["b" * 64]}), "input layers: 2 values -> 1 values"),
        (but(inputs={"layers": BASE.inputs["layers"]}), "input image: (present) -> (absent)"),
        (but(entropy=(8, 123)), "random stream (seed): [7,123] -> [8,123]"),
        (but(entropy=None), "random stream (seed): [7,123] -> null"),
        (but(environment={"numpy": "2.5.0", "machine": "x86_64"}), "numpy: 2.4.6 -> 2.5.0"),
        (
            but(code=CodeDigest.of({"pack.masks": "1" * 64, "pack.helper": "3" * 64})),
            "code of pack.helper has changed",
        ),
        (but(code=CodeDigest.of({"pack.masks": "1" * 64})), "code of pack.helper: (present) -> (absent)"),
    ],
)
def test_each_change_makes_another_key_and_is_told(new, told):
    assert new.key() != BASE.key()
    assert changes(new) == [told]


def test_a_file_is_told_by_its_content():
    old, new = params(path="a" * 64, texts={"b": "1" * 64}), params(path="b" * 64, texts={"b": "2" * 64})
    assert [str(change) for change in explain(old, new)] == [
        "content of parameter path has changed",
        "content of parameter texts.b has changed",
    ]


def test_several_changes_are_told_in_order():
    new = dataclasses.replace(params(window=32), entropy=None, version=2)
    assert [change.what for change in explain(BASE, new)] == [
        "version of FeatureMask",
        "parameter window",
        "random stream (seed)",
    ]


def test_long_values_are_cut():
    assert len(changes(params(method="x" * 500))[0]) < 100


def test_json_round_trip():
    back = KeyParts.from_json(json.loads(json.dumps(BASE.to_json())))
    assert back == BASE
    assert back.key() == BASE.key()


def test_parameters_that_are_no_json():
    with pytest.raises(TypeError, match="canonical JSON"):
        params(window={1: 2}).key()


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-3, 3)
    | st.sampled_from([0.0, -0.0, 1.0, math.nan, math.inf])
    | st.text(max_size=2),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.sampled_from("abc"), inner, max_size=2),
    max_leaves=4,
)


@settings(deadline=None, max_examples=300)
@given(old=st.dictionaries(st.sampled_from("abc"), VALUES), new=st.dictionaries(st.sampled_from("abc"), VALUES))
def test_something_is_told_if_and_only_if_keys_differ(old, new):
    """And keys differ if and only if the canonical JSON of the parameters does."""
    a, b = but(params=old), but(params=new)
    assert (explain(a, b) == []) == (a.key() == b.key()) == (canonical_json(old) == canonical_json(new))
    assert KeyParts.from_json(json.loads(canonical_json(a.to_json()))).key() == a.key()


def test_environment():
    found = environment()
    assert found["numpy"] == importlib.metadata.version("numpy")
    assert found["machine"] == platform.machine()
    assert found["python"] == ".".join(platform.python_version_tuple()[:2])
    assert "no-such-package" not in found


def test_environment_of_other_packages():
    """By import name, whatever the distribution is called; a folder without a version still counts."""
    found = environment(("hypothesis", "no_such_package", "skimage"))
    assert found["hypothesis"] == importlib.metadata.version("hypothesis")
    assert found["no_such_package"] == "unknown"
    assert found["scikit-image"] == importlib.metadata.version("scikit-image")
    assert "skimage" not in found


def test_the_cache_imports_nothing_heavy():
    heavy = "{'scipy', 'numba', 'pydantic', 'skimage', 'PIL', 'OpenImageIO', 'graphtex_nodes'}"
    code = f"import sys, graphtex.sockets\nbefore = set(sys.modules)\nimport graphtex.cache\n" \
           f"print(sorted({heavy} & (set(sys.modules) - before)))"  # fmt: skip
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
