"""Stored studies killed at random moments: ``python -m tests.killed``, from the folder that holds ``tests``.

Each study runs in a process of its own that is killed with SIGKILL, again and again, until it is through. Whatever was
in the store before a kill has to be there after it; no piece of work that was stored is done again; and the whole is
that of a study which nobody killed. Exit status: 0 all kept, 1 if not.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import varcontact as vc
from varcontact.study.csv_table import columns_of_text

LOG = "told.log"
"""A line for every piece of work that is begun."""


@dataclass(frozen=True)
class Study:
    """A kind of study: the name of its store, its work, and from the store its finished pieces."""

    store: str
    work: Callable[[Path, Callable[[str], None] | None], object]
    contents: Callable[[Path], list[object]]


@dataclass(frozen=True)
class Outcome:
    """Result of the kills: how often the study ended, pieces of work in it, and begun in all; pieces lost; whether the
    whole is that of a study which nobody killed; what is left beside the store.
    """

    kills: int
    rounds: int
    pieces: int
    begun: int
    lost: int
    same: bool
    left: list[str]

    @property
    def again(self) -> int:
        """How often a piece of work was begun again."""
        return self.begun - self.rounds * self.pieces

    @property
    def kept(self) -> bool:
        """Whether nothing was lost, nothing done twice but what a kill cut short, and nothing left."""
        return self.lost == 0 and self.same and self.left == [] and self.again <= self.kills


def scene(motion: object) -> vc.Scene:
    """A small one."""
    bodies, surface = vc.Bodies(G=1.0, nu=0.28), vc.Paraboloids(Rx=100.0, Ry=100.0)
    grid = vc.Grid(nx=8, ny=8)
    return vc.Scene(bodies=bodies, surface=surface, normal_force=1.0, friction=0.3, motion=motion, grid=grid)


def history(store: Path, progress: Callable[[str], None] | None) -> object:
    """Thirty steps of rolling."""
    return vc.solve(scene(vc.Transient(steps=30, dq=0.5, Fx=-0.2)), store=store, progress=progress)


def compare(store: Path, progress: Callable[[str], None] | None) -> object:
    """Five scenes by four methods."""
    scenes = {f"vx = {vx:g}": scene(vc.Steady(vx=vx, vy=0.01)) for vx in (0.01, 0.02, 0.03, 0.05, 0.08)}
    return vc.compare(scenes, ["tang", "fastsim", "tang-safeguarded", "linear"], store=store, progress=progress)


def converge(store: Path, progress: Callable[[str], None] | None) -> object:
    """Five grids with four offsets."""
    return vc.converge(scene(vc.Steady(vx=0.02)), [4, 6, 8, 10, 12], store=store, progress=progress)


def extremes(store: Path, progress: Callable[[str], None] | None) -> object:
    """Scenes of the self-test, each by a family of solvers in a process of its own."""
    from tests.extremes.harness import extremes as solve_all

    return solve_all(only="approach", short=True, store=store, progress=progress)


def steps(store: Path) -> list[object]:
    """The fields of each step."""
    return [np.stack([sol.pressure, *sol.traction, *sol.slip]).tobytes() for sol in vc.load(store, certify=False)]


def rows(store: Path) -> list[object]:
    """The rows of a table, but for what takes another time or memory each time, and distances that come later."""
    table = pd.read_csv(store)
    varying = ("seconds", "memory", "distance", "misclassified")
    return list(table[[name for name in table if not any(word in name for word in varying)]].astype(str).agg(tuple, 1))


STUDIES = {
    "history": Study("run.nc", history, steps),
    "compare": Study("run.csv", compare, rows),
    "converge": Study("run.csv", converge, rows),
    "extremes": Study("run.csv", extremes, rows),
}


def killed(study: Study, folder: Path, moments: int, seed: int) -> Outcome:
    """Kill a study at random moments, from the beginning again whenever it is through, then let it end."""
    store, log, generator = folder / study.store, folder / LOG, random.Random(seed)
    until_second, seconds, pieces = _alone(study, folder)
    longest = until_second + 2 * (seconds - until_second) / moments
    alone = folder / f"alone-{study.store}"
    kills = lost = 0
    rounds, same = 1, True
    while True:
        child = _begun(study, store, log)
        if kills < moments:
            time.sleep(generator.uniform(until_second / 2, longest))
        else:
            os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)
        before = study.contents(store) if store.exists() else []
        os.kill(child, signal.SIGKILL)
        if os.WIFSIGNALED(os.waitpid(child, 0)[1]):
            kills += 1
            after = study.contents(store) if store.exists() else []
            lost += sum(piece not in after for piece in before)
            continue
        same = same and whole(study, store) == whole(study, alone)
        if kills == moments:
            begun = len(log.read_text().splitlines())
            left = sorted(set(os.listdir(folder)) - {store.name, log.name, alone.name})
            return Outcome(kills, rounds, pieces, begun, lost, same, left)
        store.unlink()
        rounds += 1


def whole(study: Study, store: Path) -> list[object]:
    """All that does not vary from run to run: the pieces, with the distances of a comparison."""
    if store.suffix != ".csv":
        return study.contents(store)
    table = pd.read_csv(store)
    names = [name for name in table if "distance" in name or name == "misclassified"]
    distances = table[names].astype(float).round(12).astype(str)
    return [*study.contents(store), *(tuple(each) for each in distances.to_numpy())]


def _alone(study: Study, folder: Path) -> tuple[float, float, int]:
    """Of the study that nobody kills: seconds until its second piece of work is begun, in all, and pieces."""
    alone, log = folder / f"alone-{study.store}", folder / LOG
    begun = time.time()
    os.waitpid(_begun(study, alone, log), 0)
    seconds = time.time() - begun
    told = log.read_text().splitlines()
    log.unlink()
    return float(told[1].split()[0]) - begun, seconds, len(told)


def _begun(study: Study, store: Path, log: Path) -> int:
    """A process that does the study and writes a line for every piece of work it begins."""
    child = os.fork()
    if child:
        return child
    status = 1
    try:
        with log.open("a") as lines:

            def tell(word: str) -> None:
                lines.write(f"{time.time()} {word}\n")
                lines.flush()

            study.work(store, tell)
        status = 0
    finally:
        os._exit(status)


def _report(outcomes: dict[str, Outcome]) -> Iterator[str]:
    head = ["study", "pieces", "rounds", "kills", "lost", "begun again", "as if not killed", "all kept"]
    lines = [head]
    for name, outcome in outcomes.items():
        cells = [outcome.pieces, outcome.rounds, outcome.kills, outcome.lost, outcome.again]
        cells += [outcome.same, outcome.kept]
        lines.append([name, *map(str, cells)])
    yield from columns_of_text(lines, left=1)


def main() -> int:
    """Kill all studies, print what came of it, and return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.killed", description="Kill stored studies at random.")
    parser.add_argument("--moments", type=int, default=20, help="kills of each study")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    outcomes = {}
    for name, study in STUDIES.items():
        with tempfile.TemporaryDirectory() as folder:
            outcomes[name] = killed(study, Path(folder), chosen.moments, chosen.seed)
    print("\n".join(_report(outcomes)))
    return 0 if all(outcome.kept for outcome in outcomes.values()) else 1


if __name__ == "__main__":
    raise SystemExit(main())
