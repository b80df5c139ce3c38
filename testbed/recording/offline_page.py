"""The viewer's page for a browser that may talk to this machine alone.

The page of rerun 0.41 asks for a font, for the newest version and reports its use, and offers no setting against it. So
it is passed on with a content security policy, by which the browser itself refuses every other host.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

LOOPBACK = "127.0.0.1"
_OUTSIDE_LINK = re.compile(rb"<link\b[^>]*https://[^>]*>")
"""Fonts, and hints to look up their hosts, which no policy covers."""
_PASSED_ON = ("Content-Type", "rerun-final-length")  # the latter tells the page how far its program is loaded


@contextmanager
def offline_page(port: int, data_port: int) -> Iterator[int]:
    """Serve a viewer's page through a local proxy with a content security policy, until the block ends.

    Args:
        port: at which the viewer serves its page on this machine.
        data_port: at which it serves the recording.

    Yields:
        The port of the proxy.
    """

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            _pass_on(self, port, data_port)

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - the name that http.server gives it
            """Say nothing: the terminal is the user's."""

    with ThreadingHTTPServer((LOOPBACK, 0), Handler) as server:
        server.daemon_threads = True
        Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield int(server.server_address[1])
        finally:
            server.shutdown()


def policy(data_port: int) -> str:
    """Return a content security policy that allows this page and the recording only."""
    return (
        "default-src 'self' data: blob:; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; "
        f"style-src 'self' 'unsafe-inline'; connect-src 'self' http://{LOOPBACK}:{data_port} data: blob:"
    )


def _pass_on(request: BaseHTTPRequestHandler, port: int, data_port: int) -> None:
    viewer = HTTPConnection(LOOPBACK, port, timeout=30.0)
    try:
        viewer.request("GET", request.path)
        answer = viewer.getresponse()
        page = answer.read() if answer.headers.get_content_type() == "text/html" else None
        request.send_response(answer.status)
        for name in _PASSED_ON:
            if name in answer.headers:
                request.send_header(name, answer.headers[name])
        request.send_header("Content-Security-Policy", policy(data_port))
        request.end_headers()
        if page is None:
            shutil.copyfileobj(answer, request.wfile)
        else:
            request.wfile.write(_OUTSIDE_LINK.sub(b"", page))
    except (BrokenPipeError, ConnectionError):  # the viewer is not there yet, or the browser went away
        request.close_connection = True
    finally:
        viewer.close()
