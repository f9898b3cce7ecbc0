"""A Slurm of two nodes on this machine, in a folder of its own; no configuration of the machine is read or changed."""
import getpass
import glob
import os
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo", "scancel", "scontrol")
CONFIGURATION = """ClusterName=talus
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
SlurmdParameters=config_overrides
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=2
SlurmdTimeout=5
KillWait=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 RealMemory=100000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 RealMemory=100000
PartitionName=p Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


class CannotRun(Exception):
    """Why there can be no Slurm here."""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Slurm:
    """`with Slurm(folder) as slurm:`; its commands work in the environment slurm.env."""

    def __init__(self, folder):
        self.folder = folder
        self.env = dict(os.environ, SLURM_CONF=f"{folder}/slurm.conf", PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")

    def __enter__(self):
        try:
            self.write_configuration()
            munge = f"{self.folder}/munge"
            self.start("munged", f"--key-file={munge}/key", f"--socket={munge}/socket", f"--pid-file={munge}/munged.pid",
                       f"--log-file={munge}/log", f"--seed-file={munge}/seed", "--force")
            self.start("slurmctld")
            for node in ("n1", "n2"):
                self.start("slurmd", "-N", node)
            self.wait_for_nodes(2, 30)
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def write_configuration(self):
        for name in ("munge", "state"):
            os.mkdir(os.path.join(self.folder, name), 0o700)
        descriptor = os.open(f"{self.folder}/munge/key", os.O_WRONLY | os.O_CREAT, 0o600)
        os.write(descriptor, os.urandom(1024))
        os.close(descriptor)
        with open(f"{self.folder}/slurm.conf", "w") as file:
            file.write(CONFIGURATION.format(folder=self.folder, host=socket.gethostname().split(".")[0], ports=free_ports(3),
                                            user=getpass.getuser()))

    def start(self, program, *arguments):
        ended = subprocess.run([program, *arguments], env=self.env, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                               timeout=60)
        if ended.returncode != 0:
            raise CannotRun(f"{program} does not start: {ended.stderr.strip()}")

    def ask(self, *command):
        return subprocess.run(command, env=self.env, capture_output=True, text=True, timeout=60).stdout

    def wait_for_nodes(self, count, seconds):
        end = time.monotonic() + seconds
        while self.ask("sinfo", "--noheader", "--Node", "--format=%T").split().count("idle") < count:
            if time.monotonic() > end:
                raise CannotRun("its nodes do not come up: " + self.ask("sinfo", "--Node").strip())
            time.sleep(0.2)

    def jobs_on(self, node):
        return self.ask("squeue", "--noheader", "--states=running", "--format=%i", f"--nodelist={node}").split()

    def processes(self, node=None, jobs=()):
        """Of this Slurm: its daemons and its jobs, or those of a node, where these jobs run."""
        steps = [f"slurmstepd: [{job}.".encode() for job in jobs]
        found = []
        for environ in glob.glob("/proc/[0-9]*/environ"):
            try:
                with open(environ, "rb") as file:
                    variables = file.read().split(b"\0")
                with open(environ.replace("environ", "cmdline"), "rb") as file:
                    command = file.read()
            except OSError:
                continue
            of_node = (f"SLURMD_NODENAME={node}".encode() in variables or command.endswith(f"\0-N\0{node}\0".encode())
                       or any(command.startswith(step) for step in steps))
            pid = int(environ.split("/")[2])
            if b"SLURM_CONF=" + self.env["SLURM_CONF"].encode() in variables and pid != os.getpid() and (of_node or not node):
                found.append(pid)
        return found

    def kill_node(self, node):
        """As a loss of power would end it: its daemon and all that runs there, before any can tell of another's end. Returns the
        jobs that are lost with it; without any the node lives on."""
        jobs = self.jobs_on(node)
        held = self.processes(node, jobs)
        kill(held, signal.SIGSTOP)
        time.sleep(0.5)  # a job that ended just before is told of by now
        lost, end = self.jobs_on(node), time.monotonic() + 10
        if not lost:
            kill(held, signal.SIGCONT)
        while lost and self.processes(node, jobs + lost) and time.monotonic() < end:
            kill(self.processes(node, jobs + lost))
            time.sleep(0.05)
        return lost

    def stop(self):
        for path in glob.glob(f"{self.folder}/*.pid") + glob.glob(f"{self.folder}/munge/*.pid"):
            with open(path) as file:
                text = file.read().strip()
            if text and self.is_ours(int(text)):
                kill([int(text)], signal.SIGTERM)
        end = time.monotonic() + 10
        while self.processes() and time.monotonic() < end:
            time.sleep(0.2)
        kill(self.processes())

    def is_ours(self, pid):
        return pid in self.processes()


def kill(pids, sent=signal.SIGKILL):
    for pid in pids:
        try:
            os.kill(pid, sent)
        except ProcessLookupError:
            pass
