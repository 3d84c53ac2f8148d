#!/usr/bin/env python3
"""The page of collidectl view in a headless browser, on a live cloth_ball: what it shows is what the daemon found.

With COLLIDED_PICTURES=FOLDER the screenshots stay there.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

from viewer_support import COLLIDECTL, ViewerCase, main

REPOSITORY = pathlib.Path(sys.argv[3]).resolve()
TOOLS = REPOSITORY / "build" / "tools" / "viewer"


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


LINE = re.compile(r"frame (\d+)[^\n]*?: (\d+) contacts \((\d+) vt, (\d+) ee")
BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
if not shutil.which("node"):
    skip("Node is not installed")
if not (TOOLS / "installed-with-tests.json").exists():
    skip("what client/viewer is tested with is not installed (client/viewer/build --with-tests)")


def run(*words, **options):
    done = subprocess.run([str(word) for word in words], text=True, capture_output=True, timeout=200, **options)
    assert done.returncode == 0, f"{words}:\n{done.stdout}{done.stderr}"
    return done.stdout


class Sources(ViewerCase):
    def test_the_types_fit(self):
        folder = pathlib.Path(self.local.name) / "viewer"
        shutil.copytree(REPOSITORY / "client" / "viewer", folder, ignore=shutil.ignore_patterns("node_modules"))
        (folder / "node_modules").symlink_to(TOOLS / "node_modules")
        run("node", TOOLS / "node_modules" / "typescript" / "bin" / "tsc", "-p", folder)

    def test_the_lock_file_names_no_registry(self):
        self.assertNotIn('"resolved"', (REPOSITORY / "client" / "viewer" / "package-lock.json").read_text())

    def test_the_page_is_one_file_that_may_load_nothing(self):
        page = built_page(self).read_text()
        self.assertIn("default-src 'none'; script-src 'sha256-", page)
        self.assertEqual(re.findall(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(?!data:)', page), [])


def built_page(case):
    page = pathlib.Path(case.local.name) / "viewer.html"
    run("node", REPOSITORY / "client" / "viewer" / "bundle.js", TOOLS, page)
    return page


class Page(ViewerCase):
    def setUp(self):
        if not BROWSER:
            self.skipTest("chromium is not installed (Debian: chromium)")

    def start(self, *words, stdout=subprocess.PIPE):
        process = subprocess.Popen([str(word) for word in words], stdin=subprocess.PIPE, stdout=stdout,
                                   stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        for pipe in filter(None, (process.stdin, process.stdout)):
            self.addCleanup(pipe.close)
        return process

    def test_it_shows_a_live_scene(self):
        pictures = os.environ.get("COLLIDED_PICTURES") or self.local.name
        pathlib.Path(pictures).mkdir(parents=True, exist_ok=True)
        lines = pathlib.Path(self.local.name) / "lines"
        with open(lines, "w") as file:  # one for each frame, as its sender recorded it
            stream = self.start(COLLIDECTL, "stream", "--scene", "cloth_ball", "--scale", "0.3", "--t0", "0.5", "--dt", "0.0004",
                                "--mode", "dcd", "--thickness", "0.004", "--frames", "100000", "--server", self.server,
                                "--record", "/dev/null", stdout=file)
        secret = pathlib.Path(self.local.name) / "secret"
        secret.write_text("0123456789abcdef")
        page = str(built_page(self))
        viewer = self.view("--server", self.server, "--rate", "8", "--secret-file", str(secret), page=page)
        browser = self.start("node", REPOSITORY / "tests" / "client" / "viewer" / "page.mjs", TOOLS, BROWSER, viewer.url, pictures)
        seen = json.loads(browser.stdout.readline())
        self.assertNotIn("failed", seen, seen)
        self.assertEqual(seen["errors"], [])
        self.check_shown(seen)
        self.daemon.process.kill()
        self.assertNotEqual(stream.wait(60), 0)
        self.check_counts(seen, lines.read_text())
        browser.stdin.write("\n")
        browser.stdin.flush()
        end = json.loads(browser.stdout.readline())
        self.assertIn("Nothing comes from the daemon", end["status"])
        self.assertEqual(end["errors"], [])
        viewer.interrupt()
        self.assertIn("collidectl does not answer", json.loads(browser.stdout.readline())["status"])
        self.view("--scene", "reef_knot", "--scale", "0.2", "--backend", "cpu", "--listen", urllib.parse.urlsplit(viewer.url).netloc,
                  "--secret-file", str(secret), page=page)
        self.assertEqual(json.loads(browser.stdout.readline())["status"], "Live")

    def check_shown(self, seen):
        self.assertEqual(seen["name"], "cloth_ball")
        self.assertRegex(seen["facts"], r"^[\d,]+ triangles · [\d,]+ vertices · DCD · certified · CPU")
        self.assertEqual(seen["live"]["status-text text"], "Live")
        self.assertEqual(seen["live"]["contacts text"], f"{seen['live']['contacts']:,}")
        self.assertGreater(seen["live"]["contacts"], 0)
        self.assertGreater(seen["pixels"]["colors"], 500)
        self.assertGreater(seen["pixels"]["drawn"], 0.05)
        self.assertEqual(seen["nothing_visible"]["drawn"], 0)
        paused = seen["paused"]
        self.assertEqual(paused["status-text text"], "Paused")
        self.assertEqual(seen["still_paused"], paused)
        self.assertEqual(seen["newest"], paused)
        self.assertLess(seen["oldest"]["frame"], seen["one_back"]["frame"])
        self.assertLess(seen["one_back"]["frame"], paused["frame"])
        self.assertGreater(seen["again"]["frame"], paused["frame"])

    def check_counts(self, seen, lines):
        """The page's counts are those of the frame that it names, as its sender got them."""
        sent = {int(frame): [int(number) for number in numbers] for frame, *numbers in LINE.findall(lines)}
        for at in ("live", "paused", "one_back", "oldest", "again"):
            page = seen[at]
            self.assertEqual([page["contacts"], page["vertex_triangle"], page["edge_edge"]], sent[page["frame"]], at)


if __name__ == "__main__":
    main()
