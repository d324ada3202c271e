"""Sweeps on a cluster of dask: the same bytes as in this process, also where a worker dies."""

import dataclasses
import os
import signal

import pytest

import varcontact as vc
from tests.study import test_own_bodies as own_bodies

GRID = vc.Grid(nx=6, ny=6)
OVER = {"friction": [0.2, 0.3], "motion.vx": [0.0, 0.02, 0.05, 0.1, 0.3]}


@pytest.fixture(scope="module")
def scene(rolling):
    return rolling(grid=GRID)


@pytest.fixture(scope="module")
def alone(scene, tmp_path_factory):
    """The store of the sweep in this process."""
    store = tmp_path_factory.mktemp("alone") / "sweep.nc"
    vc.sweep(scene, OVER, chunk=4, store=store)
    return store


@pytest.fixture(scope="module")
def client():
    """That of a cluster of two worker processes, which makes itself dask's default."""
    import dask
    from distributed import Client, LocalCluster

    with (
        dask.config.set({"distributed.worker.profile.enabled": False}),
        LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        Client(cluster) as client,
    ):
        assert len(client.scheduler_info()["workers"]) == 2
        yield client


@pytest.mark.long
def test_the_same_bytes(scene, alone, client, tmp_path):
    store = tmp_path / "cluster.nc"
    vc.sweep(scene, OVER, chunk=4, executor=client.get_executor(), store=store)
    assert store.read_bytes() == alone.read_bytes()


def test_a_cluster_carries_own_bodies(client):
    own = own_bodies.scene(own_bodies.BODIES["symbol"])
    found = vc.sweep(own, own_bodies.OVER, executor=client.get_executor())
    assert found.identical(vc.sweep(own, own_bodies.OVER))


@pytest.mark.long
def test_a_worker_of_the_cluster_dies(scene, alone, client, tmp_path):
    """Dask gives its chunk to another one, and the store is the same."""
    pids = list(client.run(os.getpid).values())

    def kill(standing):
        if standing.done == 4:
            os.kill(pids[0], signal.SIGKILL)

    vc.sweep(
        scene,
        OVER,
        chunk=4,
        executor=client.get_executor(),
        store=tmp_path / "sweep.nc",
        progress=kill,
    )
    assert (tmp_path / "sweep.nc").read_bytes() == alone.read_bytes()


@pytest.mark.long
def test_files_are_written_beside_a_client_of_dask(scene, client, tmp_path):
    """Xarray would ask the cluster for a lock of each file, also of one in memory."""
    sol, rolling = vc.solve(scene), vc.Transient(steps=2, dq=0.2, vx=0.01)
    sol.save(tmp_path / "solution.nc")
    assert vc.load(tmp_path / "solution.nc").pressure.tobytes() == sol.pressure.tobytes()
    history = vc.solve(dataclasses.replace(scene, motion=rolling), store=tmp_path / "history.nc")
    assert vc.load(tmp_path / "history.nc").to_xarray().identical(history.to_xarray())
    swept = vc.sweep(scene, OVER, store=tmp_path / "sweep.nc")
    assert vc.read_sweep(tmp_path / "sweep.nc").identical(swept)
