import os
import threading
import time
from functools import partial

import numpy as np
import pytest

from graphtex_nodes.numerics import parallel


class Watch:
    """Counts checks and raises at a given one."""

    def __init__(self, threads=1, stop_at=None):
        self.threads = threads
        self.stop_at = stop_at
        self.checks = 0
        self.caller = threading.get_ident()

    def check(self):
        assert threading.get_ident() == self.caller
        self.checks += 1
        if self.checks == self.stop_at:
            raise KeyboardInterrupt


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("cost", [1.0, 1e7, 1e12])
def test_each_row_once(threads, cost):
    seen = np.zeros(37, int)

    def task(first, stop):
        seen[first:stop] += 1

    parallel.for_rows(task, 37, cost, Watch(threads))
    assert (seen == 1).all()


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("rows", [0, 1, 2, 40])
@pytest.mark.parametrize("lead", [0.0, 0.4, 1.0])
def test_work_begun_is_finished_whoever_does_it(threads, rows, lead):
    seen = np.zeros(rows, int)

    def task(first, stop):
        seen[first:stop] += 1

    with parallel.begun_rows(task, rows, 1e7, Watch(threads), lead) as finish:
        time.sleep(0.002)
        finish()
    assert (seen == 1).all()


@pytest.mark.parametrize("threads", [1, 2])
def test_cancelling_stops_between_bands(threads):
    seen = np.zeros(50, int)

    def task(first, stop):
        seen[first:stop] += 1

    with pytest.raises(KeyboardInterrupt):
        parallel.for_rows(task, 50, 1e12, Watch(threads, stop_at=5))
    assert 0 < seen.sum() < 50


@pytest.mark.parametrize("threads", [1, 2])
def test_failure_of_a_band_is_raised(threads):
    def task(first, stop):
        if first >= 5:
            raise ArithmeticError("band")

    with pytest.raises(ArithmeticError):
        parallel.for_rows(task, 50, 1e12, Watch(threads))


@pytest.mark.parametrize("threads", [1, 2])
def test_each_number_once(threads):
    seen = np.zeros(7, int)

    def task(number):
        seen[number] += number

    parallel.for_each(task, 7, 1e7, Watch(threads))
    assert seen.tolist() == list(range(7))


def test_no_rows():
    parallel.for_rows(lambda first, stop: pytest.fail("called"), 0, 1.0, Watch(2))


def test_threads_stay_for_the_next_call():
    seen = set()

    def task(first, stop):
        seen.add(threading.get_ident())

    before = threading.active_count()
    for _ in range(20):
        parallel.for_rows(task, 64, 1e7, Watch(2))
    assert threading.active_count() <= before + max(1, (os.cpu_count() or 2) - 1)
    assert len(seen) <= max(2, os.cpu_count() or 2)


def test_calls_inside_a_band_and_from_many_threads_end():
    total = np.zeros((4, 8, 16), int)

    def add(number, row, low, high):
        total[number, row, low:high] += 1

    def outer(number):
        def task(first, stop):
            for row in range(first, stop):
                parallel.for_rows(partial(add, number, row), 16, 1e7, Watch(2))

        parallel.for_rows(task, 8, 1e8, Watch(2))

    callers = [threading.Thread(target=outer, args=(number,)) for number in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(timeout=30)
    assert (total == 1).all()


def test_nothing_is_written_after_the_call():
    running = threading.Event()

    def task(first, stop):
        running.set()
        time.sleep(0.05)
        running.clear()

    with pytest.raises(KeyboardInterrupt):
        parallel.for_rows(task, 50, 1e12, Watch(2, stop_at=2))
    assert not running.is_set()


@pytest.mark.parametrize("threads", [1, 2])
def test_aside_gives_what_the_task_gives(threads):
    results = [parallel.aside(partial(pow, 2, number), Watch(threads)) for number in range(40)]
    assert [result() for result in results] == [2**number for number in range(40)]
    with pytest.raises(ZeroDivisionError):
        parallel.aside(lambda: 1 // 0, Watch(threads))()


def test_aside_runs_beside_the_caller():
    started, go_on = threading.Event(), threading.Event()

    def task():
        started.set()
        return go_on.wait(30)

    result = parallel.aside(task, Watch(2))
    assert started.wait(30)
    go_on.set()
    assert result()
