"""Tables of text on stdout: aligned columns in ASCII that people read and scripts can cut."""

from collections.abc import Iterator, Sequence


def text_table(
    header: Sequence[str], rows: Sequence[Sequence[str]], *, words: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the lines of a table, a line for the header and one for each row.

    Parameters
    ----------
    header, rows : Names with their units, and cells.
    words : Columns that stand at the left; numbers stand at the right.
    """
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    for row in (header, *rows):
        cells = [
            f"{cell:<{width}}" if name in words else f"{cell:>{width}}"
            for name, cell, width in zip(header, row, widths, strict=True)
        ]
        yield "  ".join(cells).rstrip()
