"""A study file with tables for every experiment, as the file of one of them."""

import re

from octant.reader_design.study_file.tables_read import belongs


def part_for(verb, text):
    """Return the text without the tables that a verb refuses, being of other experiments alone."""
    parts = re.split(r"^(?=\[)", text, flags=re.MULTILINE)
    return "".join(part for part in parts if belongs(re.match(r"\[*(\w*)", part)[1], verb))
