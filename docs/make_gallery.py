"""``python -m docs.make_gallery``: run the commands of ``docs/gallery.md``, and keep its pictures in ``docs/pictures``.

The page is the one list: the commands below a picture make it. The file that they write under its name is kept. Of an
HTML page ``NAME.html`` a screenshot is kept: ``NAME.png`` is its top, ``NAME-PLACE.png`` begins at the heading with the
id PLACE. A picture below a command of another program is left as it is.

The browser is Chromium, driven by Playwright (extra ``browser``).
"""

from __future__ import annotations

import io
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
PAGE = DOCS / "gallery.md"
MOST_BYTES = 100_000
"""Of one picture."""

WINDOW = (1100, 740)
WIDEST = 1100
COLOURS = 256
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SECTION = re.compile(r"!\[([^\]]+)\]\(([\w/.-]+)\)\n\n```sh\n(.*?)```", re.DOTALL)


@dataclass(frozen=True)
class Shown:
    """A picture of the page: what it shows in words, its file below ``docs``, and the commands below it."""

    alt: str
    file: str
    commands: tuple[str, ...]

    @property
    def own(self) -> bool:
        """Whether the commands of the page make it: not what stands elsewhere, nor what another program shows."""
        return self.file.startswith("pictures/") and all(each.startswith("hwsw ") for each in self.commands)


def gallery(page: str) -> list[Shown]:
    """The pictures of the page, in order."""
    return [Shown(alt, file, tuple(block.splitlines())) for alt, file, block in SECTION.findall(page)]


def run_commands(pictures: Iterable[Shown], folder: Path) -> None:
    """Run the commands of all pictures in ``folder``, each once.

    Raises:
        CalledProcessError: a command fails.
    """
    for command in dict.fromkeys(each for picture in pictures for each in picture.commands):
        print(command, flush=True)
        arguments = shlex.split(command)[1:]
        subprocess.run(
            [sys.executable, "-m", "codesign", *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL
        )


def kept(pictures: Iterable[Shown], folder: Path) -> Iterator[tuple[str, bytes]]:
    """The file name and the bytes of each picture, from what the commands wrote into ``folder``."""
    for picture in pictures:
        name = Path(picture.file).name
        drawn = folder / name
        data = drawn.read_bytes() if drawn.is_file() else _screenshot(folder, Path(name).stem)
        yield name, small(data)


def _screenshot(folder: Path, stem: str) -> bytes:
    from playwright.sync_api import sync_playwright

    page, _, place = stem.partition("-")
    browser_path = next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]})
        tab.goto((folder / f"{page}.html").as_uri())
        tab.wait_for_load_state()
        if place:
            tab.evaluate("place => document.getElementById(place).scrollIntoView()", place)
        tab.wait_for_timeout(500)
        shot: bytes = tab.screenshot()
        browser.close()
    return shot


def small(data: bytes) -> bytes:
    """A PNG with at most 256 colours and 1,100 pixels across: the pictures lie in the repository."""
    image = Image.open(io.BytesIO(data)).convert("RGB")
    if image.width > WIDEST:
        image = image.resize((WIDEST, round(image.height * WIDEST / image.width)), Image.Resampling.LANCZOS)
    out = io.BytesIO()
    # The colours that lie farthest apart are kept, so that a small mark keeps its own.
    few = image.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    few.save(out, "png", optimize=True)
    return out.getvalue()


def main() -> None:
    """Make all pictures again."""
    pictures = [picture for picture in gallery(PAGE.read_text(encoding="utf-8")) if picture.own]
    with tempfile.TemporaryDirectory() as folder:
        run_commands(pictures, Path(folder))
        for name, data in kept(pictures, Path(folder)):
            (DOCS / "pictures" / name).write_bytes(data)
            print(f"docs/pictures/{name}: {len(data):,} bytes{' (too large)' * (len(data) > MOST_BYTES)}")


if __name__ == "__main__":
    main()
