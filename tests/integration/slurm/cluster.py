"""A Slurm of one node, in a private folder: munged, slurmctld and slurmd on ports and a key of their own."""

import getpass
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time

PATH = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"
PROGRAMS = {"munged": "munge", "slurmctld": "slurmctld", "slurmd": "slurmd", "sbatch": "slurm-client", "scontrol": "slurm-client"}
for program, package in PROGRAMS.items():
    if not shutil.which(program, path=PATH):
        print(f"skipped: {program} is not installed (Debian: {package})")
        sys.exit(77)

PATIENCE = 120
AT_WORK = {"PENDING", "CONFIGURING", "RUNNING", "COMPLETING", "REQUEUED", "SUSPENDED"}


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(77)


def wait_for(condition, what):
    deadline = time.monotonic() + PATIENCE
    while not (found := condition()):
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.02)
    return found


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    CPUS, MEGABYTES = 4, 4000  # as Slurm is told, whatever the machine has

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="slurm-")
        self.folder = pathlib.Path(self._folder.name)
        self.environment = {name: value for name, value in os.environ.items() if not name.startswith(("SLURM_", "SBATCH_"))}
        self.environment |= {"PATH": PATH, "SLURM_CONF": str(self.folder / "slurm.conf")}
        self._daemons = []
        (self.folder / "munge.key").write_bytes(os.urandom(1024))
        (self.folder / "munge.key").chmod(0o600)
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "slurm.conf").write_text(self._configuration())

    def start(self):
        """Exits with 77 where these daemons do not run."""
        files = {"key-file": "munge.key", "socket": "munge.socket", "pid-file": "munge.pid", "log-file": "munge.log",
                 "seed-file": "munge.seed"}
        try:
            self._run("munged", "--foreground", "--force", *(f"--{name}={self.folder / file}" for name, file in files.items()))
            wait_for((self.folder / "munge.socket").exists, "munged's socket")
            self._run("slurmctld", "-D")
            self._run("slurmd", "-D")
            wait_for(self._is_idle, "an idle node")
        except (TimeoutError, RuntimeError) as failure:
            logs = [log.read_text(errors="replace").strip().splitlines()[-1:] for log in sorted(self.folder.glob("*.log"))]
            self.stop()
            skip(f"Slurm's daemons do not run here: {failure}; {logs}")

    def stop(self):
        self.call("scancel", "--user", getpass.getuser(), check=False)
        for daemon in reversed(self._daemons):
            daemon.terminate()
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self._daemons.clear()
        self._folder.cleanup()

    def call(self, *words, check=True, **environment):
        done = subprocess.run(words, env={**self.environment, **environment}, cwd=self.folder, capture_output=True, text=True,
                              timeout=PATIENCE)
        if check and done.returncode != 0:
            raise RuntimeError(f"{words}: {done.stderr}")
        return done.stdout

    def submit(self, *words, **environment):
        """The job's number."""
        return self.call("sbatch", "--parsable", "--cpus-per-task=1", "--mem=200", *words, **environment).strip()

    def tasks(self, job):
        """State and exit code of each task by its number, and of a job without tasks; tasks that wait may be told as one."""
        found = {}
        for line in self.call("scontrol", "show", "job", "-o", job).splitlines():
            fields = dict(re.findall(r"(\w+)=(\S*)", line))
            found[fields.get("ArrayTaskId", job)] = fields["JobState"], fields["ExitCode"]
        return found

    def wait(self, job):
        return wait_for(lambda: (tasks := self.tasks(job)) and not {state for state, _ in tasks.values()} & AT_WORK and tasks,
                        f"end of job {job}")

    def _run(self, program, *words):
        with open(self.folder / f"{program}.log", "wb") as log:
            self._daemons.append(subprocess.Popen([shutil.which(program, path=PATH), *words], env=self.environment, stdout=log,
                                                  stderr=log, cwd=self.folder))

    def _is_idle(self):
        for daemon in self._daemons:
            if daemon.poll() is not None:
                raise RuntimeError(f"{daemon.args[0]} ended with {daemon.returncode}")
        return "State=IDLE" in self.call("scontrol", "show", "node", check=False)

    def _configuration(self):
        host, user, (controller, node) = socket.gethostname().split(".")[0], getpass.getuser(), free_ports(2)
        lines = {
            "ClusterName": "test", "SlurmctldHost": f"{host}(127.0.0.1)", "SlurmctldPort": controller, "SlurmdPort": node,
            "SlurmUser": user, "SlurmdUser": user, "AuthType": "auth/munge",
            "AuthInfo": f"socket={self.folder / 'munge.socket'}", "CredType": "cred/munge",
            "StateSaveLocation": self.folder / "state", "SlurmdSpoolDir": self.folder / "spool",
            "SlurmctldPidFile": self.folder / "slurmctld.pid", "SlurmdPidFile": self.folder / "slurmd.pid",
            # No cgroups: tasks may only be followed, not confined, without root.
            "ProctrackType": "proctrack/linuxproc", "TaskPlugin": "task/none", "SwitchType": "switch/none",
            "SlurmdParameters": "config_overrides", "SelectType": "select/cons_tres", "SelectTypeParameters": "CR_Core_Memory",
            "SchedulerParameters": "batch_sched_delay=0,sched_interval=1", "MinJobAge": 3600, "ReturnToService": 2,
        }
        return "".join(f"{name}={value}\n" for name, value in lines.items()) + (
            f"NodeName={host} NodeAddr=127.0.0.1 CPUs={self.CPUS} RealMemory={self.MEGABYTES} State=UNKNOWN\n"
            "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n")
