"""The command `rpl`, which the package has in it: `python -m rpl run delivery.rpl --world dept`."""

import sys

from .rpl_native import command


def main() -> None:
    """Does what the command line asks for, and ends the process with its status."""
    sys.exit(command(["rpl", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
