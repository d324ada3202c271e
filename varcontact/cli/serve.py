"""``varcontact serve``: the exact solver for co-simulation, by lines of JSON on standard input or a
local socket.
"""

from __future__ import annotations

import contextlib
import json
import math
import signal
import socketserver
import sys
from collections.abc import Mapping
from io import BufferedIOBase
from typing import IO, Annotated, Any

import typer

import varcontact as vc
from varcontact.cli.terminal import show
from varcontact.errors import SceneError, VarcontactError, shortened

MOST_BYTES = 2**24
"""Largest size of a message [bytes]."""
MOST_WHEELS = 1000
"""Largest number of wheels in a message."""
KEYS = ("id", "scene", "wheels", "tol", "accuracy")

Before = tuple[list[str], Any, Any]
"""Wheels of the previous message with their lattice and results, from which the next one starts."""


def serve(
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Of a socket instead; 0: any free port.")
    ] = None,
    host: Annotated[
        str, typer.Option(help="Of the socket. Whoever reaches it can use the solver.")
    ] = "127.0.0.1",
) -> None:
    """Solve batches of wheels for another program, one line of JSON each (docs/vehicle_codes.md).

    Ends with its input, by SIGTERM or Ctrl-C.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with contextlib.suppress(KeyboardInterrupt):
        if port is None:
            with (
                open(sys.stdout.fileno(), "wb", buffering=0, closefd=False) as output,
                contextlib.redirect_stdout(sys.stderr),
            ):
                serve_lines(sys.stdin.buffer, output)
            return
        try:
            server = _Server((host, port), _Client)
        except OSError as error:
            raise SceneError(
                "--port", f"{host}:{port}", f"a free address ({error.strerror})"
            ) from None
        with server:
            show("listening on {}:{}".format(*server.server_address[:2]))
            server.serve_forever()


class _Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = daemon_threads = True
    block_on_close = False


class _Client(socketserver.StreamRequestHandler):
    def handle(self) -> None:
        serve_lines(self.rfile, self.wfile)


def serve_lines(messages: IO[bytes] | BufferedIOBase, answers: IO[bytes] | BufferedIOBase) -> None:
    """Answer each line until there are no more, or until the client has closed the connection."""
    before: Before | None = None
    with contextlib.suppress(ConnectionError):
        while line := messages.readline(MOST_BYTES + 1):
            if len(line) > MOST_BYTES:
                while line and not line.endswith(b"\n"):
                    line = messages.readline(MOST_BYTES)
                reply: dict[str, Any] = {
                    "id": None,
                    "error": f"a message has {MOST_BYTES} bytes at most",
                }
            elif line.strip():
                reply, before = answer(line, before)
            else:
                continue
            answers.write(json.dumps(reply, allow_nan=False).encode() + b"\n")
            answers.flush()


def answer(line: bytes, before: Before | None = None) -> tuple[dict[str, Any], Before | None]:
    """Answer to a message, and the start of the next one: after an error the earlier start."""
    name = None
    try:
        message = _message(line)
        name = message.get("id")
        wheels, now = _solved(message, before)
    except VarcontactError as error:
        return {"id": name, "error": str(error)}, before
    except Exception as error:  # a co-simulation continues after an internal error
        return {
            "id": name,
            "error": f"{type(error).__name__}: {shortened(str(error), 200)}",
        }, before
    return {"id": name, "wheels": wheels}, now


def _message(line: bytes) -> dict[str, Any]:
    """The entries of a message."""
    from varcontact.io.toml_tables import check_keys

    def refuse(word: str) -> None:
        raise ValueError(f"{word} is no number of JSON")

    try:
        message = json.loads(line, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise SceneError(
            "message", None, message=f"a message is one line of JSON ({error})"
        ) from None
    if not isinstance(message, dict):
        raise SceneError("message", message, "an object with the entry wheels")
    check_keys("", message, KEYS)
    name = message.get("id")
    # JSON allows 1e999, which is infinite
    if not isinstance(name, str | int | float | None) or name in (math.inf, -math.inf):
        raise SceneError("id", name, "a string or a finite number")
    wheels = message.get("wheels")
    if not isinstance(wheels, dict) or not 0 < len(wheels) <= MOST_WHEELS:
        raise SceneError(
            "wheels", wheels, f"an object with scenes of 1 to {MOST_WHEELS} wheels by name"
        )
    return message


def _solved(
    message: Mapping[str, Any], before: Before | None
) -> tuple[dict[str, Any], Before | None]:
    """Results by wheel, where an error is that of one wheel only; and the start of the next
    message, None if it cannot start from this one.
    """
    from varcontact.io.toml_tables import table_of

    # scenes of the wheels
    common = table_of("scene", message.get("scene", {}))
    options = {name: message[name] for name in ("tol", "accuracy") if message.get(name) is not None}
    scenes: dict[str, vc.Scene] = {}
    results: dict[str, Any] = {}
    for wheel, own in message["wheels"].items():
        try:
            scenes[wheel] = _scene(common, table_of("wheel", own), "accuracy" in options)
        except VarcontactError as error:
            results[wheel] = {"ok": False, "error": str(error)}
    if not scenes:
        return results, before
    # start from the previous message, if it had these wheels on the same lattice
    lattices = {(scene.grid, type(scene.motion), scene.line) for scene in scenes.values()}
    options["failures"] = "keep"
    if before is not None and lattices == before[1] and set(scenes) <= set(before[0]):
        options["start"] = before[2].isel(scene=[before[0].index(wheel) for wheel in scenes])
    now = None
    try:
        table = vc.solve_many(scenes.values(), fields=True, **options)
        if table["ok"].all() and len(lattices) == 1:
            now = (list(scenes), lattices, table)
    except SceneError as error:
        if error.field != "fields":  # "fields": the scenes have no common lattice
            raise
        table = vc.solve_many(scenes.values(), **options)
    results |= zip(scenes, _rows(table), strict=True)
    return {wheel: results[wheel] for wheel in message["wheels"]}, now


def _scene(common: Mapping[str, Any], own: Mapping[str, Any], to_accuracy: bool) -> vc.Scene:
    """Scene of a wheel; its entries take precedence over those of all wheels, also within
    tables.
    """
    from varcontact.io.scene_toml import scene_from

    entries = {**common, **own}
    for name, entry in entries.items():
        if isinstance(entry, dict) and isinstance(common.get(name), dict):
            entries[name] = {**common[name], **entry}
    scene = scene_from(entries)
    if isinstance(scene.motion, vc.Transient):
        raise SceneError("motion.kind", "transient", "steady or shift: a message is one instant")
    if to_accuracy and isinstance(scene.grid, vc.Grid):
        raise SceneError("grid", scene.grid, "left out: it is chosen for the accuracy")
    return scene


def _rows(table: Any) -> list[dict[str, Any]]:
    """Figures of each scene, without NaN; with the error, if there is one."""
    columns = {
        name: values.values.tolist()
        for name, values in table.data_vars.items()
        if values.dims == ("scene",)
    }
    rows = []
    for k in range(table.sizes["scene"]):
        values = {name: column[k] for name, column in columns.items()}
        reason = values.pop("message").removeprefix(f"scenes[{k}]: ")
        row = {name: value for name, value in values.items() if value == value}
        if reason:
            row["error"] = reason
        rows.append(row)
    return rows
