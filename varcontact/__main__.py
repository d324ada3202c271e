"""``python -m varcontact``: the command line."""

from varcontact.cli import main

if __name__ == "__main__":  # not in the processes of `varcontact.study.worker`, which import this anew
    main()
