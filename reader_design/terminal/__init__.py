"""What a terminal needs: colour, tables of text, one JSON document, completion."""
