"""collidectl: lists, bad usage and failures.

Usage: usage_test.py COLLIDECTL DAEMON"""

import csv
import json
import os
import signal
import subprocess
import tempfile

import support
from support import COLLIDECTL, DAEMON, ONE_CPU, FRAME0


class Usage(support.CollidectlTest):
    def test_scenes_are_listed(self):
        self.assertIn("cloth_ball", self.ok("scenes"))
        scenes = {s["name"]: s["triangles"] for s in json.loads(self.ok("scenes", "--json"))}
        self.assertEqual(scenes["cloth_ball"], 91872)

    def test_bad_usage(self):
        self.refused(2, "needs two frames", "detect", "--frames", self.frame0, "--mode", "ccd", *ONE_CPU)
        self.refused(2, "what was given stands still", "detect", self.frame0, self.frame1, "--mode", "ccd")
        self.refused(2, "one of MESH... and --frames", "detect")
        self.refused(2, "one of MESH... and --frames", "detect", self.frame0, "--frames", self.frame1)
        self.refused(2, "needs one frame", "detect", "--frames", self.frame0, self.frame1, "--mode", "dcd")
        self.refused(2, "--mode", "detect", self.frame0, "--mode", "maybe")
        self.refused(2, "--thickness", "detect", self.frame0, "--thickness", "-1")
        self.refused(2, "--delta", "detect", self.frame0, "--delta", "-1")
        self.refused(2, "--accuracy", "detect", self.frame0, "--accuracy", "perfect")
        self.refused(2, "--report", "stream", "--scene", "funnel", "--report", "most")
        for kinds in ("xx", "vt,xx"):
            self.refused(2, "--kinds", "detect", "--frames", self.frame0, self.frame1, "--kinds", kinds)
        for number in ("nan", "inf", "-inf"):
            self.refused(2, "--thickness", "detect", self.frame0, f"--thickness={number}")
            self.refused(2, "--delta", "detect", self.frame0, f"--delta={number}")
            self.refused(2, "--t0", "stream", "--scene", "funnel", f"--t0={number}")
            self.refused(2, "--dt", "stream", "--scene", "funnel", f"--dt={number}")
        self.refused(2, "a command is needed")
        for command in ("stream", "render", "export", "bench", "load", "estimate", "tradeoff", "view"):
            self.refused(2, "--scene: scene 'nothing' is not known; the scenes are funnel,", command, "--scene", "nothing")
        self.refused(2, "--threads", "detect", self.frame0, "--server", "x:1", "--threads", "2")

    def test_options_that_do_not_go_together(self):
        ccd = ["detect", "--frames", self.frame0, self.frame1]
        dcd = ["detect", self.frame0, "--mode", "dcd"]
        stream = ["stream", "--scene", "funnel"]
        self.refused(2, "--report earliest needs", *dcd, "--report", "earliest")
        self.refused(2, "--report earliest needs", *ccd, "--report", "earliest", "--accuracy", "fast")
        self.refused(2, "--report any needs", *stream, "--report", "any", "--accuracy", "candidates")
        self.refused(2, "--kinds tt needs", *stream, "--kinds", "vt,tt")
        self.refused(2, "--kinds vs needs --solid", *dcd, "--kinds", "vt,vs")
        for words in (ccd, stream, [*dcd, "--accuracy", "candidates"]):
            self.refused(2, "--solid needs --mode dcd and --accuracy fast", *words, "--solid")
        for words in (ccd, [*ccd, "--accuracy", "candidates"], [*dcd, "--accuracy", "candidates"]):
            self.refused(2, "--kinds et needs --mode dcd and --accuracy fast", *words, "--kinds", "vt,et")
        for words in (ccd, [*dcd, "--accuracy", "candidates"], [*dcd, "--report", "any"], [*dcd, "--kinds", "vt"],
                      [*dcd, "--part-devices", "cpu:0,cpu:0"]):
            self.refused(2, "--kept needs --mode dcd, --accuracy fast", *words, "--kept")
        self.refused(2, "--thickness greater than 0", *dcd, "--accuracy", "fast")
        for words in (dcd, [*ccd, "--accuracy", "fast"], [*stream, "--kinds", "vt"]):
            self.refused(2, "--advance needs --mode ccd, --accuracy certified or exact", *words, "--advance")
        self.refused(2, "--advance-mode requires --advance", *ccd, "--advance-mode", "per-mesh")
        self.refused(2, "--advance-mode", *ccd, "--advance", "--advance-mode", "each")
        self.refused(2, "--limits requires --advance", *ccd, "--limits")
        self.refused(2, "--min-separation requires --advance", *ccd, "--min-separation", "0.1")
        self.refused(2, "--min-separation", *ccd, "--advance", "--min-separation=-1")
        self.refused(2, "--end-to-end takes --position-format f32 or f64", "bench", "--end-to-end", "--position-format",
                     "q16")
        self.refused(2, "one of FRAME, --scene and --triangles", "estimate")
        self.refused(2, "one of FRAME, --scene and --triangles", "estimate", self.frame0, "--scene", "funnel")
        self.refused(2, "--scene", "estimate", self.frame0, "--scale", "2")

    def test_an_address_needs_a_port_that_there_is(self):
        for address in ("localhost:70000", "localhost:-1", "[::1]:0", "dns:///localhost:65536", "localhost"):
            for words in (["info"], ["detect", "--frames", self.frame0, self.frame1], ["watch", "x"]):
                self.refused(2, f"--server: address is '{address}', wh", *words, f"--server={address}")
                self.refused(2, "from 1 to 65535", *words, f"--server={address}")

    def test_outputs_are_different_files(self):
        ccd, scene = ["detect", "--frames", self.frame0, self.frame1], ["stream", "--scene", "funnel"]
        name = os.path.join(self.folder.name, "x.csv")
        for words in (["--out", name, "--vtp", name], ["--vtp", name, "--ply", name],
                      ["--out", name, "--ply", os.path.join(self.folder.name, ".", "x.csv")]):
            self.refused(2, f"{words[0]} and {words[2]} are two files", *ccd, *words)
        self.assertFalse(os.path.exists(name))
        self.refused(2, "--record and --out are two files", *scene, "--record", name, "--out", name)
        numbered = os.path.join(self.folder.name, "c_{frame}.x")
        self.refused(2, "--vtp and --ply are two files", *scene, "--vtp", numbered, "--ply", numbered)
        self.refused(2, "--out and the series of --vtp are two files", *scene, "--vtp", numbered, "--out",
                     os.path.join(self.folder.name, "c.pvd"))
        self.refused(2, "--out and --html are two files", "load", "--scene", "funnel", "--rate", "1", "--out", name, "--html", name)
        with open(name, "w", encoding="ascii"):
            link = os.path.join(self.folder.name, "link")
            os.symlink(name, link)
        self.refused(2, "--out and --vtp are two files", *ccd, "--out", name, "--vtp", link)
        self.ok(*ccd, *ONE_CPU, "--out", "/dev/null", "--vtp", "/dev/null")

    def test_no_input_is_overwritten(self):
        link = os.path.join(self.folder.name, "frame_0001.ply")
        os.symlink(self.frame1, link)
        numbered = link.replace("0001", "{frame}")
        for words in (["detect", "--out", self.frame0], ["detect", "--ply", link], ["stream", "--record", self.frame1],
                      ["stream", "--out", self.frame0], ["stream", "--ply", numbered], ["render", "--out", self.frame0]):
            self.refused(2, "would overwrite " + self.frame0[:-5], words[0], self.frame0, self.frame1, *words[1:])
        with open(self.frame0, encoding="ascii") as file:
            self.assertEqual(file.read(), FRAME0)

    def test_an_empty_value_is_not_none(self):
        ccd, scene = ["detect", "--frames", self.frame0, self.frame1], ["stream", "--scene", "funnel"]
        for words, option in ((["info"], "--server"), (ccd, "--out"), (ccd, "--position-format"), (scene, "--record"),
                              (scene, "--kinds"), (["render", *ccd[1:]], "--out"), (scene, "--frames"), (scene, "--vtp"),
                              (["info", "--server", "a:1"], "--daemon-user"), (["load", "--scene", "funnel"], "--ramp"),
                              (["info", "--server", "a:1"], "--token-file"), (["batch", "x"], "--out")):
            self.refused(2, f"{option}: the value is empty", *words, option, "")
            self.refused(2, option, *words, f"{option}=")
        self.refused(2, "FILE: the value is empty", "replay", "")
        self.refused(2, "MESH: the value is empty", "detect", self.frame0, "")

    def test_messages_name_what_is_wrong(self):
        scene = ["stream", "--scene", "cloth_ball"]
        self.refused(2, "--exclude-meshes needs 2 values, NAME NAME", *scene, "--exclude-meshes", "cloth")
        self.refused(2, "--exclude-meshes: needs 2 values, NAME NAME", *scene, "--exclude-meshes", "cloth", "--scale", "0.1")
        self.refused(2, "--out needs 1 value, FILE", *scene, "--out")
        # CLI11 2.1 and 2.4 word the bounds each in its own way.
        interval = ["watch", "x", "--server", "a:1", "--interval", "-1"]
        self.refused(2, "not in range ", *interval)
        self.assertRegex(support.ctl(*interval).stderr, r"not in range (0 to 4294967295|\[0 - 4294967295\])")
        self.refused(1, "scale is 1e-09; it must be in [0.02, 30]", *scene, "--scale", "1e-9")
        self.refused(1, "a\\x1b[31m\\x0ab.obj: does not exist", "detect", "--frames", "a\x1b[31m\nb.obj", self.frame0)

    def test_the_wrong_word_is_named(self):
        frames = [self.frame0, self.frame1]
        self.refused(2, "'frobnicate' is not a command; there are detect, stream", "frobnicate")
        self.refused(2, "'steam' is not a command; did you mean stream?", "steam", "--scene", "funnel")
        self.refused(2, "--scnee is not an option of 'stream'; did you mean --scene?", "stream", "--scnee", "funnel")
        self.refused(2, "--treshold is not an option of 'detect'; see 'collidectl detect --help'", "detect", "--frames", *frames,
                     "--treshold", "3")
        self.refused(2, "--treads is not an option of 'detect'; did you mean --threads?", "detect", "--frames", *frames, "--treads=3")
        self.refused(2, "'detetc' is not a command; did you mean detect?", "detetc", *frames)
        self.refused(2, "--thicknes is not an option of 'detect'; did you mean --thickness?", "detect", "--frames", *frames,
                     "--thicknes=3")
        self.refused(2, "'funnel' is one word too many for 'scenes'", "scenes", "funnel")
        self.refused(2, "a command is needed: detect, stream")
        self.refused(2, "--verson is not an option of collidectl; did you mean --version?", "--verson")

    def test_help_tells_the_exit_codes(self):
        self.assertIn("Exit codes: 0 done, 1 failure, 2 bad usage, 128 + n interrupted by signal n.", self.ok("--help"))

    def test_help_fits_in_100_columns(self):
        commands = [line.split()[0] for line in self.ok("--help").partition("Subcommands:\n")[2].splitlines() if line.startswith("  ")]
        self.assertGreater(len(commands), 12)
        daemon = subprocess.run([DAEMON, "--help"], check=True, capture_output=True, text=True).stdout
        self.assertIn("--max-frame-seconds", daemon)
        text = daemon
        for words in ([], *([command] for command in commands)):
            text += self.ok(*words, "--help")
        self.assertEqual([line for line in text.splitlines() if len(line) > 100], [])

    def test_help_tells_how_many_files_go_in(self):
        self.assertIn("detect [OPTIONS] [MESH...]\n", self.ok("detect", "--help"))
        self.assertIn("tradeoff [OPTIONS] [FRAME [FRAME]]\n", self.ok("tradeoff", "--help"))
        self.assertIn("stream [OPTIONS] [FRAME...]\n", self.ok("stream", "--help"))
        for command in ("detect", "stream", "render", "watch", "replay", "estimate", "scenes", "export", "info", "tradeoff", "bench", "load"):
            text = self.ok(command, "--help")
            self.assertNotIn("x)", text.splitlines()[1], command)

    def test_a_reader_that_leaves_ends_it_without_a_word_and_without_leftovers(self):
        with tempfile.TemporaryDirectory() as folder:
            detect = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU]
            long = [["completion", "bash"], ["load", "--help"]]  # whose first write fails, not the last
            for words in (["info"], ["scenes"], detect, [*detect, "--out", "-"], *long):
                reader, writer = os.pipe()
                os.close(reader)
                env = {**os.environ, "COLLIDED_DAEMON": DAEMON, "TMPDIR": folder}
                done = subprocess.run([COLLIDECTL, *words], stdout=writer, stderr=subprocess.PIPE, text=True, env=env,
                                      timeout=240)
                os.close(writer)
                self.assertEqual(done.returncode, 128 + signal.SIGPIPE, words)
                self.assertNotIn("collidectl:", done.stderr)
                self.assertEqual(os.listdir(folder), [], words)

    def test_output_that_cannot_be_written_is_an_error(self):
        for words in (["info", "--json"], ["scenes"], ["--help"]):
            with open("/dev/full", "w", encoding="ascii") as full:
                env = {**os.environ, "COLLIDED_DAEMON": DAEMON}
                words = [COLLIDECTL, *words]
                done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, env=env, timeout=240)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr, "collidectl: standard output cannot be written\n")

    def test_errors_in_the_work(self):
        other = self.put("other.obj", FRAME0 + "v 9 9 9\n")
        self.refused(1, "has 6 vertices", "detect", "--frames", self.frame0, other, *ONE_CPU)
        self.refused(1, "has 7", "detect", "--frames", self.frame0, other, *ONE_CPU)
        self.refused(1, "none.ply", "detect", "--frames", "none.ply", self.frame0)
        self.refused(1, "empty.obj: has 0 vertices", "detect", self.put("empty.obj", ""), "--mode", "dcd")
        self.refused(1, "nonexistent", "info", "--server", "unix:/nonexistent/socket")
        self.refused(1, "COLLIDED_DAEMON", "detect", "--frames", self.frame0, self.frame1, COLLIDED_DAEMON="/nonexistent")
        self.refused(1, "ended with exit code 1", "info", COLLIDED_DAEMON="/bin/false")
        daemon = self.put("daemon", "#!/bin/sh\necho 'no room' >&2\nexit 7\n")
        os.chmod(daemon, 0o755)
        self.refused(1, "ended with exit code 7 before it was ready: no room\n", "info", COLLIDED_DAEMON=daemon)
        old = self.put("old", "#!/bin/sh\necho The following argument was not expected: --private >&2\nexit 2\n")
        os.chmod(old, 0o755)
        self.refused(1, f"must be of release 0.2.0 or later, and {old} is older\n", "info", COLLIDED_DAEMON=old)
        self.refused(1, "does not exist", "detect", "--frames", self.folder.name + "/none.obj", self.frame0)
        folder = os.path.join(self.folder.name, "folder.obj")
        os.mkdir(folder)
        self.refused(1, "folder.obj: the folder has no mesh files", "detect", "--frames", folder, self.frame0)
        wrong = self.put("wrong.obj", FRAME0.replace("f 4 5 6", "f 4 5 7"))
        self.refused(1, "wrong.obj:8: vertex index 7 is out of range; there are 6 vertices", "detect", "--frames", wrong, wrong)
        no_number = self.put("nan.obj", FRAME0.replace("v 4 0 0", "v nan 0 0"))
        self.refused(1, "nan.obj:2: position nan is not finite", "detect", "--frames", no_number, no_number)
        bad = "/nonexistent/folder/c.csv"
        self.refused(1, bad, "detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--out", bad)

    def test_tokens_and_certificates(self):
        nobody = ["info", "--server", "192.0.2.1:50551"]
        token = ["--token-file", self.put("token", "secret\n")]
        self.refused(2, "--server", "info", *token)
        self.refused(2, "--tls-key", *nobody, "--tls-ca", "ca.pem", "--tls-cert", "a.pem")
        self.refused(2, "--tls-ca", *nobody, "--tls-cert", "a.pem", "--tls-key", "b.pem")
        self.refused(1, "holds no token", *nobody, "--token-file", self.put("empty", "\n"))
        self.refused(1, "/nonexistent: cannot be read", *nobody, "--token-file", "/nonexistent")
        self.refused(1, "is a folder", *nobody, "--token-file", self.folder.name)
        self.refused(1, "which holds no CERTIFICATE", *nobody, "--tls-ca", self.frame0)
        self.refused(1, "in plain text", *nobody, *token)
        self.refused(2, "--server", "stream", "--scene", "funnel", "--daemon-user", "0")
        for user in ("no_such_user", "-1", "1x", "99999999999"):
            self.refused(2, f"--daemon-user {user}: no such user on this host", *nobody, f"--daemon-user={user}")
        self.refused(1, "tls_ca is '/nonexistent'", *nobody, *token, "--tls-ca", "/nonexistent")


if __name__ == "__main__":
    support.main()
