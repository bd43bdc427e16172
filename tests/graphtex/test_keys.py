"""What a task's key is made of, and what a dry run foretells."""

import importlib
import sys
from dataclasses import replace

import pytest

from graphtex import Gap, Graph, run
from graphtex.bind import bind
from graphtex.cache import Cache
from graphtex.graph import loads
from graphtex.keys import Keys, forecast, given_values
from graphtex.packs import Registry, nodes_of
from graphtex.plan import Slot
from graphtex.sockets import TYPES, ValueType
from graphtex.work import Held
from tests.graphtex import tiny
from tests.graphtex.tiny import CALLS, picture

pytestmark = pytest.mark.usefixtures("tiny_nodes")


def key_of(text: str, task: str = "a", held: dict | None = None, **inputs) -> str:
    plan = bind(loads(f"graphtex: 1\n{text}\noutputs: {{out: a}}\n"), inputs)
    values = {**given_values(plan, digests=True), **(held or {})}
    return Keys().parts(plan.tasks[task], values).key()


def held(digest: str) -> Held:
    return Held(ValueType(TYPES["Image"]), None, digest, in_memory=False)


ONE = {Slot("one", "result"): held("1" * 64)}


def test_a_key_covers_node_parameters_and_inputs():
    keys = [
        key_of("nodes: {a: {node: Const}}"),
        key_of("nodes: {a: {node: Const, value: 1}}"),
        key_of("nodes: {a: {node: Grain}}"),
        key_of("nodes: {one: {node: Const}, a: {node: Add, image: one}}", held=ONE),
        key_of("nodes: {one: {node: Const}, a: {node: Add, image: one}}", held={Slot("one", "result"): held("2" * 64)}),
        key_of("nodes: {one: {node: Const}, a: {node: Whole, image: one}}", held=ONE),
    ]
    assert len(set(keys)) == len(keys)


def test_a_key_does_not_tell_apart_what_means_the_same():
    assert key_of("nodes: {a: {node: Const}}") == key_of(
        "nodes: {b: {node: Const}, a: {node: Const, value: 0.0, size: 2}}"
    )
    assert key_of("title: x\nseed: 5\nnodes: {a: {node: Const}}") == key_of("nodes: {a: {node: Const}}")
    given = key_of("inputs: {p: {type: Image}}\nnodes: {a: {node: Add, image: $p}}", p=picture(1, 2))
    assert given == key_of(
        "inputs: {q: {type: Image}}\nnodes: {a: {node: Add, image: $q}}", q=picture(1, 2).astype(float)
    )


def test_only_a_node_that_draws_numbers_depends_on_seed_and_id():
    grain = key_of("nodes: {a: {node: Grain}}")
    assert grain != key_of("seed: 1\nnodes: {a: {node: Grain}}")
    assert grain != key_of("nodes: {a: {node: Const}, b: {node: Grain}}", "b")
    assert key_of("nodes: {a: {node: Grain, seed: 1}}") != key_of("nodes: {a: {node: Grain, seed: 2}}")
    both = "nodes: {a: {node: Grain, seed: 4}, b: {node: Grain, seed: 4}}"
    assert key_of(both) == key_of("seed: 9\n" + both) == key_of(both, "b")


def test_a_measured_parameter_counts_by_its_digest():
    text = "nodes: {one: {node: Const}, m: {node: Average, image: one}, a: {node: Const, value: {from: m}}}"
    keys = {key_of(text, held={Slot("m", "result"): held(digit * 64)}) for digit in "12"}
    assert len(keys | {key_of("nodes: {a: {node: Const}}")}) == 3


def test_a_gap_counts_with_what_it_says():
    text = "nodes: {c: {node: Fragile, each: {value: [0]}, on_error: keep}, a: {node: Survey, cells: c}}"
    slot = Slot("c[0]", "result")
    keys = [
        key_of(text, held={slot: gap})
        for gap in (Gap("c[0]", "x"), Gap("c[0]", "y"), Gap("c[1]", "x"), Gap("c[0]", "x"))
    ]
    assert len(set(keys)) == 3
    assert keys[0] == keys[3]


def test_a_file_counts_by_its_content_and_not_by_its_name(tmp_path):
    for name, text in (("a.txt", "1"), ("b.txt", "1"), ("c.txt", "2")):
        (tmp_path / name).write_text(text)
    keys = [key_of(f"nodes: {{a: {{node: Read, path: {tmp_path / name}.txt}}}}") for name in "abc"]
    assert keys[0] == keys[1] != keys[2]


def test_a_file_that_is_gone_gives_no_key(tmp_path):
    (tmp_path / "a.txt").write_text("1")
    plan = bind(loads(f"graphtex: 1\nnodes: {{a: {{node: Read, path: {tmp_path}/a.txt}}}}\noutputs: {{out: a}}\n"))
    (tmp_path / "a.txt").unlink()
    assert Keys().parts(plan.tasks["a"], {}) is None


def test_a_file_that_changed_since_its_digest_no_longer_holds(tmp_path):
    (tmp_path / "a.txt").write_text("1")
    plan = bind(loads(f"graphtex: 1\nnodes: {{a: {{node: Read, path: {tmp_path}/a.txt}}}}\noutputs: {{out: a}}\n"))
    keys = Keys()
    keys.parts(plan.tasks["a"], {})
    assert keys.still_hold(plan.tasks["a"])
    (tmp_path / "a.txt").write_text("22")
    assert not keys.still_hold(plan.tasks["a"])


HELPER = "# a comment\nOFFSET = {offset}\n\ndef shift(image):\n    return image + OFFSET\n"
PACK = '''
from graphtex import Image, node
@node
def shifted(image: Image) -> Image:
    """Shift."""
    from helped_pack.deep.helper import shift
    return shift(image)
@node
def straight(image: Image) -> Image:
    """Copy."""
    return image * 1
'''


