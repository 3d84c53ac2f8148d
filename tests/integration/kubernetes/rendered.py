"""What kubectl makes of the overlays."""

import pathlib
import shutil
import subprocess
import sys

try:
    import yaml
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-yaml)")
    sys.exit(77)

if not shutil.which("kubectl"):
    print("skipped: kubectl is not installed (Debian: kubernetes-client)")
    sys.exit(77)


class Objects:
    """Those of one folder with a kustomization.yaml."""

    def __init__(self, folder: pathlib.Path):
        done = subprocess.run(["kubectl", "kustomize", str(folder)], capture_output=True, text=True, timeout=60)
        if done.returncode != 0:
            raise RuntimeError(f"{folder}: {done.stderr}")
        self.all = list(yaml.safe_load_all(done.stdout))

    def of(self, kind):
        return [entry for entry in self.all if entry["kind"] == kind]

    def one(self, kind):
        found, = self.of(kind)
        return found

    @property
    def pod(self):
        """The template of a pod, of the StatefulSet or the Job."""
        found, = self.of("StatefulSet") + self.of("Job")
        return found["spec"]["template"]

    @property
    def containers(self):
        return self.pod["spec"]["containers"]

    @property
    def container(self):
        """The one that the pod is for: of the daemon, or of the Job."""
        return self.containers[0]

    @property
    def entrance(self):
        found, = (container for container in self.containers if container["name"] == "entrance")
        return found

    @property
    def entrance_options(self):
        """Values by name."""
        return {name: value for name, _, value in (word.partition("=") for word in self.entrance["args"])}

    def mounts(self, container):
        """Names of volumes by the folders that they are mounted at."""
        return {mount["mountPath"]: mount["name"] for mount in container["volumeMounts"]}

    def environment(self, pod_name):
        """Of the daemon's container, in the order in which Kubernetes expands it."""
        values = {}
        for variable in self.container["env"]:
            value = variable.get("value")
            if value is None:
                assert variable["valueFrom"]["fieldRef"]["fieldPath"] == "metadata.name", variable
                value = pod_name
            for name, known in values.items():
                value = value.replace(f"$({name})", known)
            values[variable["name"]] = value
        return values

    @property
    def ports(self):
        """Numbers by name, of all containers."""
        return {port["name"]: port["containerPort"]
                for container in self.containers for port in container["ports"]}
