"""Build the documentation: ``python docs/build.py [FOLDER]``; warnings are errors.

The site opens from disk (``docs/_build/html/index.html``) and needs no network. The tutorials are
run; their results are kept in ``docs/_build/.jupyter_cache`` until their text changes. Needs
``pip install ".[docs]"``.
"""

import sys
from pathlib import Path

from sphinx.cmd.build import build_main

DOCS = Path(__file__).resolve().parent


def main(folder: Path) -> int:
    """Return Sphinx's exit code.

    Parameters
    ----------
    folder : Where the site is written; what is there already is brought up to date.
    """
    doctrees = str(folder.parent / "doctrees")
    return build_main(["-W", "--keep-going", "-q", "-d", doctrees, str(DOCS), str(folder)])


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS / "_build" / "html"))
