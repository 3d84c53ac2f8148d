#!/usr/bin/env python3
"""Who may look through collidectl view, and what hostile peers can do to it: nothing."""

import pathlib
import shutil
import socket as sockets
import subprocess
import time
import urllib.parse

from viewer_support import COLLIDECTL, PAGE, ViewerCase, main
from web_client import BINARY, WebSocket, connect, parse, read_all, request

SECRET = "0123456789abcdef-_XYZ"
MOST_CONNECTIONS, MOST_STRANGERS = 64, 256


class Access(ViewerCase):
    def setUp(self):
        self.session_ = self.session()
        self.session_.step()
        self.viewer = self.view_session(self.session_)
        self.url = self.viewer.url
        self.port = urllib.parse.urlsplit(self.url).port

    def expect_served(self):
        self.assertEqual(request(self.url)[0], 200)
        socket = WebSocket(self.url)
        socket.until("scene")
        socket.close()

    def status_of_socket(self, **headers):
        try:
            WebSocket(self.url, **headers).close()
            return 101
        except ConnectionRefusedError as refused:
            return refused.args[0]

    def test_the_page_is_served_for_this_browser_alone(self):
        status, headers, body = request(self.url)
        self.assertEqual((status, body.decode()), (200, PAGE))
        self.assertEqual(headers["content-type"], "text/html; charset=utf-8")
        self.assertEqual(headers["cache-control"], "no-store")
        self.assertEqual(headers["content-security-policy"], "frame-ancestors 'none'")
        self.assertEqual(headers["x-content-type-options"], "nosniff")
        self.assertEqual(headers["referrer-policy"], "no-referrer")
        self.assertNotIn("access-control-allow-origin", headers)
        status, headers, body = request(self.url, "HEAD")
        self.assertEqual((status, headers["content-length"], body), (200, str(len(PAGE)), b""))
        status, headers, _ = request(self.url, path=urllib.parse.urlsplit(self.url).path.rstrip("/"))
        self.assertEqual((status, headers["location"]), (301, urllib.parse.urlsplit(self.url).path))

    def test_without_the_secret_there_is_nothing(self):
        path = urllib.parse.urlsplit(self.url).path
        wrong = path[:-2] + ("0" if path[-2] != "0" else "1") + "/"
        for other in ("/", "/frames", wrong, path.upper() + "x", path[1:], "//" + path, "*", wrong + "frames", path + "../"):
            self.assertEqual(request(self.url, path=other)[0], 404, other)
        self.assertEqual(request(self.url, "POST")[0], 405)
        self.assertEqual(request(self.url, path=path + "frames")[0], 426)

    def test_other_websites_see_nothing(self):
        for host in ("evil.example", f"evil.example:{self.port}", "", "127.0.0.1.evil.example"):
            self.assertEqual(request(self.url, Host=host)[0], 403, host)
            self.assertEqual(self.status_of_socket(Host=host), 403, host)
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{self.port ^ 1}", ""):
            self.assertEqual(self.status_of_socket(Origin=origin), 403, origin)
        self.assertEqual(self.status_of_socket(Origin=None), 101)  # no browser
        tunnel = "localhost:9999"
        self.assertEqual(self.status_of_socket(Host=tunnel, Origin=f"http://{tunnel}"), 101)

    def test_what_is_no_http_is_refused(self):
        host = f"Host: 127.0.0.1:{self.port}\r\n"
        for sent in (b"\0\xff\x16\x03\1garbage\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"GET /" + 40000 * b"a",
                     f"GET / HTTP/1.1\r\n{host}X: {'x' * 100000}\r\n\r\n".encode(),
                     f"GET / HTTP/1.1\r\n{host}Content-Length: 99999999999\r\n\r\n".encode() + 4096 * b"x"):
            with connect(self.url) as peer:
                try:
                    peer.sendall(sent)
                except (BrokenPipeError, ConnectionResetError):
                    pass
                answer = read_all(peer)
            self.assertIn(answer[:12], (b"", b"HTTP/1.1 400", b"HTTP/1.1 404"), sent[:40])
        self.expect_served()

    def test_messages_that_no_page_sends_end_their_connection_alone(self):
        other = self.open(self.viewer)
        for sent, opcode, length, code in ((b"nexx", 1, None, 1008), (b"next", BINARY, None, 1008), (b"", 1, None, 1008),
                                           (b"x" * 17, 1, None, 1009), (b"", BINARY, 1 << 62, 1009), (b"x", 3, None, 1002),
                                           (b"\xff\xfe", 1, None, 1007)):
            socket = self.open(self.viewer)
            socket.send(sent, opcode, length=length)
            self.assertEqual(socket.until_closed(), code, (sent, opcode))
        unmasked = self.open(self.viewer)
        unmasked.peer.sendall(b"\x81\x04next")
        self.assertEqual(unmasked.until_closed(), 1002)
        cut = self.open(self.viewer)
        cut.peer.sendall(b"\x81")
        cut.peer.shutdown(sockets.SHUT_RDWR)
        pieces = self.open(self.viewer)
        for i in range(20):
            pieces.send(b"n", 1 if i == 0 else 0, is_last=False)
        self.assertEqual(pieces.until_closed(), 1009)
        other.until("scene")
        self.session_.step()
        other.until("frame")
        self.expect_served()

    def test_visitors_without_the_secret_keep_nobody_out(self):
        silent = [connect(self.url) for _ in range(MOST_STRANGERS + 20)]
        for peer in silent[:20]:  # the oldest gave way
            self.assertEqual(read_all(peer), b"")
        self.expect_served()
        half = silent[-1]
        half.sendall(b"GET /wrong/ HTTP/1.1\r\n")
        self.expect_served()
        half.sendall(f"Host: 127.0.0.1:{self.port}\r\n\r\n".encode())
        self.assertEqual(parse(read_all(half))[0], 404)
        for peer in silent:
            peer.close()

    def test_browsers_are_bounded_and_their_places_come_back(self):
        browsers = [self.open(self.viewer) for _ in range(MOST_CONNECTIONS)]
        self.assertEqual(request(self.url)[0], 503)
        self.assertEqual(self.status_of_socket(), 503)
        for browser in browsers:
            browser.close()
        deadline = time.monotonic() + 30
        while request(self.url)[0] == 503 and time.monotonic() < deadline:  # until it has noticed
            pass
        self.expect_served()


