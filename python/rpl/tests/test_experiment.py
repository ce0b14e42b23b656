"""Experiments: here, and on a cluster."""

import os
import subprocess
import sys

import pytest

import rpl
from rpl import _experiment

TOSS = '(wait-time (random 10.0)) (when (< (now) 5) (fail "too soon"))'


@pytest.fixture
def toss(tmp_path):
    plan = tmp_path / "toss.rpl"
    plan.write_text(TOSS)
    return plan


def command(folder, *words):
    ended = subprocess.run([sys.executable, "-m", "rpl", *words], cwd=folder, capture_output=True, text=True)
    assert ended.returncode in (0, 1), ended.stderr
    return ended.stdout


def test_an_experiment_is_what_the_command_says(toss):
    found = rpl.experiment(str(toss), seeds=range(3, 23))
    assert found.table == command(toss.parent, "experiment", "toss.rpl", "--runs", "20", "--seed", "3")
    row = found.figures["rows"][0]
    assert list(found.runs.seed) == list(range(3, 23))
    assert int(found.runs.succeeded.sum()) == row["succeeded"]["count"]


def test_shards_are_told_of_as_they_come(toss, monkeypatch):
    # So that parts are put together while others come.
    monkeypatch.setattr(_experiment, "AT_A_TIME", 3)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    told = []
    found = rpl.experiment(str(toss), seeds=40, shard=5, progress=lambda it: told.append((it.done, it.of, it.table())))
    assert [(done, of) for done, of, _ in told] == [(done, 8) for done in range(1, 9)]
    assert all(f"{5 * done} runs" in table for done, _, table in told)
    assert found.table == told[-1][2] == command(toss.parent, "experiment", "toss.rpl", "--runs", "40")


def test_files_that_a_plan_loads_are_sent_along(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "waits.rpl").write_text("(def-plan waits () (wait-time 3))")
    (tmp_path / "plan.rpl").write_text('(load "waits.rpl") (waits)')
    found = rpl.experiment(str(tmp_path / "plan.rpl"), seeds=2, files=[str(tmp_path / "parts" / "waits.rpl")])
    assert found.figures["rows"][0]["succeeded"]["count"] == 2
    with pytest.raises(rpl.CommandError, match="waits.rpl"):
        rpl.experiment(str(tmp_path / "plan.rpl"), seeds=2)


def test_what_is_wrong_is_what_the_command_says(toss):
    with pytest.raises(rpl.CommandError, match="did you mean `rotated`"):
        rpl.experiment("rotatd", seeds=2)
    with pytest.raises(rpl.CommandError, match="no row `undistrbed`; did you mean `undisturbed`"):
        rpl.experiment("rotated", "undistrbed", seeds=2)
    with pytest.raises(ValueError, match="gaps"):
        rpl.experiment(str(toss), seeds=range(1, 9, 2))


def test_a_worker_with_another_build_is_told_of_at_once(toss):
    with pytest.raises(rpl.CommandError, match="install the same on both"):
        _experiment._part("0.0.9, sources 00000000", [str(toss)], _experiment._Files(), 1, 1, 1)


def test_the_command_ends_when_the_process_that_has_started_it_is_gone(tmp_path):
    plan = tmp_path / "endless.rpl"
    plan.write_text("(print 'begun) (loop (wait-time 1))")
    words = [sys.executable, "-m", "rpl._command", "run", str(plan)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as started:
        assert started.stdout.readline() == b"begun\n"
        assert started.poll() is None
        # What the system does with the pipes of a process that is killed.
        started.stdin.close()
        assert started.wait(timeout=60) != 0


def test_a_worker_may_die_and_another_come_and_the_table_is_the_same(toss, monkeypatch):
    # So that tasks are handed in while others run.
    monkeypatch.setattr(_experiment, "AT_A_TIME", 3)
    # A node that is slow to begin is none that is lost.
    monkeypatch.setenv("RAY_raylet_start_wait_time_s", "600")
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    workers = [cluster.add_node(num_cpus=1), cluster.add_node(num_cpus=1)]
    ray.init(address=cluster.address, logging_level="ERROR", log_to_driver=False)

    def disturb(progress):
        if progress.done == progress.of // 2:
            cluster.remove_node(workers[0], allow_graceful=False)
            cluster.add_node(num_cpus=1)

    try:
        found = rpl.experiment(str(toss), seeds=200, on=ray, shard=20, progress=disturb)
        with pytest.raises(rpl.CommandError, match="did you mean `rotated`"):
            rpl.experiment("rotatd", seeds=2, on=ray)
    finally:
        ray.shutdown()
        cluster.shutdown()
    assert found.table == command(toss.parent, "experiment", "toss.rpl", "--runs", "200")
