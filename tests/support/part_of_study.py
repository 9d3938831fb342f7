"""A study file with tables for every experiment, as the file of one of them."""

import re

from octant.reader_design.study_file.tables_read import READ_BY

FOR_SOME = frozenset.union(*READ_BY.values())


def part_for(verb, text):
    """Return the text without the tables that other experiments alone read."""
    parts = re.split(r"^(?=\[)", text, flags=re.MULTILINE)
    ignored = FOR_SOME - READ_BY.get(verb, FOR_SOME)
    return "".join(part for part in parts if re.match(r"\[*(\w*)", part)[1] not in ignored)
