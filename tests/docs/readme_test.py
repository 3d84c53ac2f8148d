#!/usr/bin/env python3
"""README.md and the pages it leads to, as a new user reads them: programs and command lines are run against a daemon.

usage: readme_test.py DAEMON COLLIDECTL CPP_EXAMPLE REPOSITORY
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

DAEMON, COLLIDECTL, CPP_EXAMPLE = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
REPOSITORY = pathlib.Path(sys.argv[4]).resolve()
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import README_SOCKET, run_python  # noqa: E402

README, EXAMPLES, ACCURACY = (Page(REPOSITORY / page) for page in ("README.md", "client/EXAMPLES.md", "proto/ACCURACY.md"))
# Appended to command lines to make them smaller than a new user's, so that the test is quick.
SMALLER = {
    "tradeoff --scene": "--scale 0.2 --repeats 1 --levels fast,exact --formats f32",
    "tradeoff before.ply": "--repeats 1 --levels fast,exact --formats f32",
    "bench --scene": "--scale 0.2 --steps 1 --warm-up 0",
    "stream --scene": "--scale 0.3",
    "export --scene": "--scale 0.3",
}
NOT_RUN = {
    "view --scene": "serves until it is interrupted; client.viewer.* run it",
    "bench --end-to-end": "a minute; collidectl_end_to_end runs it, smaller",
    "info --server gpu-host": "another host; integration.collidectl_security has TLS and tokens",
}


class WithDaemon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(str(DAEMON))
        cls.addClassCleanup(cls.daemon.kill)
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)

    def run_line(self, line):
        """Like a shell in the test's own folder, with the programs on its path."""
        path = f"{DAEMON.parent}:{COLLIDECTL.parent}:{os.environ['PATH']}"
        done = subprocess.run(["bash", "-c", line], cwd=self.folder, text=True, capture_output=True, timeout=120,
                              env={**os.environ, "PATH": path, "COLLIDED_DAEMON": str(DAEMON)})
        self.assertEqual(done.returncode, 0, f"{line}\n{done.stdout}{done.stderr}")
        return done.stdout


class Python(WithDaemon):
    def test_the_lines_make_stubs_that_the_example_runs_with(self):
        try:
            import grpc  # noqa: F401
            import numpy  # noqa: F401
        except ImportError as missing:
            self.skipTest(f"{missing} (Debian: python3-grpcio, python3-numpy)")
        (self.folder / "proto").symlink_to(REPOSITORY / "proto")
        install, *lines, run = EXAMPLES.blocks(after="Python, with nothing but stubs")[0].splitlines()
        self.assertTrue(install.startswith("apt-get install "))
        self.assertEqual(run, "PYTHONPATH=stubs python3 example.py")
        for line in lines:
            self.run_line(line)
        (program,) = EXAMPLES.blocks("python", after="Python, with nothing but stubs")
        printed = run_python(program, self.daemon.address, self.folder / "stubs")
        self.assertEqual(printed, "vertex 3, triangle 0, t = 0.500000000\n")
        self.assertIn(f"# {printed}", program)


class Cpp(WithDaemon):
    def test_the_examples_compile_and_find_the_contact(self):
        done = subprocess.run([CPP_EXAMPLE], text=True, capture_output=True, timeout=60,
                              env={**os.environ, "COLLIDED_SERVER": self.daemon.address})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, "vertex 3, triangle 0, t = 0.5\nafter a resume: 1 vertex-triangle contacts\n"
                                      "flat: 0 contacts\nfolded: many\n")


