"""A run as one JSON object."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graphtex.run import RunResult


def run_object(
    result: "RunResult", written: Mapping[str, Sequence[Path]], seed: int, seconds: float, *, done: bool
) -> dict[str, Any]:
    """Return outputs, what became of each node, and totals, as plain data."""
    from graphtex.shipped import graph_identity

    nodes = []
    for task in result.plan.tasks:
        report = result.reports.get(task)
        if report is None:
            continue
        nodes.append(
            {
                "id": task,
                "node": report.task.node.name,
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
            **{status: counts[status] for status in ("ran", "cached", "failed", "skipped")},
            "seconds": round(seconds, 6),
        },
    }
