"""``python -m belvedere.cli``."""

from belvedere.cli import main

main()
