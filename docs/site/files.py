"""The pages of the site are the files of the repository, in its folders, so that their links hold: a hook of mkdocs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
PAGES = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "docs/howto/*.md", "crates/*/README.md",
         "examples/*/README.md", "lab/README.md", "lab/*/README.md", "lab/results/*.md", "tests/*/README.md"]  # fmt: skip
LINK = re.compile(r"(!?\[[^\]\n]*\])\(([^)#\s]+)(#[^)\s]*)?\)")


def on_files(files: Files, config: Any) -> Files:
    """Adds the pages, and every file of the repository that one of them links to."""
    pages = {path.relative_to(ROOT).as_posix() for pattern in PAGES for path in sorted(ROOT.glob(pattern))}
    linked = set()
    for page in pages:
        for _, link, _ in LINK.findall((ROOT / page).read_text(encoding="utf-8")):
            target = (ROOT / page).parent / link
            if "://" not in link and target.is_file() and target.resolve().is_relative_to(ROOT):
                linked.add(target.resolve().relative_to(ROOT).as_posix())
    for notebook in ROOT.glob("examples/08_notebooks/*.ipynb"):
        linked.add(notebook.relative_to(ROOT).as_posix())
    for name in sorted(pages | linked):
        files.append(File.generated(config, name, abs_src_path=str(ROOT / name)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """A link to a folder is its page, where it has one, else its name; so is one to an item of rustdoc. Pages of docs/site stand at the root."""
    if not (ROOT / page.file.src_uri).is_file():
        markdown = markdown.replace("](../../", "](")

    def named(match: re.Match[str]) -> str:
        words, link, anchor = match.groups()
        if "::" in link:
            return words[1:-1]
        folder = ROOT / Path(page.file.src_uri).parent / link
        if "://" in link or not folder.is_dir():
            return match.group(0)
        if (folder / "README.md").is_file():
            return f"{words}({link.rstrip('/')}/README.md{anchor or ''})"
        return words[1:-1]

    return LINK.sub(named, markdown)


def on_post_build(config: Any) -> None:
    """Puts what `cargo doc` made beside the pages."""
    there, made = Path(config["site_dir"]) / "rustdoc", ROOT / "target" / "doc"
    if made.is_dir() and not there.exists():
        there.symlink_to(made, target_is_directory=True)
