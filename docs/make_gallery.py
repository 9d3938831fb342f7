"""Make the gallery: ``python docs/make_gallery.py FOLDER`` runs its commands there.

Pictures go to ``docs/gallery``, reports to ``docs/extra/reports``, README's picture to
``docs/figures``; all of them are less than two megabytes.
"""

import re
import shutil
import sys
from pathlib import Path

from PIL import Image

from octant.reader_design import cli, study_file

DOCS = Path(__file__).resolve().parent
COMMANDS = (
    "scene --picture room.png",
    "navigate --runs 5 --out drive --animate drive.gif",
    "map --tag desk --out map",
    "demo --out demo",
)
REPORTS = {"demo/report.html": "office.html"}
PICTURES = ("room.png", "map/figures/power.png", "map/figures/bearing_error.png")


def main(folder: Path) -> None:
    """Run the commands and put what they leave into the tree.

    Parameters
    ----------
    folder : Where they are run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    outputs = ("--picture", "--out", "--animate")
    for command in COMMANDS:
        words = command.split()
        pairs = zip(["", *words], words, strict=False)
        call = [str(folder / w) if before in outputs else w for before, w in pairs]
        if cli.run(call) != 0:
            sys.exit(1)
    reports = DOCS / "extra" / "reports"
    reports.mkdir(parents=True, exist_ok=True)
    installed = f"{Path(study_file.__file__).parent}/"  # no report names a folder of this machine
    for left, name in REPORTS.items():
        text = (folder / left).read_text("utf-8").replace(installed, "")
        for table in re.findall(r'<a href="([\w-]+\.(?:toml|csv))"', text):
            data = (folder / left).with_name(table).read_text("utf-8").replace(installed, "")
            (reports / table).write_text(data, "utf-8")
        text = re.sub(r'<a href="[\w-]+\.nc">(.*?)</a>', r"\1", text)  # too large to be shown here
        (reports / name).write_text(text, "utf-8")
    for left in PICTURES:
        small(Image.open(folder / left), 1200).save(
            DOCS / "gallery" / f"office_{Path(left).stem}.png", optimize=True
        )
    shutil.copy(folder / "drive.gif", DOCS / "gallery" / "office_drive.gif")
    readme(folder).save(DOCS / "figures" / "readme.png", optimize=True)


def small(picture: Image.Image, width: int) -> Image.Image:
    """Return a picture of 128 colours, at most so wide.

    Parameters
    ----------
    picture, width : The picture, and its greatest width [pixel].
    """
    shown = picture.convert("RGB")
    if shown.width > width:
        size = (width, round(shown.height * width / shown.width))
        shown = shown.resize(size, Image.Resampling.LANCZOS)
    return shown.quantize(128, dither=Image.Dither.NONE)


def readme(folder: Path) -> Image.Image:
    """Return README's picture: the room, and beside it the drive at its end.

    Parameters
    ----------
    folder : Where the commands were run.
    """
    room = Image.open(folder / "room.png").convert("RGB")
    with Image.open(folder / "drive.gif") as film:
        film.seek(film.n_frames - 1)
        drive = film.convert("RGB")
    height = 560
    parts = [p.resize((round(p.width * height / p.height), height)) for p in (room, drive)]
    both = Image.new("RGB", (sum(p.width for p in parts), height), "white")
    both.paste(parts[0], (0, 0))
    both.paste(parts[1], (parts[0].width, 0))
    return small(both, 1400)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
