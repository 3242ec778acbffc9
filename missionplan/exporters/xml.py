"""XML that any text can be put into."""

import re
from xml.etree import ElementTree

Element = ElementTree.Element

_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def add(parent: Element, tag: str, text: str | None = None, **attributes: str) -> Element:
    """Add an element; characters that XML cannot hold are replaced."""
    child = ElementTree.SubElement(parent, tag, {name: mended(value) for name, value in attributes.items()})
    if text is not None:
        child.text = mended(text)
    return child


def mended(text: str) -> str:
    """Replace what XML cannot hold."""
    return _NOT_IN_XML.sub("\ufffd", text)


def document(root: Element, *comments: str) -> str:
    """Write a document, indented, with comments before its root."""
    ElementTree.indent(root, " ")
    before = "".join(f"<!-- {mended(comment).replace('--', '- -')} -->\n" for comment in comments)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{before}{ElementTree.tostring(root, encoding="unicode")}\n'
