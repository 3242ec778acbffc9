"""What may be wrong in what a study has written: each check raises AssertionError."""

import json
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import yaml

from .hostile_names import MARK

_TAGS = frozenset(
    ["html", "head", "meta", "link", "title", "style", "body", "main", "div", "header", "p", "h1", "h2", "figure", "figcaption", "dl", "dt", "dd", "section", "table", "caption", "thead", "tbody", "tr", "th", "td", "pre", "ul", "li", "code", "details", "summary", "script", "svg", "g", "path", "rect", "defs", "use", "text", "tspan", "clippath", "image", "lineargradient", "stop", "small", "b", "br", "img", "span", "pattern", "circle", "nav", "ol", "a", "polygon", "polyline"]
)  # fmt: skip
_SCRIPTED = ("on", "src", "srcdoc", "formaction", "action")


class _Page(HTMLParser):
    """Counts live tags and attributes, and keeps the ids and the text."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: Counter[str] = Counter()
        self.attributes: Counter[str] = Counter()
        self.ids: list[str] = []
        self.targets: set[str] = set()
        self.abroad: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag, attributes) -> None:
        self.tags[tag] += 1
        for name, value in attributes:
            self.attributes[name] += not (name == "src" and str(value).startswith("data:image/"))
            if name == "id":
                self.ids.append(value)
            if name in ("href", "xlink:href") and (value or "").startswith("#"):
                self.targets.add(value[1:])
            elif tag == "a" and name == "href":
                self.abroad.append(value)

    def handle_data(self, data) -> None:
        self.words.append(data)


def look_at_page(html: str) -> _Page:
    """Check that a page has no tag, attribute or id but its own."""
    page = _Page()
    page.feed(html)
    page.close()
    assert page.tags.keys() <= _TAGS, page.tags.keys() - _TAGS
    scripted = [name for name in +page.attributes if name.startswith(_SCRIPTED) or MARK in name]
    assert not scripted, scripted
    assert page.tags["script"] == 1, page.tags["script"]
    twice = [name for name, count in Counter(page.ids).items() if count > 1 or any(mark in name for mark in " <>\"'&")]
    assert not twice, twice[:3]
    assert not page.abroad, page.abroad
    assert page.targets <= set(page.ids), page.targets - set(page.ids)
    return page


def look_at_file(name: str, content: bytes) -> None:
    """Check that a file is well formed in its language."""
    if name.endswith((".svg", ".kml", ".gpx", ".xml")):
        root = ElementTree.fromstring(content)
        assert not [each for each in root.iter() if MARK in str(each.tag) or any(MARK in key for key in each.attrib)]
    elif name.endswith((".json", ".geojson")):
        json.loads(content, parse_constant=_no_number)
    elif name.endswith(".html"):
        look_at_page(content.decode())
    elif name.endswith((".yaml", ".yml")):
        yaml.safe_load(content)


def look_at_folder(folder: Path, data: object) -> None:
    """Check every file of a report: well formed, in its folder, the mission the same when it is read back."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert {path.relative_to(folder).parent.as_posix() for path in files} <= {".", "figures", "schema"}
    for path in files:
        look_at_file(path.name, path.read_bytes())
    assert yaml.safe_load((folder / "mission.yaml").read_text(encoding="utf-8")) == data


def _no_number(text: str) -> None:
    raise AssertionError(f"{text} is no JSON")
