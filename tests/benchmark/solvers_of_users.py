"""Solvers of a user, as `module:function`: a good one, and all that can be wrong with one."""

import os
import signal
import subprocess
import time

import numpy as np

from tests.own_solvers import admm as good
from varcontact.solvers.interface import Settings
from varcontact.solvers.splitting.method import splitting_tangential


def endless(problem, settings, start):
    while True:
        pass


def sleeping(problem, settings, start):
    time.sleep(1000)


def held_up(problem, settings, start):
    """Right, but stopped for two seconds, as where others take the processor."""
    process = os.getpid()
    subprocess.Popen(["sh", "-c", f"sleep 2; kill -CONT {process}"])
    os.kill(process, signal.SIGSTOP)
    return good(problem, settings, start)


def crashing(problem, settings, start):
    os._exit(7)


def raising(problem, settings, start):
    raise RuntimeError("no licence")


def misshapen(problem, settings, start):
    return np.zeros(3)


def not_a_number(problem, settings, start):
    return np.full_like(problem.rigid_shift, np.nan)


def nothing(problem, settings, start):
    return np.zeros_like(problem.rigid_shift)


def slightly_wrong(problem, settings, start):
    answer = splitting_tangential(problem, Settings(1e-10))
    return 0.999 * answer.traction
