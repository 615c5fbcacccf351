"""``python -m codesign`` does what ``hwsw`` does."""

from codesign.cli import main

main(prog_name="hwsw")
