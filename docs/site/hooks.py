"""Pages that are made while the site is built: the reference, from the code itself, and the gallery, by running it."""

import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import gallery  # noqa: E402  (beside this file, which is no package)
import reference  # noqa: E402


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and pictures that are made."""
    made: dict[str, str | bytes] = {**reference.pages(), **gallery.pages(HERE.parent / "gallery")}
    for path, content in made.items():
        files.append(File.generated(config, path, content=content))
    _put_gallery_into_nav(config.nav, [path for path in made if path.startswith("gallery/") and path.endswith(".md")])
    return files


def _put_gallery_into_nav(nav: Any, pages: list[str]) -> None:
    for entry in nav:
        if "Gallery" in entry:
            entry["Gallery"] = pages
