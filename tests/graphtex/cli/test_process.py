"""The command in a process of its own: statuses, signals, pipes."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.graphtex.cli.conftest import Process

SLOW = """\
graphtex: 1
nodes:
  base: {node: Flat}
  long: {node: Slow, image: base, seconds: 60}
outputs:
  image: {from: long, file: image.num}
"""


def start(environment: dict[str, str], folder: Path, *words: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "graphtex", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment, cwd=folder,
    )  # fmt: skip


def wait_for(process: "subprocess.Popen[str]", text: str) -> None:
    assert process.stderr is not None
    for line in process.stderr:
        if text in line:
            return
    raise AssertionError(f"{text!r} was never told")


def test_exit_statuses_and_streams(process: Process, small: Path) -> None:
    done = process("run", "small.yaml", "--json")
    assert done.status == 0, done.err
    assert json.loads(done.out)["totals"]["ran"] == 3
    assert process("run", "small.yaml", "--set", "value=9").status == 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_run_and_what_finished_is_cached(
    environment: dict[str, str], process: Process, folder: Path, number: signal.Signals
) -> None:
    (folder / "slow.yaml").write_text(SLOW)
    running = start(environment, folder, "run", "slow.yaml", "--json")
    wait_for(running, "long: Slow runs")
    running.send_signal(number)
    out, err = running.communicate(timeout=30)
    assert running.returncode == 130
    assert err.splitlines()[-1] == "interrupted; finished nodes are cached"
    stopped = json.loads(out)
    assert (stopped["status"], stopped["outputs"], stopped["totals"]["ran"]) == ("interrupted", {}, 1)
    assert [node["status"] for node in stopped["nodes"]] == ["ran", "waiting"]
    forecast = json.loads(process("run", "slow.yaml", "--dry-run", "--json").out)["nodes"]
    assert [node["forecast"] for node in forecast] == ["cached", "runs"]


def test_a_second_ctrl_c_ends_at_once(environment: dict[str, str], folder: Path) -> None:
    (folder / "slow.yaml").write_text(SLOW.replace("node: Slow", "node: Deaf"))
    running = start(environment, folder, "run", "slow.yaml", "--no-cache")
    wait_for(running, "long: Deaf runs")
    time.sleep(0.1)
    running.send_signal(signal.SIGINT)
    wait_for(running, "press Ctrl-C again")
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=30)  # the node would go on for a minute
    assert running.returncode == 130


def test_a_reader_that_goes_away_is_no_error(environment: dict[str, str], folder: Path) -> None:
    running = start(environment, folder, "schema")
    assert running.stdout is not None
    assert running.stderr is not None
    running.stdout.close()
    assert running.stderr.read() == ""
    running.stderr.close()
    assert running.wait(timeout=60) in (0, 141)


def test_a_letter_that_the_terminal_has_not_ends_nothing(
    environment: dict[str, str], process: Process, small: Path
) -> None:
    environment["PYTHONIOENCODING"] = "ascii"
    done = process("run", "small.yaml", "--out", "bögen", "--quiet")
    assert (done.status, done.err) == (0, "")
    assert done.out.splitlines()[0] == r"b\xf6gen/image.num"
    assert Path("bögen/image.num").is_file()
