"""A scene solved in other processes and threads: none waits for ever, and all digits are the same."""

import subprocess
import sys

PROGRAM = """
import multiprocessing
import sys
from concurrent.futures import ThreadPoolExecutor

import varcontact as vc

def solved(method):
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.2), normal_force=1.0, friction=0.3,
        motion=vc.Steady(vx=0.1, spin=0.1), grid=vc.Grid(nx=14, ny=14))
    sol = vc.solve(scene, method=method)
    return sol.pressure.tobytes() + sol.traction.tobytes()

if __name__ == "__main__":
    methods = ["convex", "active-set"]
    here = [solved(method) for method in methods]
    for way in ("fork", "spawn", "forkserver"):
        with multiprocessing.get_context(way).Pool(2) as processes:
            there = processes.map_async(solved, methods * 2).get(timeout=120)
        print(way, "the same" if here * 2 == there else "other digits")
    with ThreadPoolExecutor(2) as threads:
        there = list(threads.map(solved, methods * 2))
    print("threads", "the same" if here * 2 == there else "other digits")
"""


def test_the_same_digits_wherever_a_scene_is_solved(tmp_path):
    """After solves in the parent, whose solvers may have left threads and locks that a fork does not take along."""
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [f"{way} the same" for way in ("fork", "spawn", "forkserver", "threads")]


def test_no_thread_is_left_behind(tmp_path):
    """A fork takes along the thread that calls it, and no other: Clarabel's would be missed."""
    code = (
        f"{PROGRAM.split('if __name__')[0]}\nimport psutil, time\nsolved('active-set')\n"
        "before, until = psutil.Process().num_threads(), time.monotonic() + 10\nsolved('convex')\n"
        "while psutil.Process().num_threads() > before and time.monotonic() < until:  # one that ends takes a moment\n"
        "    time.sleep(0.01)\n"
        "print(psutil.Process().num_threads() - before)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "0\n"
