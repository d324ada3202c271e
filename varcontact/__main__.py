"""``python -m varcontact``: the command line."""

from varcontact.cli import main

if __name__ == "__main__":
    main()
