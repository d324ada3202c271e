"""The memory that is left: of the machine, of control groups as containers have them, of an address space."""

import math
import resource

import psutil
import pytest

from varcontact.errors import TooLarge
from varcontact.system.process import available, left_by_control_groups, need


def tree(root, files):
    """Files below a folder that stands for the root of the file system."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


VERSION_2 = {
    "proc/self/cgroup": "0::/user.slice/job\n",
    "sys/fs/cgroup/user.slice/job/memory.max": "max\n",
    "sys/fs/cgroup/user.slice/job/memory.current": "500\n",
    "sys/fs/cgroup/user.slice/memory.max": "3000\n",
    "sys/fs/cgroup/user.slice/memory.current": "1200\n",
    "sys/fs/cgroup/user.slice/memory.stat": "anon 900\ninactive_file 300\n",
}
VERSION_1 = {
    "proc/self/cgroup": "5:cpu,cpuacct:/docker/abc\n4:memory:/docker/abc\n",
    "sys/fs/cgroup/memory/memory.limit_in_bytes": "9223372036854771712\n",
    "sys/fs/cgroup/memory/memory.usage_in_bytes": "7000\n",
    "sys/fs/cgroup/memory/docker/abc/memory.limit_in_bytes": "4000\n",
    "sys/fs/cgroup/memory/docker/abc/memory.usage_in_bytes": "1000\n",
    "sys/fs/cgroup/memory/docker/abc/memory.stat": "cache 10\ntotal_inactive_file 50\n",
}


@pytest.mark.parametrize(
    ("files", "left"),
    [
        (VERSION_2, 2100),  # of the group above: its own has no limit
        (VERSION_2 | {"sys/fs/cgroup/user.slice/job/memory.max": "1500\n"}, 1000),
        (VERSION_1, 3050),
        ({"proc/self/cgroup": "0::/\n"}, math.inf),
        ({}, math.inf),
    ],
)
def test_control_groups(tmp_path, files, left):
    assert left_by_control_groups(tree(tmp_path, files)) == left


def test_no_more_than_the_machine_has():
    assert 0 < available() <= psutil.virtual_memory().total


def test_limited_address_space_counts():
    """As after ``ulimit -v``: matrices beyond it are refused, though the machine had room."""
    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    taken = psutil.Process().memory_info().vms
    resource.setrlimit(resource.RLIMIT_AS, (taken + 200 * 2**20, hard))
    try:
        assert available() <= 200 * 2**20
        with pytest.raises(TooLarge, match="the problem"):
            need("the problem", 201.0 * 2**20, "a smaller one would fit")
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))
    assert available() < math.inf
