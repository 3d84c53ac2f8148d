#!/usr/bin/env python3
"""deploy/kubernetes: each overlay is rendered by kubectl, and its options, probes, names and metrics are the daemon's own.
Nothing here runs on a cluster. Usage: kubernetes_test.py DAEMON REPOSITORY"""

import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import SERVICE, SERVING, DaemonCase, Folder, health, http  # noqa: E402

import grpc  # noqa: E402

from rendered import Objects  # noqa: E402

PROGRAM = sys.argv[1]
KUBERNETES = pathlib.Path(sys.argv[2]).resolve() / "deploy" / "kubernetes"
OVERLAYS = {name: Objects(KUBERNETES / "overlays" / name) for name in ("cpu", "gpu", "tls")}
MONITORING = Objects(KUBERNETES / "monitoring")
ENTRANCE = KUBERNETES.parent / "entrance" / "entrance"
HAPROXY = shutil.which("haproxy", path=f"{os.environ['PATH']}:/usr/sbin")
POD = "collided-0"
PORT = 50551  # of the entrance, unless --listen says otherwise
LAST_SECONDS = 5  # of a stop, after the grace: deploy/README.md
TOKENS = '[[tokens]]\nname = "a"\ntoken = "0123456789abcdef"\n'


def port_of(address):
    return int(address.rpartition(":")[2])


