#!/usr/bin/env python3
"""What deploy/ has for Prometheus and Grafana: promtool accepts it, and it is about metrics that a real daemon has.

Usage: watching_test.py DAEMON COLLIDECTL REPOSITORY
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import Daemon, DaemonCase, Folder  # noqa: E402

from prometheus_server import Prometheus  # noqa: E402

PROGRAM, COLLIDECTL = sys.argv[1:3]
DEPLOY = pathlib.Path(sys.argv[3]).resolve() / "deploy"
ALERTS, DASHBOARD = DEPLOY / "prometheus" / "alerts.yml", DEPLOY / "grafana" / "collided.json"
OF_PROMETHEUS = {"up": {"job", "instance"}}
TARGET_LABELS = {"job", "instance"}

if not shutil.which("promtool"):
    print("skipped: promtool is not installed (Debian: prometheus)")
    sys.exit(77)


def promtool(*arguments):
    return subprocess.run(["promtool", *arguments], capture_output=True, text=True, timeout=60,
                          cwd=DEPLOY / "prometheus")


def disturb(daemon, folder):
    """Frames, a refused call, and TLS files that cannot be used: what makes metrics with labels."""
    run = [COLLIDECTL, "stream", "--server", daemon.address, "--tls-ca", folder.path("ca.pem"), "--frames", "3"]
    subprocess.run([*run, "--scene", "cloth_ball", "--scale", "0.2"], check=True, capture_output=True, timeout=60)
    subprocess.run([COLLIDECTL, "watch", "none", "--server", daemon.address, "--tls-ca", folder.path("ca.pem")],
                   capture_output=True, timeout=60)
    folder.put("server.pem", "no certificate\n")
    daemon.wait_for(lambda: 'collided_certificate_reloads_total{result="refused"}' in daemon.http("/metrics")[1], "reload")


def metrics_of(text):
    """Labels by the name that a query uses: of a histogram its buckets, sum and count."""
    found = {}
    for name, labels in re.findall(r"^(\w+)(?:\{(.*)\})? \S+$", text, re.MULTILINE):
        found.setdefault(name, set()).update(re.findall(r'(\w+)="', labels))
    return found


def alerts():
    """Name and expression of each, from the file's own layout."""
    text = ALERTS.read_text()
    rules = re.findall(r"- alert: (\w+)\n\s+expr: (>\n(?:\s{10,}.*\n)+|.*\n)", text)
    assert len(rules) == text.count("- alert:"), "a rule that this does not read"
    return dict(rules)


def panels():
    return [panel for panel in json.loads(DASHBOARD.read_text())["panels"] if panel["type"] != "row"]


def queries():
    """Title and query of all panels, as Grafana would send them."""
    for panel in panels():
        for target in panel["targets"]:
            yield panel["title"], target["expr"].replace("$__rate_interval", "1m").replace("$instance", ".*")


class Sound(unittest.TestCase):
    def test_promtool_accepts_configuration_and_rules(self):
        for arguments in (("check", "config", "prometheus.yml"), ("check", "rules", "alerts.yml"),
                          ("test", "rules", "alerts_test.yml")):
            done = promtool(*arguments)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_each_alert_is_tested_silent_and_firing(self):
        text = (DEPLOY / "prometheus" / "alerts_test.yml").read_text()
        for name in alerts():
            self.assertIn(f"alertname: {name}}}", text, "silent")
            self.assertRegex(text, rf"alertname: {name}\n\s+exp_alerts:\n\s+- exp_labels", "firing")

    def test_each_alert_has_its_section_and_each_section_its_alert(self):
        book = (DEPLOY / "prometheus" / "RUNBOOK.md").read_text()
        sections = re.findall(r"^## (Collided\w+)\n\n\*\*Means:\*\* .+?\n\n\*\*Do:\*\* ", book, re.MULTILINE | re.DOTALL)
        self.assertEqual(sections, list(alerts()))

    def test_panels_say_what_they_show_and_do_not_overlap(self):
        taken = set()
        for panel in json.loads(DASHBOARD.read_text())["panels"]:
            at = panel["gridPos"]
            cells = {(x, y) for x in range(at["x"], at["x"] + at["w"]) for y in range(at["y"], at["y"] + at["h"])}
            self.assertFalse(cells & taken, panel["title"])
            self.assertLessEqual(at["x"] + at["w"], 24)
            taken |= cells
        for panel in panels():
            self.assertTrue(panel["description"] and panel["fieldConfig"]["defaults"]["unit"], panel["title"])
        ids = [panel["id"] for panel in panels()]
        self.assertEqual(len(ids), len(set(ids)))


class Real(DaemonCase):
    program = PROGRAM

    @classmethod
    def setUpClass(cls):
        folder = Folder()
        cls.addClassCleanup(folder.cleanup)
        cls.daemon = Daemon(PROGRAM, *folder.certificates())
        cls.addClassCleanup(cls.daemon.__exit__)
        disturb(cls.daemon, folder)
        cls.metrics = {**metrics_of(cls.daemon.http("/metrics")[1]), **OF_PROMETHEUS}

    def expect_metrics(self, query, where):
        names = re.findall(r"\b(?:collided|process)_\w+|\bup\b", query)
        self.assertTrue(names, where)
        for name in names:
            self.assertIn(name, self.metrics, where)
        for name, labels in re.findall(r"(\w+)\{(.*?)\}", query):
            for label in re.findall(r"(\w+)\s*=", labels):
                self.assertIn(label, self.metrics[name] | TARGET_LABELS, f"{where}: {name}")
        known = set().union(*(self.metrics[name] for name in names)) | TARGET_LABELS
        for labels in re.findall(r"\bby \(([^)]+)\)", query):
            self.assertLessEqual(set(re.findall(r"\w+", labels)), known, where)

    def test_alerts_are_about_metrics_that_exist(self):
        for name, query in alerts().items():
            self.expect_metrics(query, name)

    def test_panels_are_about_metrics_that_exist(self):
        for title, query in queries():
            self.expect_metrics(query, title)

    def test_the_dashboard_leaves_no_metric_out(self):
        shown = " ".join(query for _, query in queries())
        for name in self.metrics.keys() - OF_PROMETHEUS:
            if not name.endswith(("_count", "_bucket")):
                self.assertRegex(shown, rf"\b{name.removesuffix('_sum')}", name)

    def test_a_real_prometheus_answers_every_query(self):
        with Prometheus(DEPLOY / "prometheus", self.daemon.http_address, self.folder.name) as prometheus:
            self.assertEqual({rule["name"] for rule in prometheus.rules()}, set(alerts()))
            for title, query in queries():
                prometheus.wait_for_samples(query, title)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
