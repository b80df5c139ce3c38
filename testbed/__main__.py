"""python -m testbed: the command."""

from testbed.cli import main

main()
