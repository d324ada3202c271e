"""The command: a table by its name."""

import sys
from pathlib import Path

from tests.benchmarks.refinement import write_references
from tests.benchmarks.refinement.tables import TABLES


def main(words: list[str]) -> None:
    """Print the tables that are named, or write the references."""
    if words[:1] == ["references"]:
        return write_references(Path(words[1]))
    unknown = [word for word in words if word not in TABLES]
    if unknown or not words:
        sys.exit(f"name tables, of {', '.join(TABLES)}; or references and a file")
    for word in words:
        TABLES[word]()
    return None


if __name__ == "__main__":
    main(sys.argv[1:])
