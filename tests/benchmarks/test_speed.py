"""The race runs in processes of its own; here only what needs no clock."""

from benchmarks import speed


def test_times_leave_the_first_call_out():
    ticks = iter([0, 100, 100, 103, 103, 104, 104, 109, 109, 111, 111, 118])  # 100 to compile, then 3 1 5 2 7
    seeds = []
    found = speed._times({"tool": seeds.append}, lambda: next(ticks))
    assert found == {"tool": [3, 1, 5, 2, 7]}
    assert seeds == [0, 1, 2, 3, 4, 5]


def test_measure_reads_the_last_line(monkeypatch):
    class Done:
        stdout = 'chatter\n{"default": 1.5}\n'

    seen = {}

    def run(command, env, **options):
        seen.update(command=command, env=env)
        return Done

    monkeypatch.setattr(speed.subprocess, "run", run)
    assert speed.measure("clock", 2, EXTRA="x") == {"default": 1.5}
    assert seen["command"][-2:] == ["clock", "2"]
    assert (seen["env"]["OMP_NUM_THREADS"], seen["env"]["EXTRA"]) == ("1", "x")
