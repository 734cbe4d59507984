"""Work on threads, and how it ends early."""

import threading
import time

import pytest

from restitution.parallel import checkpoint, ended_by, on_threads


def endless(_=None):
    for _ in range(10_000):
        checkpoint()
        time.sleep(1e-3)
    pytest.fail("no checkpoint has ended the work")


class Over(Exception):
    pass


def over():
    raise Over


def test_a_limit_ends_work_on_threads_and_leaves_no_trace():
    with pytest.raises(Over), ended_by(over):
        on_threads(endless, range(4), 2, lambda: None)
    checkpoint()


def test_what_one_task_raises_ends_the_others():
    begun = threading.Barrier(3)

    def run(task):
        begun.wait(20.0)
        over() if task == 1 else endless()

    with pytest.raises(Over):
        on_threads(run, range(3), 3, lambda: None)


def test_an_interrupt_of_the_caller_ends_its_threads():
    def interrupt():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        on_threads(endless, range(2), 2, interrupt)
