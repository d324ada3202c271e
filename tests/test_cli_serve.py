"""The command ``varcontact serve``: what a co-simulation sends, and what it must not end by."""

import io
import json
import signal
import socket
import subprocess
import sys
from functools import partial

import pytest

import varcontact as vc
from tests.scenes import STEEL, make_scene
from varcontact.cli.serve import answer, serve_lines

SCENE = {
    "bodies": {"G": 82e9, "nu": 0.28},
    "surface": {"kind": "paraboloids", "Rx": 0.46, "Ry": 0.30},
    "friction": 0.3,
    "motion": {"kind": "steady"},
    "grid": {"nx": 8, "ny": 8},
}
WHEELS = {
    "1L": {"normal_force": 1e5, "motion": {"vx": 1e-3, "spin": 0.2}},
    "1R": {"normal_force": 9e4, "motion": {"vy": -2e-3}},
    "2L": {"normal_force": 8e4, "motion": {"Fx": -1e4}},
}
GOOD = {"id": 1, "scene": SCENE, "wheels": WHEELS}


def line(message):
    return json.dumps(message).encode() + b"\n"


def answers(*messages):
    """To messages, bytes or objects, one after the other."""
    out = io.BytesIO()
    serve_lines(
        io.BytesIO(b"".join(each if isinstance(each, bytes) else line(each) for each in messages)),
        out,
    )
    return [json.loads(each) for each in out.getvalue().splitlines()]


def test_forces_are_those_of_solve():
    (found,) = answers(GOOD)
    assert (found["id"], list(found["wheels"])) == (1, list(WHEELS))
    for wheel, own in WHEELS.items():
        surface, motion, grid = (
            vc.Paraboloids(Rx=0.46, Ry=0.30),
            vc.Steady(**own["motion"]),
            vc.Grid(nx=8, ny=8),
        )
        scene = make_scene(surface, own["normal_force"], motion, grid, bodies=STEEL)
        sol, limit = vc.solve(scene), 0.3 * own["normal_force"]
        row = found["wheels"][wheel]
        assert row["ok"] and row["residual"] <= 1e-8
        assert [row["Fx"], row["Fy"]] == pytest.approx(sol.force, abs=1e-7 * limit)
        assert [row["vx"], row["vy"]] == pytest.approx(sol.creepage[:2], abs=1e-7 * 1e-2)


def test_wheels_start_from_the_message_before_whatever_their_order():
    first, before = answer(line(GOOD))
    again, after = answer(line({**GOOD, "wheels": dict(reversed(WHEELS.items()))}), before)
    cold, _ = answer(line({**GOOD, "wheels": dict(reversed(WHEELS.items()))}))
    assert before[0] == after[0][::-1] == list(WHEELS)
    residuals = [[row["residual"] for row in reply["wheels"].values()] for reply in (again, cold)]
    assert residuals[0] != residuals[1]  # it did not begin from nothing
    for wheel, row in again["wheels"].items():
        assert row["Fx"] == pytest.approx(first["wheels"][wheel]["Fx"], abs=1e-7 * 3e4)
    finer = {**GOOD, "scene": {**SCENE, "grid": {"nx": 10, "ny": 8}}}
    assert answer(line(finer), before)[0] == answer(line(finer))[0]
    other = {**GOOD, "wheels": {"3L": WHEELS["1L"]}}
    assert answer(line(other), before)[0] == answer(line(other))[0]


def test_grids_of_each_and_accuracies():
    """Without a common lattice, or to an accuracy, there is no start, but an answer."""
    wheels = {"1L": {**WHEELS["1L"], "grid": {"nx": 10, "ny": 10}}, "1R": WHEELS["1R"]}
    free = {key: value for key, value in SCENE.items() if key != "grid"}
    found, to_accuracy = answers(
        {**GOOD, "wheels": wheels}, {**GOOD, "scene": free, "accuracy": 0.05}
    )
    assert all(row["ok"] for row in found["wheels"].values())
    assert 0 < to_accuracy["wheels"]["1L"]["Fx_error"] <= 0.05 * 3e4


def test_an_accuracy_beside_a_grid_is_refused():
    """As by `solve`, wheel by wheel."""
    free = {key: value for key, value in SCENE.items() if key != "grid"}
    wheels = {"1L": WHEELS["1L"], "1R": {**WHEELS["1R"], "grid": SCENE["grid"]}}
    (found,) = answers({**GOOD, "scene": free, "wheels": wheels, "accuracy": 0.05})
    assert found["wheels"]["1L"]["ok"]
    assert found["wheels"]["1R"]["error"].endswith(
        "must be left out: it is chosen for the accuracy"
    )


def test_a_wrong_wheel_is_named_and_the_others_are_solved():
    wrong = {
        "lifted": {"normal_force": -1.0},
        "words": "none",
        "long": {"normal_force": 1e5, "motion": {"Fx": -4e4}},
        "steps": {"normal_force": 1e5, "motion": {"kind": "transient", "steps": 2, "dq": 0.1}},
        "file": {"normal_force": 1e5, "friction": {"file": "/etc/passwd"}},
        "typo": {"normal_force": 1e5, "motion": {"vz": 1.0}},
    }
    (found,) = answers({**GOOD, "wheels": {**wrong, "1L": WHEELS["1L"]}})
    said = {wheel: row["error"] for wheel, row in found["wheels"].items() if not row["ok"]}
    assert set(said) == set(wrong)
    assert said["lifted"] == "normal_force = -1.0 is not allowed: must be a positive, finite number"
    assert said["words"] == "wheel = 'none' is not allowed: must be a table, [wheel]"
    assert said["long"].startswith("motion: a tangential force of 40000 cannot be carried")
    assert said["steps"].endswith("must be steady or shift: a message is one instant")
    assert said["file"].endswith("only scene files may name files, stored ones not")
    assert said["typo"].startswith("motion.vz: there is no such key")
    assert found["wheels"]["1L"]["ok"]


