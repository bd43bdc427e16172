"""Plans: what is needed for which outputs, cells of products, random streams."""

import hashlib

import numpy as np
import pytest

from graphtex import Graph, Image
from graphtex.bind import bind
from graphtex.plan import Slot, cells_of, stream_words
from tests.graphtex import tiny
from tests.graphtex.tiny import picture

pytestmark = pytest.mark.usefixtures("tiny_nodes")


def two_ways() -> Graph:
    g = Graph(seed=3)
    left, right = g.input("left", Image), g.input("right", Image)
    low = g.add(tiny.add, "low", image=left)
    g.add(tiny.add, "unused", image=low)
    high = g.add(tiny.grain, "high", image=right)
    g.output("low", low)
    g.output("both", g.add(tiny.both, image=low, mask=high))
    return g


def test_the_dag_has_an_edge_for_each_task_that_is_read():
    plan = bind(two_ways(), {"left": picture(1), "right": picture(2)})
    assert sorted(plan.dag.edges) == [("high", "both"), ("low", "both"), ("low", "unused")]
    assert list(plan.dag) == list(plan.tasks) == ["low", "unused", "high", "both"]


def test_only_keeps_what_outputs_need():
    plan = bind(two_ways(), {"left": picture(1), "right": picture(2)})
    cut = plan.only({"low": plan.outputs["low"]})
    assert list(cut.tasks) == ["low"]
    assert list(cut.given) == [Slot("$left", "value")]
    assert list(plan.only(dict(plan.outputs)).tasks) == ["low", "high", "both"]


def test_an_output_may_be_an_input():
    g = Graph()
    g.output("same", g.input("picture", Image))
    g.add(tiny.const)
    plan = bind(g, {"picture": picture(1)})
    cut = plan.only(dict(plan.outputs))
    assert cut.tasks == {}
    assert list(cut.given) == [Slot("$picture", "value")]


def test_cells_are_the_product_with_the_last_range_fastest():
    assert [index for index, _ in cells_of({"a": [1, 2], "b": [3, 4]})] == ["[0,0]", "[0,1]", "[1,0]", "[1,1]"]
    assert [choice for _, choice in cells_of({"a": [1, 2], "b": [3]})] == [{"a": 1, "b": 3}, {"a": 2, "b": 3}]
    assert cells_of({"a": []}) == []


def test_stream_words_are_those_of_sha_256_of_the_id_without_indices():
    expected = hashlib.sha256(b"cell/warp").digest()
    assert stream_words("cell[2,3]/warp") == tuple(int.from_bytes(expected[i : i + 4], "big") for i in range(0, 32, 4))
    assert stream_words("cell[10]/warp[1,2]") == stream_words("cell/warp")
    assert stream_words("cell2/warp") != stream_words("cell/warp")


def test_the_stream_is_numpy_s_seed_sequence_of_seed_and_id():
    task = bind(two_ways(), {"left": picture(1), "right": picture(2)}).tasks["high"]
    sequence = np.random.SeedSequence(3, spawn_key=stream_words("high"))
    assert task.generator().random() == np.random.default_rng(sequence).random()
    assert task.entropy == (3, *stream_words("high"))


def test_only_a_node_that_draws_numbers_has_entropy():
    assert bind(two_ways(), {"left": picture(1), "right": picture(2)}).tasks["low"].entropy is None
