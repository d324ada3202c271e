"""``python -m varcontact``: the command line."""

from varcontact.cli import main

main()
