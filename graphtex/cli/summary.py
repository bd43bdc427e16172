"""A run, or why there is none, as one JSON object."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphtex.cli.tally import ENDS
from graphtex.errors import Problem

if TYPE_CHECKING:
    from graphtex.cli.tally import Tally
    from graphtex.document import Document
    from graphtex.run import RunResult


def run_object(
    result: "RunResult", written: Mapping[str, Sequence[Path]], seed: int, seconds: float, *, done: bool
) -> dict[str, Any]:
    """Return outputs, what became of each node, and totals, as plain data."""
    from graphtex.shipped import graph_identity

    nodes: list[dict[str, Any]] = []
    for name, task in result.plan.tasks.items():
        report = result.reports.get(name)
        if report is None:
            nodes.append({"id": name, "node": task.node.name, "status": "waiting"})
            continue
        nodes.append(
            {
                "id": name,
                "node": task.node.name,
                "status": report.status,
                "seconds": round(report.seconds, 6),
                "key": report.key,
                "why": report.why,
                "warnings": list(report.warnings),
                **({"message": report.message} if report.message else {}),
            }
        )
    counts = Counter(node["status"] for node in nodes)
    return {
        "graph": graph_identity(result.plan.graph.file),
        "seed": seed,
        "status": "done" if done else "failed",
        "outputs": {output: [str(path) for path in paths] for output, paths in written.items()},
        "nodes": nodes,
        "totals": {
            "nodes": len(result.plan.tasks),
            **{status: counts[status] for status in (*ENDS, "waiting")},
            "seconds": round(seconds, 6),
        },
    }


def stopped_object(graph: "Document", seed: int, tally: "Tally") -> dict[str, Any]:
    """Return what had ended when a run was stopped, as plain data."""
    from graphtex.shipped import graph_identity

    return {
        "graph": graph_identity(graph.file),
        "seed": seed,
        "status": "interrupted",
        "outputs": {},
        "nodes": [
            {"id": task, "node": node, "status": tally.ended.get(task, "waiting")} for task, node in tally.nodes.items()
        ],
        "totals": {
            "nodes": len(tally.nodes),
            **{status: tally.number(status) for status in ENDS},
            "waiting": len(tally.nodes) - len(tally.ended),
            "seconds": round(tally.seconds, 6),
        },
    }


def error_object(status: str, problems: Iterable[Problem]) -> dict[str, Any]:
    """Return why a command gave nothing, as plain data: ``wrong``, ``failed`` or ``interrupted``, and each problem."""
    return {"status": status, "problems": [asdict(problem) for problem in problems]}