class Usage(ViewerCase):
    def expect_error(self, part, exit_code, *words):
        error, code = self.run_view(*words)
        self.assertEqual((code, error.count("\n")), (exit_code, 1), error)
        self.assertIn(part, error)

    def put(self, name, text):
        path = pathlib.Path(self.local.name) / name
        path.write_text(text)
        return str(path)

    def test_errors_name_what_is_wrong(self):
        page = ["--page", self.put("page.html", PAGE)]
        server = ["--server", self.server]
        self.expect_error("--server", 2, *page)
        self.expect_error("not both", 2, "0123", "--scene", "reef_knot", *page)
        self.expect_error("--listen 1.2.3.4:99999", 2, *server, *page, "--listen", "1.2.3.4:99999")
        self.expect_error("--rate", 2, *server, *page, "--rate", "nan")
        self.expect_error("--contacts", 2, *server, *page, "--contacts", "8193")
        self.expect_error("NOT_FOUND", 1, "0123", *server, *page)
        self.expect_error("--page", 1, *server, "--page", "/none")
        for secret in ("", "short", "two words of it", "x" * 129, "no/slashes/in/addresses"):
            self.expect_error("--secret-file", 1, *server, *page, "--secret-file", self.put("secret", secret))
        self.expect_error("/nonexistent: cannot be read", 1, *server, *page, "--secret-file", "/nonexistent")
        with sockets.create_server(("127.0.0.1", 0)) as taken:
            self.expect_error("in use", 1, *server, *page, "--listen", f"127.0.0.1:{taken.getsockname()[1]}")

    def test_of_several_scenes_one_must_be_named(self):
        first, second = self.session(), self.session()
        first.step(), second.step()
        error, code = self.run_view("--server", self.server, "--page", self.put("page.html", PAGE))
        self.assertEqual(code, 2, error)
        self.assertIn(first.scene.id, error)
        self.assertIn(second.scene.id, error)

    def test_an_address_that_others_can_reach_is_warned_of(self):
        session = self.session()
        session.step()
        viewer = self.view_session(session, "--listen", "0.0.0.0:0")
        self.assertIn("--listen lets other hosts reach the page", viewer.said())
        self.assertEqual(request(viewer.url)[0], 200)
        self.assertEqual(self.view_session(session).said(), "")

    def test_the_address_stays_with_a_secret_of_ones_own(self):
        session = self.session()
        session.step()
        secret = self.put("secret", SECRET + "\n")
        urls = [urllib.parse.urlsplit(self.view_session(session, "--secret-file", secret).url).path for _ in range(2)]
        self.assertEqual(urls, [f"/{SECRET}/"] * 2)
        other = urllib.parse.urlsplit(self.view_session(session).url).path
        self.assertEqual(len(other.strip("/")), 32)

    def test_a_page_that_is_not_built_is_said_to_be(self):
        copy = pathlib.Path(self.local.name) / "bin" / "collidectl"
        copy.parent.mkdir()
        shutil.copy2(COLLIDECTL, copy)
        done = subprocess.run([copy, "view", "--server", self.server], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("run client/viewer/build", done.stderr)


if __name__ == "__main__":
    main()