MALFORMED = {
    "no JSON": b"hello\n",
    "half": line(GOOD)[:100] + b"\n",
    "NaN": line(GOOD).replace(b"1e-3", b"NaN").replace(b"0.001", b"NaN"),
    "infinity": b'{"wheels": {"a": {"normal_force": Infinity}}}\n',
    "no text": b"\xff\xfe\x00\n",
    "a list": b"[1, 2]\n",
    "a number of thousands of digits": b'{"wheels": {"a": {"normal_force": '
    + b"9" * 9999
    + b"}}}\n",
    "deep": b"[" * 100_000 + b"\n",
    "no wheels": b'{"id": 3}\n',
    "wheels in a list": b'{"wheels": []}\n',
    "too many": line({"wheels": {str(k): {} for k in range(1001)}}),
    "another key": line({**GOOD, "pickle": "gASV"}),
    "tolerance": line({**GOOD, "tol": -1}),
    "tolerance in words": line({**GOOD, "tol": "small"}),
    "id": line({**GOOD, "id": {}}),
    "id beyond numbers": b'{"id": 1e999' + line(GOOD)[len('{"id": 1') :],
    "scene": line({**GOOD, "scene": 3}),
}


@pytest.mark.parametrize("message", MALFORMED.values(), ids=MALFORMED)
def test_a_malformed_message_has_an_error_and_the_next_one_its_answer(message):
    wrong, good = answers(message, GOOD)
    assert set(wrong) == {"id", "error"} and wrong["error"]
    assert all(row["ok"] for row in good["wheels"].values())


def test_a_long_line_is_not_kept(monkeypatch):
    monkeypatch.setattr(sys.modules[serve_lines.__module__], "MOST_BYTES", 2000)
    wrong, good = answers(b"x" * 9000 + b"\n", GOOD)
    assert wrong["error"] == "a message has 2000 bytes at most"
    assert good["id"] == 1
    (cut,) = answers(b"x" * 9000)
    assert cut == wrong


COMMAND = [sys.executable, "-m", "varcontact", "serve"]


@pytest.mark.long
def test_standard_input_until_its_end(tmp_path):
    done = subprocess.run(
        COMMAND, input=line(GOOD) + b"\n" + b'{"wh', capture_output=True, timeout=300
    )
    good, half = map(json.loads, done.stdout.splitlines())
    assert (done.returncode, done.stderr) == (0, b"")
    assert good["wheels"]["1L"]["ok"] and "error" in half


@pytest.mark.long
@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_in_silence(end):
    # a shell's background jobs begin deaf to it
    heard = partial(signal.signal, end, signal.SIG_DFL)
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    process = subprocess.Popen(COMMAND, **pipes, preexec_fn=heard)
    process.stdin.write(line(GOOD))
    process.stdin.flush()
    assert json.loads(process.stdout.readline())["id"] == 1
    process.send_signal(end)
    assert process.wait(timeout=300) == 0
    assert process.stderr.read() == b""


@pytest.mark.long
def test_a_small_request_is_answered_beside_a_large_one():
    process = subprocess.Popen([*COMMAND, "--port", "0"], stdout=subprocess.PIPE)
    try:
        address = ("127.0.0.1", int(process.stdout.readline().decode().rpartition(":")[2]))
        with (
            socket.create_connection(address, 300) as large,
            socket.create_connection(address, 300) as small,
        ):
            large.sendall(line({**GOOD, "scene": {**SCENE, "grid": {"nx": 400, "ny": 400}}}))
            for number in (5, 6):
                small.sendall(line({**GOOD, "id": number}))
                assert json.loads(small.makefile("rb").readline())["id"] == number
            large.setblocking(False)
            with pytest.raises(BlockingIOError):  # there is nothing to read yet
                large.recv(1)
    finally:
        process.terminate()
    assert process.wait(timeout=300) == 0


@pytest.mark.long
def test_a_local_socket():
    """Two clients at once; one that leaves in the middle of a message disturbs nobody."""
    process = subprocess.Popen(
        [*COMMAND, "--port", "0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        words = process.stdout.readline().decode().split()
        assert words[:2] == ["listening", "on"] and words[2].startswith("127.0.0.1:")
        address = ("127.0.0.1", int(words[2].split(":")[1]))
        with (
            socket.create_connection(address, 300) as one,
            socket.create_connection(address, 300) as other,
        ):
            with socket.create_connection(address, 300) as leaving:
                leaving.sendall(line(GOOD)[:200])
            with socket.create_connection(address, 300) as leaving:
                leaving.sendall(line(GOOD))  # and does not wait for the answer
            for client, number in ((one, 5), (other, 6), (one, 7)):
                client.sendall(line({**GOOD, "id": number}))
                assert json.loads(client.makefile("rb").readline())["id"] == number
            taken = subprocess.run(
                [*COMMAND, "--port", str(address[1])], capture_output=True, text=True, timeout=300
            )
            assert taken.returncode == 2 and "must be a free address" in taken.stderr
    finally:
        process.terminate()
    assert process.wait(timeout=300) == 0
    assert process.stderr.read() == b""
