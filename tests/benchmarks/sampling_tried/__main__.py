"""The command: tables by their names."""

import sys

from tests.benchmarks.sampling_tried import plane, space

TABLES = {
    "linear": plane.linear,
    "strips": plane.strips,
    "time": plane.in_time,
    "normal": space.normal,
    "cut": space.cut,
    "parts": space.parts,
    "unlike": space.unlike,
    "histories": space.histories,
    "levels": space.levels,
}


def main(words: list[str]) -> None:
    """Print the tables that are named."""
    if not words or set(words) - set(TABLES):
        sys.exit(f"name tables, of {', '.join(TABLES)}")
    for word in words:
        TABLES[word]()


if __name__ == "__main__":
    main(sys.argv[1:])
