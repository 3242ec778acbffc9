"""Made while the site is built: the reference, from code; the gallery, by running it; tables of what was measured."""

import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
sys.path.append(str(HERE.parents[1]))

import gallery  # noqa: E402  (beside this file, which is no package)
import reference  # noqa: E402

from validation import pages, rows  # noqa: E402

rows.all_rows()  # now: mkdocs takes back what was added to sys.path once this module is imported


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and pictures that are made."""
    made: dict[str, str | bytes] = {**reference.pages(), **gallery.pages(HERE.parent / "gallery")}
    for path, content in made.items():
        files.append(File.generated(config, path, content=content))
    _put_gallery_into_nav(config.nav, [path for path in made if path.startswith("gallery/") and path.endswith(".md")])
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the tables of what was measured into a page."""
    return pages.with_tables(markdown) if page.file.src_uri.startswith("validation/") else markdown


def _put_gallery_into_nav(nav: Any, pages: list[str]) -> None:
    for entry in nav:
        if "Gallery" in entry:
            entry["Gallery"] = pages
