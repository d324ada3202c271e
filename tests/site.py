"""The built site: every link and picture leads somewhere, formulas are formulas, and nothing comes
from a network.

Run: python -m tests.site folder, after python -m sphinx docs folder. Where Chromium is installed it
opens every page, without a network, and finds pictures that are not drawn and formulas without
extent. Exit status: 0 all right, 1 if not.
"""

from __future__ import annotations

import functools
import html
import json
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

LATEX = re.compile(
    r"\\(?:frac|tfrac|sqrt|sum|int|iint|mathbf|mathrm|cdot|left|right|begin|nu|pi|phi|varphi|le|ge)\b|\$\$"
)
SILENT = {"pre", "code", "script", "style", "math", "svg"}
"""Elements in which text is not prose."""
RESOURCES = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src"}
SECONDS = 300
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


class Page(HTMLParser):
    """What a page has and needs."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.links: list[str] = []
        self.resources: list[str] = []
        self.pictures = 0
        self.prose: list[str] = []
        self._silent = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.names |= {given[name] for name in ("id", "name") if name in given}
        self._silent += tag in SILENT
        self.pictures += tag == "img"
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if (
            tag in RESOURCES
            and given.get(RESOURCES[tag])
            and given.get("rel") not in ("canonical", "index", "search")
        ):
            self.resources.append(given[RESOURCES[tag]])

    def handle_endtag(self, tag: str) -> None:
        self._silent -= tag in SILENT

    def handle_data(self, data: str) -> None:
        if not self._silent:
            self.prose.append(data)


def faults(folder: Path) -> Iterator[str]:
    """What is wrong with a site, in words."""
    pages = {path.resolve(): Page(path.read_text()) for path in sorted(folder.rglob("*.html"))}
    for path, page in pages.items():
        name = path.relative_to(folder.resolve())
        for link in page.links:
            yield from (f"{name}: the link {link} {fault}" for fault in broken(path, link, pages))
        for resource in page.resources:
            yield from (f"{name}: {resource} {fault}" for fault in missing(path, resource))
        if any("\n: " in each for each in page.prose):
            yield f"{name}: a definition list that was not rendered"
        for latex in LATEX.findall(" ".join(page.prose)):
            yield f"{name}: {latex} stands in the text, a formula that was not converted"
        if (
            name.parent.name == "gallery"
            and name.name != "theories_bank.html"
            and not page.pictures
        ):
            yield f"{name}: there is no picture"


def broken(path: Path, link: str, pages: dict[Path, Page]) -> Iterator[str]:
    """What is wrong with a link, if it leads within the site."""
    parts = urlsplit(html.unescape(link))
    if parts.scheme or parts.netloc:
        return
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if not target.is_file():
        yield "leads to no file"
    elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].names:
        yield "leads to no such place on its page"


def missing(path: Path, resource: str) -> Iterator[str]:
    """What is wrong with a picture, a script or a style of a page."""
    parts = urlsplit(html.unescape(resource))
    if parts.scheme == "data":
        return
    if parts.scheme or parts.netloc:
        yield "needs a network"
    elif not (path.parent / unquote(parts.path)).is_file():
        yield "is not there"


OPEN_ALL = (Path(__file__).parent / "data" / "open_all.html").read_text()


def faults_in_browser(folder: Path, browser: str) -> Iterator[str]:
    """What a browser finds wrong on any page."""
    addresses = [f"/{path.relative_to(folder)}" for path in sorted(folder.rglob("*.html"))]
    addresses = [each for each in addresses if "/_modules/" not in each and "/_static/" not in each]
    page = OPEN_ALL.replace("PAGES", json.dumps(addresses))
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch,
        Serving(folder, page) as site,
    ):
        options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={scratch}"]
        offline = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"
        words = [
            browser,
            *options,
            offline,
            "--remote-debugging-port=0",
            f"{site.address}/open-all",
        ]
        opened = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            answer = site.answer.get(timeout=SECONDS)
        except queue.Empty:
            yield f"{browser} did not open all pages in {SECONDS} s"
            return
        finally:
            opened.terminate()
            opened.wait()
    for address, found in answer.items():
        yield from (f"{address[1:]}, opened: {fault}" for fault in found)


class Serving:
    """A server of a folder, with one page more, which sends an answer; as long as it is entered."""

    def __init__(self, folder: Path, page: str) -> None:
        self.answer: queue.Queue[dict[str, list[str]]] = queue.Queue()
        answer = self.answer

        class Handler(SimpleHTTPRequestHandler):
            def do_GET(self) -> None:
                if self.path == "/open-all":
                    self.reply(page.encode())
                else:
                    super().do_GET()

            def do_POST(self) -> None:
                answer.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
                self.reply(b"")

            def reply(self, text: bytes) -> None:
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(text)

            def log_message(self, *words: object) -> None:
                pass

        self.server = ThreadingHTTPServer(
            ("127.0.0.1", 0), functools.partial(Handler, directory=str(folder))
        )
        self.address = f"http://127.0.0.1:{self.server.server_port}"

    def __enter__(self) -> Serving:
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *what: object) -> None:
        self.server.shutdown()
        self.server.server_close()


def main(folder: str) -> int:
    """Say what is wrong; the exit status."""
    root = Path(folder)
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    found = list(faults(root))
    if browser:
        found += faults_in_browser(root, browser)
    print("\n".join(found) if found else f"{len(list(root.rglob('*.html')))} pages are in order")
    print(
        f"opened in {browser}" if browser else "no browser is installed: the pages were not opened"
    )
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
