"""The gallery: each script is run, and its text, code, output and figures become a page."""

import ast
import contextlib
import io
import os
import shutil
import tempfile
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[2]


def pages(scripts: Path) -> dict[str, str | bytes]:
    """Return the gallery's pages and pictures by path, its index first.

    Raises
    ------
    RuntimeError
        When a script has no docstring, or makes no figure.
    """
    mpl.use("Agg")
    made: dict[str, str | bytes] = {}
    cards = []
    for script in sorted(scripts.glob("*.py")):
        name = script.stem.partition("_")[2].replace("_", "-")
        title, text, code = _parts(script)
        output, pictures = _run(code, script)
        if not pictures:
            raise RuntimeError(f"{script.name} makes no figure")
        paths = [f"gallery/{name}-{number}.svg" for number in range(1, len(pictures) + 1)]
        made.update(zip(paths, pictures, strict=True))
        shown = "\n\n".join(f"![{title}]({Path(path).name})" for path in paths)
        printed = f"\n```text\n{output.rstrip()}\n```\n" if output.strip() else ""
        made[f"gallery/{name}.md"] = f"# {title}\n\n{text}\n\n```python\n{code.strip()}\n```\n{printed}\n{shown}\n"
        first, picture = text.partition("\n\n")[0], f"![{title}]({name}-1.svg)"
        cards.append(f"## [{title}]({name}.md)\n\n{first}\n\n[{picture}]({name}.md)\n")
    head = f"# Gallery\n\n{len(cards)} pages, whose code ran and whose figures were drawn when the site was built.\n\n"
    return {"gallery/index.md": head + "\n".join(cards), **made}


def _parts(script: Path) -> tuple[str, str, str]:
    """Title, text and code of a script."""
    source = script.read_text(encoding="utf-8")
    tree = ast.parse(source)
    docstring = ast.get_docstring(tree)
    if not docstring:
        raise RuntimeError(f"{script.name} has no docstring")
    title, _, text = docstring.partition("\n\n")
    first = tree.body[0].end_lineno or 0
    return title.rstrip("."), text, "\n".join(source.splitlines()[first:])


def _run(code: str, script: Path) -> tuple[str, list[str]]:
    """Run a script in a folder with the shipped missions; return what it prints, and its figures as SVG."""
    plt.close("all")
    printed = io.StringIO()
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "missions", Path(folder) / "missions")
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(printed):
                exec(compile(code, str(script), "exec"), {"__name__": "__main__"})
        finally:
            os.chdir(before)
    figures = [_svg(plt.figure(number)) for number in plt.get_fignums()]
    plt.close("all")
    return printed.getvalue(), figures


def _svg(figure: "plt.Figure") -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg", facecolor="white", bbox_inches="tight")
    return text.getvalue()
