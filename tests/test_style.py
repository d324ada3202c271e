"""How the package reads: the numbers of `python -m tests.style` may only fall."""

import json
from pathlib import Path

from tests.style import faults_of_rooms

DATA = Path(__file__).parent / "data"

NEVER = ("nested conditional",)
"""What stands nowhere."""


def test_no_room_reads_worse_than_it_did():
    """`tests/data/style.json` has the numbers by room and kind, beside the lines of code for their measure."""
    known = json.loads((DATA / "style.json").read_text())
    numbers_of_rooms = faults_of_rooms()
    worse = {
        f"{room}, {kind}": (number, known.get(room, {}).get(kind, 0))
        for room, numbers in numbers_of_rooms.items()
        for kind, number in numbers.items()
        if number > known.get(room, {}).get(kind, 0)
    }
    assert not worse, f"now and before: {worse}"
    nowhere = {
        room: kind for room, numbers in numbers_of_rooms.items() for kind in NEVER if numbers[kind]
    }
    assert not nowhere