def check_options(environment):
    """The daemon's own check of a configuration."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("COLLIDED_")}
    return subprocess.run([PROGRAM, "--check"], env={**kept, **environment}, capture_output=True, text=True, timeout=60)


def answers(address, path):
    try:
        return http(address, path)[0] == 200
    except OSError:
        return False


def is_selected(selector, labels):
    return bool(selector) and selector.items() <= labels.items()


class Rendered(unittest.TestCase):
    def each(self):
        for name, objects in OVERLAYS.items():
            with self.subTest(overlay=name):
                yield name, objects

    def test_every_overlay_has_all_objects(self):
        for _, objects in self.each():
            self.assertEqual(sorted(entry["kind"] for entry in objects.all),
                             ["NetworkPolicy", "PodDisruptionBudget", "Service", "Service", "StatefulSet"])

    def test_the_daemon_accepts_its_options(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        files = {"/etc/collided/tokens/tokens.toml": folder.put("tokens.toml", TOKENS)}
        for _, objects in self.each():
            environment = objects.environment(POD)
            self.assertTrue(all(variable.startswith("COLLIDED_") for variable in environment))
            done = check_options({variable: files.get(value, value) for variable, value in environment.items()})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("without TLS: frames", done.stderr)  # the network reaches the entrance alone

    def test_a_misspelt_option_would_be_found(self):
        wrong = {**OVERLAYS["cpu"].environment(POD), "COLLIDED_NAME": "not.a.name"}
        self.assertEqual(check_options(wrong).returncode, 2)
        known = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True, timeout=60).stdout
        for _, objects in self.each():
            for variable in objects.environment(POD):  # an unknown variable is nobody's
                self.assertIn(f"--{variable.removeprefix('COLLIDED_').lower().replace('_', '-')} ", known)

    def test_secrets_are_mounted_where_the_options_look(self):
        objects = OVERLAYS["tls"]
        mounted = [objects.mounts(container) for container in objects.containers]
        self.assertEqual({name for mounts in mounted for name in mounts.values()},
                         {volume["name"] for volume in objects.pod["spec"]["volumes"]})
        tokens, certificate = objects.environment(POD)["COLLIDED_TOKENS_FILE"], objects.entrance_options["--certificate"]
        self.assertEqual(mounted[0][os.path.dirname(tokens)], "tokens")
        self.assertEqual(objects.mounts(objects.entrance)[os.path.dirname(certificate)], "tls")

    def test_ports_are_those_that_are_listened_on(self):
        for _, objects in self.each():
            environment = objects.environment(POD)
            self.assertEqual(objects.ports, {"grpc": PORT, "http": port_of(environment["COLLIDED_HTTP_ADDRESS"]),
                                             "entrance-http": port_of(objects.entrance_options["--http"])})
            for service in objects.of("Service"):
                for port in service["spec"]["ports"]:
                    self.assertEqual((port["targetPort"], port["port"]), (port["name"], objects.ports[port["name"]]))

    def test_the_network_reaches_the_entrance_and_that_the_daemon(self):
        for _, objects in self.each():
            environment = objects.environment(POD)
            _, address, http_address = re.fullmatch("(.*)=(.*),(.*)", objects.entrance_options["--daemon"]).groups()
            self.assertEqual(address, environment["COLLIDED_ADDRESS"])
            self.assertEqual(port_of(http_address), port_of(environment["COLLIDED_HTTP_ADDRESS"]))
            folder = os.path.dirname(address.removeprefix("unix:"))
            shared = {objects.mounts(container)[folder] for container in (objects.container, objects.entrance)}
            self.assertEqual(len(shared), 1)
            self.assertIn(objects.entrance_options["--run"], objects.mounts(objects.entrance))

    def test_clients_stream_to_the_entrance_of_the_pod(self):
        for _, objects in self.each():
            headless, = (service for service in objects.of("Service") if service["spec"].get("clusterIP") == "None")
            name = headless["metadata"]["name"]
            self.assertEqual(objects.one("StatefulSet")["spec"]["serviceName"], name)
            self.assertEqual(objects.environment(POD)["COLLIDED_ENDPOINT"], f"{POD}.{name}:{objects.ports['grpc']}")
            self.assertTrue(headless["spec"]["publishNotReadyAddresses"])  # streams of a pod that drains go on

    def test_everything_selects_the_pods(self):
        for _, objects in self.each():
            labels = objects.pod["metadata"]["labels"]
            selectors = [service["spec"]["selector"] for service in objects.of("Service")]
            selectors += [objects.one(kind)["spec"]["selector"]["matchLabels"] for kind in ("StatefulSet", "PodDisruptionBudget")]
            selectors.append(objects.one("NetworkPolicy")["spec"]["podSelector"]["matchLabels"])
            for selector in selectors:
                self.assertTrue(is_selected(selector, labels), selector)
            for rule in objects.one("NetworkPolicy")["spec"]["ingress"]:
                self.assertLessEqual({port["port"] for port in rule["ports"]}, set(objects.ports))

    def test_a_stop_has_the_time_that_it_needs(self):
        for _, objects in self.each():
            sleep = int(objects.container["lifecycle"]["preStop"]["exec"]["command"][1])
            grace = float(objects.environment(POD)["COLLIDED_GRACE_SECONDS"])
            stays = int(objects.entrance["lifecycle"]["preStop"]["exec"]["command"][1])
            self.assertGreaterEqual(stays, sleep + grace + LAST_SECONDS)
            self.assertGreater(objects.pod["spec"]["terminationGracePeriodSeconds"], stays)

    def test_a_daemon_that_drains_is_not_killed_for_it(self):
        for _, objects in self.each():  # which /readyz would do: it is 503 then
            self.assertEqual(objects.container["livenessProbe"]["httpGet"], {"port": "http", "path": "/healthz"})

    def test_pods_may_do_nothing_but_their_work(self):
        for _, objects in self.each():
            pod = objects.pod["spec"]
            self.assertTrue(pod["securityContext"]["runAsNonRoot"] and pod["securityContext"]["runAsUser"] > 0)
            self.assertEqual(pod["securityContext"]["seccompProfile"], {"type": "RuntimeDefault"})
            self.assertFalse(pod["automountServiceAccountToken"])
            for container in objects.containers:
                self.assertEqual(container["securityContext"], {"allowPrivilegeEscalation": False,
                                                                "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]}})


class Real(DaemonCase):
    program = PROGRAM

    def test_probes_get_their_answers_from_a_daemon(self):
        daemon = self.start()
        for objects in OVERLAYS.values():
            for probe in (objects.container[f"{kind}Probe"] for kind in ("startup", "readiness", "liveness")):
                self.assertEqual(probe["httpGet"]["port"], "http")
                self.assertEqual(daemon.http(probe["httpGet"]["path"])[0], 200)

    @unittest.skipUnless(HAPROXY, "haproxy is not installed (Debian: haproxy)")
    def test_the_entrance_of_a_pod_serves_with_its_options(self):
        for name, objects in OVERLAYS.items():
            with self.subTest(overlay=name):
                folder = Folder()
                self.addCleanup(folder.cleanup)
                folder.certificates()
                os.rename(folder.path("server.pem"), folder.path("tls.crt"))
                os.rename(folder.path("server.key"), folder.path("tls.key"))
                daemon = self.start(address=f"unix:{folder.path('socket')}")
                host = f"127.{random.randint(1, 254)}.{random.randint(0, 255)}.9"
                here = {"--run": folder.name, "--daemon": f"daemon={daemon.address},{daemon.http_address}",
                        "--http": f"{host}:{objects.ports['entrance-http']}", "--certificate": folder.path("tls.crt")}
                words = [f"{name}={here[name]}" if value else name for name, value in objects.entrance_options.items()]
                entrance = subprocess.Popen([ENTRANCE, *words, f"--listen={host}:{PORT}"])
                self.addCleanup(entrance.wait)
                self.addCleanup(entrance.terminate)
                ready = objects.entrance["readinessProbe"]["httpGet"]
                daemon.wait_for(lambda: answers(f"{host}:{objects.ports[ready['port']]}", ready["path"]), "entrance")
                credentials = grpc.ssl_channel_credentials(folder.read("ca.pem")) if name == "tls" else None
                self.assertEqual(health(f"{host}:{PORT}", SERVICE, credentials), SERVING)

    def test_the_autoscaler_follows_a_metric_that_exists(self):
        text = self.start().http("/metrics")[1]
        target = MONITORING.one("HorizontalPodAutoscaler")["spec"]
        self.assertEqual(target["scaleTargetRef"]["name"], OVERLAYS["cpu"].one("StatefulSet")["metadata"]["name"])
        for metric in target["metrics"]:
            self.assertIn(f"\n# TYPE {metric['pods']['metric']['name']} gauge\n", text)

    def test_prometheus_scrapes_each_pod_once(self):
        monitor = MONITORING.one("ServiceMonitor")["spec"]
        ports = {endpoint["port"] for endpoint in monitor["endpoints"]}
        scraped = [service for service in OVERLAYS["cpu"].of("Service")
                   if is_selected(monitor["selector"]["matchLabels"], service["metadata"]["labels"])
                   and ports & {port["name"] for port in service["spec"]["ports"]}]
        self.assertEqual([service["spec"].get("clusterIP") for service in scraped], ["None"])
        self.assertEqual(scraped[0]["metadata"]["labels"][monitor["jobLabel"]], "collided")  # as in the alerts


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
