"""The site's own directive: a drawing in light and dark."""

from typing import ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util.docutils import SphinxDirective


class Drawing(SphinxDirective):
    """A drawing of ``drawings.py`` with its caption; the reader's theme chooses which is shown."""

    required_arguments = 1
    has_content = True
    option_spec: ClassVar = {"alt": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        """Return one figure with both pictures."""
        figure = nodes.figure(classes=["align-default"])
        for theme in ("light", "dark"):
            uri = f"/generated/{self.arguments[0]}.{theme}.svg"
            figure += nodes.image(uri=uri, alt=self.options["alt"], classes=[f"only-{theme}"])
        parsed = nodes.Element()
        self.state.nested_parse(self.content, self.content_offset, parsed)
        figure += nodes.caption(
            "", "", *(part for text in parsed.children for part in text.children)
        )
        return [figure]
