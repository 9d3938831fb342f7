"""How results show themselves: a short text, a picture in a notebook; and who hears of progress."""

import base64
import html
import io
from typing import TYPE_CHECKING

from octant.reader_design.keeping.progress import Progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def progress_of(progress: bool | Progress) -> Progress:
    """Return where progress goes: bars on stderr or in the notebook, or nowhere.

    Parameters
    ----------
    progress : False silences bars and messages.
    """
    return progress if isinstance(progress, Progress) else Progress(quiet=not progress)


def text_html(text: str) -> str:
    """Return a text as HTML that keeps its lines and columns.

    Parameters
    ----------
    text : Any text.
    """
    return f"<pre>{html.escape(text)}</pre>"


def figure_html(figure: "Figure") -> str:
    """Return a figure as an HTML picture that needs no other file.

    Parameters
    ----------
    figure : From any ``plot`` of Octant.
    """
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=100)
    return image_html(picture.getvalue(), kind="png")


def image_html(content: bytes, *, kind: str) -> str:
    """Return the bytes of a picture as an HTML picture that needs no other file.

    Parameters
    ----------
    content, kind : The file, and whether it is ``png`` or ``gif``.
    """
    code = base64.b64encode(content).decode("ascii")
    return f'<img style="max-width: 100%" src="data:image/{kind};base64,{code}">'
