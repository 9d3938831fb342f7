"""Parts that all reports are built from: templates, style, scripts, the words' typography."""