@pytest.fixture
def helped(tmp_path, monkeypatch):
    """A pack whose node uses a helper lazily; call it with the helper's text, and it is imported anew."""
    folder = tmp_path / "helped_pack"
    (folder / "deep").mkdir(parents=True)
    for name, text in (
        ("__init__", ""),
        ("one", PACK),
        ("two", PACK.split("@node")[0] + "@node" + PACK.split("@node")[2]),
        ("deep/__init__", ""),
    ):
        (folder / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)

    def write(text: str) -> dict:
        for name in [name for name in sys.modules if name.partition(".")[0] == "helped_pack"]:
            monkeypatch.delitem(sys.modules, name)
        (folder / "deep" / "helper.py").write_text(text)
        importlib.invalidate_caches()
        monkeypatch.setattr(sys, "dont_write_bytecode", True)
        nodes = nodes_of(importlib.import_module("helped_pack.one")) | nodes_of(
            importlib.import_module("helped_pack.two")
        )
        own = {**nodes, **nodes_of(tiny)}
        monkeypatch.setattr("graphtex.links.registry", lambda: Registry(own, dict.fromkeys(own, "x"), ()))
        return nodes

    return write


CHAIN = """graphtex: 1
nodes:
  one: {node: Const, value: 3}
  a: {node: Shifted, image: one}
  b: {node: Straight, image: one}
  c: {node: Whole, image: a}
outputs: {a: a, b: b, c: c}
"""


def test_a_changed_constant_in_a_helper_reruns_its_users_and_a_comment_nothing(helped, tmp_path):
    def ran(text: str):
        helped(text)
        result = run(loads(CHAIN), cache=tmp_path / "cache")
        return [task for task, report in result.reports.items() if report.status == "ran"], float(result["a"][0, 0, 0])

    assert ran(HELPER.format(offset=0.5)) == (["one", "a", "b", "c"], 3.5)
    assert ran(HELPER.format(offset=0.5)) == ([], 3.5)
    assert ran(HELPER.format(offset=0.5).replace("a comment", "another")) == ([], 3.5)
    assert ran(HELPER.format(offset=1.5)) == (["a", "c"], 4.5)
    assert ran(HELPER.format(offset=0.5)) == ([], 3.5)


def test_a_helper_that_cannot_be_parsed_is_warned_of_and_its_users_run_without_the_cache(helped, tmp_path):
    helped("def (")
    told = []
    g = loads(CHAIN.replace("outputs: {a: a, b: b, c: c}", "outputs: {b: b}"))
    run(g, cache=tmp_path / "cache", emit=told.append)
    run(g, cache=tmp_path / "cache", emit=told.append)
    assert [type(event).__name__ for event in told if event.task == "b"].count("Started") == 1
    parts = Keys(told.append).parts(bind(loads(CHAIN)).tasks["a"], {Slot("one", "result"): held("1" * 64)})
    assert parts is None
    assert "Shifted runs without the cache: " in told[-1]
    assert "helper.py:1: " in told[-1]


FORECAST = """graphtex: 1
inputs: {by: {type: float, default: 1}}
nodes:
  one: {node: Const, value: $by}
  same: {node: Const, value: $by}
  low: {node: Whole, image: one}
  up: {node: Add, image: low, amount: 1}
  other: {node: Grain}
outputs: {up: up, other: other, same: same}
"""


def foretold(g: Graph, cache: Cache, **inputs) -> dict[str, str]:
    return forecast(bind(g, inputs), cache)[0]


def came(g: Graph, cache: Cache, **inputs) -> dict[str, str]:
    return {task: report.status for task, report in run(g, inputs, cache=cache).reports.items()}


def test_the_forecast_is_what_then_happens(tmp_path):
    g, cache = loads(FORECAST), Cache(tmp_path)
    assert foretold(g, cache) == {"one": "runs", "same": "cached", "low": "maybe", "up": "maybe", "other": "runs"}
    assert came(g, cache) == {"one": "ran", "same": "cached", "low": "ran", "up": "ran", "other": "ran"}
    assert set(foretold(g, cache).values()) == {"cached"}
    assert set(came(g, cache).values()) == {"cached"}
    changed = {"by": 1.5}
    assert foretold(g, cache, **changed) == {
        "one": "runs",
        "same": "cached",
        "low": "maybe",
        "up": "maybe",
        "other": "cached",
    }
    assert came(g, cache, **changed) == {
        "one": "ran",
        "same": "cached",
        "low": "ran",
        "up": "cached",
        "other": "cached",
    }


def test_a_forecast_runs_nothing_and_tells_of_inputs_that_are_not_known_yet(tmp_path):
    told, parts = forecast(bind(loads(FORECAST)), Cache(tmp_path))
    assert CALLS == []
    assert parts["low"].inputs == {"image": ""}
    assert len(parts["one"].key()) == 64
    assert set(told) == set(parts)


def test_without_a_cache_all_runs():
    assert set(forecast(bind(loads(FORECAST)), None)[0].values()) == {"runs"}


def test_a_record_of_other_outputs_is_not_used(tmp_path):
    g, cache = loads(FORECAST), Cache(tmp_path)
    run(g, cache=cache)
    plan = bind(g)
    renamed = {name: replace(socket, type=ValueType(TYPES["Mask"])) for name, socket in tiny.const.outputs.items()}
    node = replace(tiny.const, outputs=renamed)
    told = forecast(replace(plan, tasks={"one": replace(plan.tasks["one"], node=node)}), cache)[0]
    assert told == {"one": "runs"}
