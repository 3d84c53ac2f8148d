"""A real Prometheus with the repository's files, which scrapes one daemon each second."""

import json
import pathlib
import random
import shutil
import subprocess
import time
import urllib.error
import urllib.parse
import urllib.request

PATIENCE = 60


class Prometheus:
    """source: folder of prometheus.yml and alerts.yml; target: address of a daemon's metrics, instead of the examples."""

    def __init__(self, source, target, folder):
        folder = pathlib.Path(folder)
        text = (source / "prometheus.yml").read_text()
        first = text.index("[", text.index("- targets:", text.index("scrape_configs:")))
        text = f'{text[:first]}["{target}"]{text[text.index("]", first) + 1:]}'.replace("15s", "1s")
        (folder / "prometheus.yml").write_text(text)
        shutil.copy(source / "alerts.yml", folder)
        # A loopback address that nobody else has, so that the port need not be free.
        address = f"127.{random.randint(1, 254)}.{random.randint(0, 255)}.8:9090"
        self._url = f"http://{address}/api/v1/"
        with open(folder / "prometheus.log", "wb") as log:
            self._process = subprocess.Popen(
                ["prometheus", f"--config.file={folder}/prometheus.yml", f"--storage.tsdb.path={folder}/data",
                 f"--web.listen-address={address}"], stdout=log, stderr=log)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()

    def _ask(self, what, **arguments):
        """The data of an answer, once it answers at all. ValueError: it refuses."""
        url = self._url + what + "?" + urllib.parse.urlencode(arguments)
        deadline = time.monotonic() + PATIENCE
        while True:
            try:
                with urllib.request.urlopen(url, timeout=PATIENCE) as answer:
                    return json.load(answer)["data"]
            except urllib.error.HTTPError as error:
                if error.code != 503:
                    raise ValueError(f"{what} {arguments}: {error.read().decode()}") from None
            except OSError:  # it starts
                pass
            if self._process.poll() is not None or time.monotonic() > deadline:
                raise TimeoutError(what)
            time.sleep(0.05)

    def rules(self):
        return [rule for group in self._ask("rules")["groups"] for rule in group["rules"]]

    def wait_for_samples(self, query, title):
        """Rates need two scrapes."""
        deadline = time.monotonic() + PATIENCE
        while not self._ask("query", query=query)["result"]:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{title}: {query} has no samples")
            time.sleep(0.1)
