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
    titles = [figure.get_suptitle(), *(axes.get_title(loc="left") for axes in figure.axes)]
    return image_html(picture.getvalue(), kind="png", text=next(filter(None, titles), "figure"))


def image_html(content: bytes, *, kind: str, text: str) -> str:
    """Return the bytes of a picture as an HTML picture that needs no other file.

    Parameters
    ----------
    content, kind, text : The file, whether it is ``png`` or ``gif``, and what is to be seen.
    """
    code, alt = base64.b64encode(content).decode("ascii"), html.escape(text)
    return f'<img style="max-width: 100%" alt="{alt}" src="data:image/{kind};base64,{code}">'