TETRAHEDRON = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
0 0 1
3 0 2 1
3 0 1 3
3 1 2 3
3 2 0 3
"""


class CommandLines(WithDaemon):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        frames = cls.folder / "frames_of_the_test"
        subprocess.run([COLLIDECTL, "export", "--scene", "funnel", "--scale", "0.3", "--frames", "2", "--t0", "0.5",
                        "--out", frames], check=True, stdout=subprocess.DEVNULL, timeout=60)
        for name, frame in zip(("before", "after"), sorted(frames.glob("*.ply"))):
            shutil.copy(frame, cls.folder / f"{name}.ply")
        shutil.copy(cls.folder / "before.ply", cls.folder / "ball.ply")
        (cls.folder / "mesh.ply").write_text(TETRAHEDRON)
        table = REPOSITORY / "tests" / "support" / "mesh_files" / "table.py"
        subprocess.run([sys.executable, table, cls.folder / "table"], check=True)
        for name, source in (("box.obj", "tent_lf.obj"), ("ball.stl", "cube.stl"), ("box.glb", "plain.glb")):
            shutil.copy(cls.folder / "table" / source, cls.folder / name)
        (cls.folder / "client").symlink_to(REPOSITORY / "client")

    def lines(self, program):
        blocks = (block for page in (README, EXAMPLES, ACCURACY) for block in page.blocks())
        for line in (line for block in blocks for line in block.splitlines()):
            if line.startswith(f"{program} "):
                yield line.split(" #")[0].split("   ")[0].strip()

    def collidectl_lines(self):
        return self.lines("collidectl")

    def test_every_line_of_collidectl_runs(self):
        lines = list(self.collidectl_lines())
        self.assertGreater(len(lines), 9)
        for line in lines:
            rest = line.removeprefix("collidectl ")
            if any(rest.startswith(start) for start in NOT_RUN):
                continue
            more = next((options for start, options in SMALLER.items() if rest.startswith(start)), "")
            with self.subTest(line):
                self.assertTrue(self.run_line(f"{line} {more}".replace(README_SOCKET, self.daemon.address)))

    def test_the_picture_is_drawn_from_what_tradeoff_wrote(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError as missing:
            self.skipTest(f"{missing} (Debian: python3-matplotlib)")
        (measure,) = (line for line in self.collidectl_lines() if "tradeoff before.ply" in line)
        (plot,) = self.lines("client/measure/plot")
        self.run_line(f"{measure} {SMALLER['tradeoff before.ply']}")
        (picture,) = self.run_line(f"{sys.executable} {plot}").splitlines()
        self.assertTrue((self.folder / picture).exists())

    def test_each_exception_has_its_line(self):
        rests = [line.removeprefix("collidectl ") for line in self.collidectl_lines()]
        for start in [*NOT_RUN, *SMALLER]:
            self.assertTrue(any(rest.startswith(start) for rest in rests), start)

    def test_the_daemons_lines_serve_and_check(self):
        path, check, folder, serve = README.blocks(after="## The daemon")[0].splitlines()
        for part in path.removeprefix("PATH=").split(":")[:-1]:
            within_build = "/".join(part.split("/")[3:])  # $PWD/build/PRESET/...
            self.assertTrue(any(str(p.parent).endswith("/" + within_build) for p in (DAEMON, COLLIDECTL)), part)
        (self.folder / "deploy").symlink_to(REPOSITORY / "deploy")
        self.run_line(check)
        # The test's own folder and ports.
        ours = [re.sub(r":(50551|9464)\b", ":0", line.removeprefix("sudo ").replace("/run/collided", str(self.folder / "run")))
                for line in (folder, serve)]
        self.run_line(ours[0])
        daemon = subprocess.Popen([DAEMON, *shlex.split(ours[1])[1:]], stderr=subprocess.PIPE, text=True)
        self.addCleanup(daemon.stderr.close)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        self.assertTrue(any("metrics and health on" in line for line in daemon.stderr), "it did not serve")
        daemon.terminate()
        self.assertEqual(daemon.wait(60), 0)

    def test_the_two_commands_have_help(self):
        block = README.blocks(after="## Two commands")[0]
        for line in block.splitlines():
            command = shlex.split(line.split("#")[0])[0]
            done = subprocess.run([REPOSITORY / command, "--help"], text=True, capture_output=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"usage: {command}", done.stdout)


class Links(unittest.TestCase):
    PAGES = sorted(path for path in REPOSITORY.rglob("*.md")
                   if not {"build", "bundle", "node_modules"} & {part.split("-")[0] for part in path.relative_to(REPOSITORY).parts})

    def test_every_link_of_every_page_leads_somewhere(self):
        for page in self.PAGES:
            # A change becomes a line of CHANGELOG.md.
            folder = REPOSITORY if page.parent == REPOSITORY / "deploy" / "changes" else page.parent
            text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
            for target in re.findall(r"\]\(([^)\s]+)\)", text):
                if "://" in target:
                    continue
                path, _, anchor = target.partition("#")
                file = (folder / path).resolve() if path else page
                with self.subTest(page=str(page.relative_to(REPOSITORY)), link=target):
                    self.assertTrue(file.exists())
                    if anchor:
                        self.assertIn(anchor, self.anchors(file))

    def anchors(self, file):
        headings = re.findall(r"^#+ (.+)$", file.read_text(), re.MULTILINE)
        return [re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings]


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
