"""Pages of the site that are not below ``docs``: the files of the repository that the guides link to.

On the site README.md, CONTRIBUTING.md, SECURITY.md and CHANGELOG.md are pages as the guides are, and a link to any
other file or folder of the repository leads to a page that shows it. A link to a file that does not exist stays as it
is, and fails the strict build.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parent.parent.parent

_NAMED = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "CHANGELOG.md": "changelog.md",
}
_LANGUAGES = {".py": "python", ".toml": "toml", ".ini": "ini", ".json": "json", "": "make"}
_HIDDEN = "---\nsearch:\n  exclude: true\nhide: [toc, navigation]\n---"
_LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#|/)([^)#\s]+)(#[^)\s]*)?(?=\))")
_FENCE = re.compile(r"^\s*(```+)", re.MULTILINE)

_repository_paths: dict[str, str] = {}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """List the decisions in the navigation, in their order."""
    decisions = sorted(path.name for path in (ROOT / "docs" / "decisions").glob("*.md"))
    for section in config.nav or ():
        if "Decisions" in section:
            section["Decisions"] = [f"decisions/{name}" for name in decisions]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are linked to, and those that these link to."""
    _repository_paths.clear()
    _repository_paths.update({file.src_uri: f"docs/{file.src_uri}" for file in files.documentation_pages()})
    waiting = [*_repository_paths.values(), *_NAMED]
    while waiting:
        path = waiting.pop()
        uri = _site_path(path)
        if files.get_file_from_path(uri) is None:
            files.append(File.generated(config, uri, content=_page(path)))
            _repository_paths[uri] = path
        waiting += [target for target in _targets(path) if files.get_file_from_path(_site_path(target)) is None]
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Turn the links of the repository into those of the site."""
    path = _repository_paths[page.file.src_uri]
    here = posixpath.dirname(page.file.src_uri)

    def link(match: re.Match[str]) -> str:
        target = _resolved(path, match[1])
        if not (ROOT / target).exists():
            return match[0]
        return posixpath.relpath(_site_path(target), here or ".") + (match[2] or "")

    return "".join(text if is_code else _LINK.sub(link, text) for text, is_code in _split(markdown))


def _targets(path: str) -> Iterator[str]:
    """Yield the files of the repository that the file *path* links to."""
    if not path.endswith(".md"):
        return
    for text, is_code in _split((ROOT / path).read_text()):
        if not is_code:
            found = (_resolved(path, match[1]) for match in _LINK.finditer(text))
            yield from (target for target in found if (ROOT / target).exists())


def _resolved(path: str, link: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), link))


def _site_path(path: str) -> str:
    if path in _NAMED:
        return _NAMED[path]
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    if path.endswith(".md"):
        return f"code/{path}"
    return f"code/{path}/index.md" if (ROOT / path).is_dir() else f"code/{path}.md"


def _page(path: str) -> str:
    place = ROOT / path
    if path.endswith(".md"):
        return place.read_text()
    files = sorted(each for each in place.iterdir() if each.is_file()) if place.is_dir() else [place]
    shown = [_shown(each, title=place.is_dir()) for each in files]
    return "\n\n".join((_HIDDEN, f"# `{path}`", *shown))


def _shown(file: Path, *, title: bool) -> str:
    heading = f"## `{file.name}`\n\n" if title else ""
    return f'{heading}``````{{.{_LANGUAGES.get(file.suffix, "text")} linenums="1"}}\n{file.read_text()}\n``````'


def _split(markdown: str) -> Iterator[tuple[str, bool]]:
    """Yield *markdown* in pieces, each with whether it is in a fenced block of code."""
    start, fence = 0, ""
    for match in _FENCE.finditer(markdown):
        if fence and not match[1].startswith(fence):
            continue
        yield markdown[start : match.start()], bool(fence)
        start, fence = match.start(), "" if fence else match[1]
    yield markdown[start:], bool(fence)
