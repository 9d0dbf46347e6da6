"""Hooks of mkdocs: links from docs/ to files of the repository, and checks of the finished site.

A page may link to any file of the repository. The file is copied into the site, and the link is
adapted. The same Markdown then works in a source browser and in the site. Warnings end a strict
build: broken links and anchors, headers that do not exist, resources from the network.
"""
import html.parser
import logging
import os
import pathlib
import re
import urllib.parse

from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Pages of the site that lie outside docs/.
PAGES = {
    "readme.md": "README.md",
    "tutorials/examples.md": "examples/README.md",
    "developers/contributing.md": "CONTRIBUTING.md",
    "developers/changes.md": "CHANGELOG.md",
}

LINK = re.compile(r"(\]\()([^()\s#]+)((?:#[^()\s]*)?\))")
FENCE = re.compile(r"^ *(```|~~~)")
HEADER = re.compile(r"(?<![\w/.])dn/[a-z_/]+\.h\b")

log = logging.getLogger("mkdocs.hooks.site")


def outside_file(source, destination, config):
    """A file of the site at `destination` with the content of `source`, relative to ROOT."""
    file = File(destination, config["docs_dir"], config["site_dir"], use_directory_urls=False)
    file.abs_src_path = str(ROOT / source)
    return file


def on_files(files, config):
    for destination, source in PAGES.items():
        files.append(outside_file(source, destination, config))
    return files


def listed_pages(entries):
    """All pages of a navigation or of a part of it."""
    for entry in entries:
        for target in entry.values():
            yield from [target] if isinstance(target, str) else listed_pages(target)


def on_config(config):
    """Appends to each section the pages of its folder that the navigation does not list."""
    docs = pathlib.Path(config["docs_dir"])
    listed = set(listed_pages(config["nav"]))
    for section in config["nav"]:
        for title, entries in section.items():
            folder = docs / title.lower()
            if isinstance(entries, list) and folder.is_dir():
                others = {path.relative_to(docs).as_posix() for path in folder.glob("*.md")} - listed
                entries += [{first_heading(docs / page): page} for page in sorted(others)]
    return config


def first_heading(path):
    heading = re.search(r"^# (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return heading.group(1).replace("`", "") if heading else path.stem


def site_path(path, config, files):
    """Path in the site of an absolute path of the repository; None where there is no such file."""
    if not path.is_relative_to(ROOT) or not path.is_file():
        return None
    relative = path.relative_to(ROOT).as_posix()
    for file in files:
        if os.path.realpath(file.abs_src_path) == str(path):
            return file.src_path
    # A text that mkdocs would otherwise take for a page of the site.
    destination = f"source/{relative}" + (".txt" if path.suffix == ".md" else "")
    files.append(outside_file(relative, destination, config))
    return destination


def is_public_header(header):
    """Whether a layer has this header, as a file or made by CMake from a template."""
    places = (f"include/{header}", f"templates/{header.removeprefix('dn/')}.in")
    return any(any(ROOT.glob(f"{folder}/{place}")) for place in places for folder in ("*", "*/*"))


def on_page_markdown(markdown, page, config, files):
    folder = pathlib.Path(os.path.realpath(page.file.abs_src_path)).parent

    def adapted(link):
        path = pathlib.Path(os.path.normpath(folder / urllib.parse.unquote(link.group(2))))
        target = site_path(path, config, files)
        if target is None:
            return link.group()  # mkdocs reports it
        relative = os.path.relpath(target, os.path.dirname(page.file.src_path))
        return link.group(1) + relative + link.group(3)

    for header in sorted(set(HEADER.findall(markdown))):
        if not is_public_header(header):
            log.warning(f"{page.file.src_path} names {header}, which is not a public header")
    lines, in_code = [], False
    for line in markdown.split("\n"):
        if FENCE.match(line):
            in_code = not in_code
        lines.append(line if in_code else LINK.sub(adapted, line))
    return "\n".join(lines)


def on_page_content(content, page, config, files):
    # mkdocs would miss the pages of Doxygen, which are written later; a disk has no index of a folder.
    return re.sub(r'href="((?:\.\./)*api/)"', r'href="\1index.html"', content)


class Page(html.parser.HTMLParser):
    """The anchors, links and loaded resources of a page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.resources = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors.update(v for k, v in attributes.items() if k in ("id", "name") and v)
        if tag == "a" and attributes.get("href"):
            self.links.append(attributes["href"])
        elif tag in ("script", "img", "link", "iframe"):
            self.resources += [v for k, v in attributes.items() if k in ("src", "href") and v]


def on_post_build(config):
    site = pathlib.Path(config["site_dir"])
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    for path, page in pages.items():
        name = path.relative_to(site)
        for resource in page.resources:
            if urllib.parse.urlsplit(resource).netloc:
                log.warning(f"{name} loads {resource} from the network")
        for link in page.links:
            url = urllib.parse.urlsplit(link)
            target = pathlib.Path(os.path.normpath(path.parent / urllib.parse.unquote(url.path)))
            target = target if url.path else path
            if url.scheme or url.netloc or target not in pages or not url.fragment:
                continue
            if urllib.parse.unquote(url.fragment) not in pages[target].anchors:
                log.warning(f"{name} links to {link}, an anchor that does not exist")
