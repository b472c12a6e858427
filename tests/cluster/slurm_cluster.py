"""A Slurm of two nodes in a temporary folder: its own munge, slurmctld and two slurmd as root, without systemd. Each node has 4 processors
and 2 GPUs, whatever the machine has."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time

PACKAGES = ("slurmctld", "slurmd", "slurm-client", "munge")
PROGRAMS = ("slurmctld", "slurmd", "sbatch", "munged")
ENVIRONMENT = os.environ | {"PATH": os.environ["PATH"] + ":/usr/sbin:/sbin"}

CONFIGURATION = """\
ClusterName=fresco
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=20
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
MailProg=/bin/true
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=bf_interval=1,sched_interval=1,sched_min_interval=0,batch_sched_delay=0,default_queue_depth=2000
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
SlurmdTimeout=10
GresTypes=gpu
NodeName=one NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[0]} CPUs=4 RealMemory=32000 Gres=gpu:2
NodeName=two NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=4 RealMemory=32000 Gres=gpu:2
PartitionName=all Nodes=one,two Default=YES OverTimeLimit=0
"""
# Without real devices Slurm counts files.
GPUS = "AutoDetect=off\nName=gpu File=/dev/null\nName=gpu File=/dev/zero\n"


def missing():
    """Why there can be no Slurm here; empty: there can. Installs what is missing where that is possible."""
    if os.geteuid() != 0:
        return "Slurm's daemons must be started by root"
    return "" if all(shutil.which(program, path=ENVIRONMENT["PATH"]) for program in PROGRAMS) else install(PACKAGES)


def install(packages):
    """Why Debian's packages cannot be installed; empty: they are."""
    if not shutil.which("apt-get"):
        return f"{', '.join(packages)}: not installed, and there is no apt-get"
    # Their services are not to be started.
    policy = pathlib.Path("/usr/sbin/policy-rc.d")
    own_policy = not policy.exists()
    if own_policy:
        policy.write_text("#!/bin/sh\nexit 101\n")
        policy.chmod(0o755)
    try:
        ended = subprocess.run(["apt-get", "install", "--yes", "--no-install-recommends", *packages], text=True, capture_output=True,
                               env=ENVIRONMENT | {"DEBIAN_FRONTEND": "noninteractive"})
    finally:
        if own_policy:
            policy.unlink()
    return "" if ended.returncode == 0 else f"{', '.join(packages)}: cannot be installed: {ended.stderr.strip()[-200:]}"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def processes():
    """The parent of each process."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "stat").read_text().rpartition(")")[2].split()
                found[int(entry.name)] = int(words[1])
            except OSError:
                pass
    return found


def descendants(root):
    parents = processes()
    result, wanted = [], {root}
    while wanted:
        wanted = {child for child, parent in parents.items() if parent in wanted} - set(result)
        result += wanted
    return result


class Slurm:
    NODES = ("one", "two")

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="fresco-slurm-"))
        self.folder.chmod(0o755)
        self.running = {}
        for name in ("state", *(f"spool-{node}" for node in self.NODES)):
            (self.folder / name).mkdir()
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=socket.gethostname().split(".")[0], folder=self.folder, controller_port=free_port(), ports=[free_port() for _ in self.NODES]))
        (self.folder / "gres.conf").write_text(GPUS)
        # From 23.02 on, Slurm insists on control groups, which nothing here uses; before, it does not know this word.
        version = subprocess.run(["slurmctld", "-V"], capture_output=True, text=True).stdout.split()[-1]
        if int(version.split(".")[0]) >= 23:
            (self.folder / "cgroup.conf").write_text("CgroupPlugin=disabled\n")
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.environment = ENVIRONMENT | {"SLURM_CONF": str(self.folder / "slurm.conf")}

    def __enter__(self):
        try:
            self.start("munged", "--foreground", "--force", f"--key-file={self.folder}/munge.key", f"--socket={self.folder}/munge.socket",
                       f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/munged.seed", f"--log-file={self.folder}/munged.log")
            self.wait(lambda: (self.folder / "munge.socket").exists(), 10, "munged")
            self.start("slurmctld", "-D", "-f", f"{self.folder}/slurm.conf")
            for node in self.NODES:
                self.start("slurmd", "-D", "-N", node, "-f", f"{self.folder}/slurm.conf", name=node)
            self.wait(lambda: self.ask("sinfo", "--noheader", "--Node", "--format=%T").split() == ["idle"] * len(self.NODES), 60, "the nodes")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if "slurmctld" in self.running:
            self.ask("scancel", "--user=root", timeout=10)
        for name in (*self.NODES, "slurmctld", "munged"):
            self.kill(name)
        shutil.rmtree(self.folder, ignore_errors=True)

    def start(self, program, *words, name=None):
        """In the foreground, as a child that ends with this process: so that its end is known, and its jobs can be found."""
        path = shutil.which(program, path=self.environment["PATH"])
        with (self.folder / f"{name or program}.out").open("ab") as out:
            self.running[name or program] = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", path, *words], env=self.environment,
                                                             stdin=subprocess.DEVNULL, stdout=out, stderr=out, start_new_session=True)

    def kill(self, name):
        """A node is killed with its jobs: their shepherds are in sessions of their own and may have lost their parent."""
        process = self.running.pop(name, None)
        if process is None:
            return
        victims = [process.pid]
        if name in self.NODES:
            victims += [one for shepherd in self.shepherds(name) for one in [shepherd, *descendants(shepherd)]]
        for victim in victims:
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                pass
        process.wait()

    def shepherds(self, node):
        """slurmstepd processes of this node: those that write to its log."""
        return [pid for pid in processes() if self.is_shepherd(pathlib.Path(f"/proc/{pid}"), node)]

    def is_shepherd(self, process, node):
        try:
            return (os.path.basename(os.readlink(process / "exe")).startswith("slurmstepd")
                    and any(os.readlink(entry) == f"{self.folder}/slurmd-{node}.log" for entry in (process / "fd").iterdir()))
        except OSError:
            return False

    def ask(self, *words, timeout=30):
        try:
            ended = subprocess.run(words, env=self.environment, text=True, capture_output=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            return ""
        return ended.stdout

    def jobs_on(self, node):
        return self.ask("squeue", "--noheader", "--states=running", f"--nodelist={node}", "--format=%i").split()

    @staticmethod
    def wait(condition, seconds, what):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"{what}: not after {seconds} s")
            time.sleep(0.1)
