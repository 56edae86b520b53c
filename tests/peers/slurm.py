"""A Slurm of three nodes on one machine: Debian's packages, unpacked into a folder and not installed."""

import getpass
import os
import signal
import socket
import subprocess
import time
from pathlib import Path

PACKAGES = ["munge", "libmunge2", "slurm-client", "slurm-wlm-basic-plugins", "slurmctld", "slurmd", "libhwloc15", "liblua5.1-0"]
NODES = ["n1", "n2", "n3"]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def kill(process):
    try:
        os.kill(process, signal.SIGKILL)
    except OSError:
        pass


class Slurm:
    """Up inside `with`; `path` is what a job sees first of programs."""

    def __init__(self, folder, path):
        self.folder = Path(folder).resolve()
        self.root = self.folder / "root"
        libraries = next(iter(self.root.glob("usr/lib/*-linux-gnu")), None) or self.unpack()
        plugins = libraries / "slurm-wlm"
        self.bin, self.sbin = self.root / "usr/bin", self.root / "usr/sbin"
        self.env = {
            **os.environ,
            "LD_LIBRARY_PATH": f"{libraries}:{plugins}:{os.environ.get('LD_LIBRARY_PATH', '')}",
            "SLURM_CONF": str(self.folder / "slurm.conf"),
            "PATH": f"{path}:{os.environ['PATH']}",
        }
        self.pid_files = {node: self.folder / f"{node}.pid" for node in [*NODES, "ctld", "munge"]}
        host, user = socket.gethostname(), getpass.getuser()
        nodes = [f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={free_port()} CPUs=4 State=UNKNOWN" for node in NODES]
        (self.folder / "slurm.conf").write_text(
            "\n".join(
                [
                    "ClusterName=carom",
                    f"SlurmctldHost={host}(127.0.0.1)",
                    f"SlurmUser={user}",
                    f"SlurmdUser={user}",
                    f"AuthInfo=socket={self.folder}/munge.socket",
                    f"PluginDir={plugins}",
                    *["ProctrackType=proctrack/linuxproc", "TaskPlugin=task/none", "SwitchType=switch/none", "MpiDefault=none"],
                    *["SelectType=select/cons_tres", "SelectTypeParameters=CR_CPU", "ReturnToService=2", "SlurmdTimeout=10"],
                    # More processors than this machine may have.
                    "SlurmdParameters=config_overrides",
                    # A job that is queued again waits two minutes otherwise.
                    "SchedulerParameters=sched_interval=1,bf_interval=2,sched_min_interval=0",
                    f"SlurmctldPort={free_port()}",
                    f"SlurmctldPidFile={self.pid_files['ctld']}",
                    f"SlurmdPidFile={self.folder}/%n.pid",
                    f"SlurmdSpoolDir={self.folder}/spool.%n",
                    f"SlurmdLogFile={self.folder}/%n.log",
                    f"SlurmctldLogFile={self.folder}/ctld.log",
                    f"StateSaveLocation={self.folder}/state",
                    *nodes,
                    f"PartitionName=all Nodes={','.join(NODES)} Default=YES MaxTime=INFINITE State=UP",
                ]
            )
            + "\n"
        )

    def unpack(self):
        packages = self.folder / "packages"
        packages.mkdir(parents=True, exist_ok=True)
        if subprocess.run(["apt-get", "download", *PACKAGES], cwd=packages, capture_output=True).returncode != 0:
            subprocess.run(["apt-get", "update"], check=True, capture_output=True)
            subprocess.run(["apt-get", "download", *PACKAGES], cwd=packages, check=True, capture_output=True)
        for package in sorted(packages.glob("*.deb")):
            subprocess.run(["dpkg", "-x", package, self.root], check=True)
        return next(self.root.glob("usr/lib/*-linux-gnu"))

    def call(self, *words):
        return subprocess.run([self.bin / words[0], *words[1:]], env=self.env, check=True, capture_output=True, text=True).stdout

    def tell(self, *words):
        """What `scontrol` may refuse, such as of a task that has just ended."""
        subprocess.run([self.bin / "scontrol", *words], env=self.env, capture_output=True)

    def start(self, node):
        subprocess.run([self.sbin / "slurmd-wlm", "-N", node, "-d", self.sbin / "slurmstepd-wlm"], env=self.env, check=True, capture_output=True)

    def state(self, node):
        """As `sinfo` tells it; with `*` where the node does not answer."""
        return self.call("sinfo", "--noheader", "--Node", f"--nodes={node}", "--format=%T")

    def kill_server(self, name):
        """Once: after that its number may be any other program's."""
        number = int(self.pid_files[name].read_text())
        try:
            is_own = str(self.folder).encode() in Path(f"/proc/{number}/cmdline").read_bytes()
        except OSError:
            is_own = False
        if is_own:
            kill(number)
        self.pid_files[name].unlink()

    def lose(self, node):
        """The node with all that runs on it, at once; how many workers that were."""
        self.kill_server(node)
        steps, tasks, workers = [], [], 0
        for process in Path("/proc").glob("[0-9]*"):
            try:
                environment = (process / "environ").read_bytes().split(b"\0")
                command = (process / "cmdline").read_bytes()
                opened = [os.readlink(file) for file in (process / "fd").iterdir()]
            except OSError:
                continue
            if f"SLURM_CONF={self.folder}/slurm.conf".encode() not in environment:
                continue
            if f"SLURMD_NODENAME={node}".encode() in environment:
                tasks.append(int(process.name))
                workers += command.startswith(b"carom\0")
            elif command.startswith(b"slurmstepd") and f"{self.folder}/{node}.log" in opened:
                steps.append(int(process.name))
        # A step would tell of its task's death.
        for process in steps + tasks:
            kill(process)
        return workers

    def states(self, job):
        """Of each task that has not ended: its number, state, and node or reason."""
        states = self.call("squeue", "--noheader", "--array", "--format=%i %T %R", f"--jobs={job}")
        if "DependencyNeverSatisfied" in states:
            raise RuntimeError("a task failed, and the run behind it will never begin: see the tasks' logs")
        return states.splitlines()

    def __enter__(self):
        try:
            self.begin()
        except BaseException:
            self.__exit__()
            raise
        return self

    def begin(self):
        for left in [self.folder / "state", *self.pid_files.values(), *[self.folder / f"spool.{node}" for node in NODES]]:
            subprocess.run(["rm", "-rf", left], check=True)
        (self.folder / "state").mkdir()
        key = self.folder / "munge.key"
        key.unlink(missing_ok=True)
        subprocess.run([self.sbin / "mungekey", "-c", "-k", key], env=self.env, check=True)
        os.chmod(self.folder, 0o755)
        places = [f"--{name}={self.folder}/munge.{end}" for name, end in [("key-file", "key"), ("socket", "socket"), ("pid-file", "pid"), ("log-file", "log"), ("seed-file", "seed")]]
        subprocess.run([self.sbin / "munged", "--force", *places], env=self.env, check=True, capture_output=True)
        subprocess.run([self.sbin / "slurmctld-wlm"], env=self.env, check=True, capture_output=True)
        for node in NODES:
            self.start(node)
        for _ in range(120):
            if self.call("sinfo", "--noheader", "--Node", "--format=%T").split() == ["idle"] * len(NODES):
                return
            time.sleep(0.5)
        raise TimeoutError(f"no node is idle: see {self.folder}/*.log")

    def __exit__(self, *_):
        for node in NODES:
            if self.pid_files[node].exists():
                self.lose(node)
        for server in ["ctld", "munge"]:
            if self.pid_files[server].exists():
                self.kill_server(server)
