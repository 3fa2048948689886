"""A Slurm cluster of one node on the loopback interface, for tests: its own folder, ports and key.

Needs root and Debian's slurmctld, slurmd, slurm-client and munge; neither systemd, cgroups nor accounting.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

_PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "squeue", "sinfo", "scancel")
_SECONDS_TO_START = 30.0

_CONF = """\
ClusterName=tbi-test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1,bf_interval=1
ReturnToService=2
MailProg=/bin/true
MinJobAge=3600
KillWait=10
MaxArraySize={max_array_size}
NodeName={host} NodeAddr=127.0.0.1 Sockets=1 CoresPerSocket={cpus} ThreadsPerCore=1 RealMemory={memory}
PartitionName=debug Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def why_not() -> str:
    """Why no cluster can be started here; empty if one can."""
    if os.name != "posix" or os.geteuid() != 0:
        return "starting Slurm needs root"
    missing = [program for program in _PROGRAMS if shutil.which(program) is None]
    return f"Slurm is not installed: no {', '.join(missing)}" if missing else ""


class SlurmHere:
    """The running cluster; `environment` makes Slurm's commands talk to it."""

    def __init__(self, *, max_array_size: int = 1001) -> None:
        # Not in pytest's folder: munge wants every folder above its socket open to all.
        self.folder = folder = Path(tempfile.mkdtemp(prefix="tbi-slurm-"))
        self.environment = {"SLURM_CONF": str(folder / "slurm.conf")}
        self._processes: list[subprocess.Popen[bytes]] = []
        for name in ("state", "spool", "munge"):
            (folder / name).mkdir(parents=True)
        folder.chmod(0o755)
        (folder / "munge").chmod(0o755)
        key = folder / "munge.key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(128))
        host = socket.gethostname().split(".")[0]
        memory = re.search(r"RealMemory=(\d+)", _output("slurmd", "-C"))
        conf = _CONF.format(
            host=host,
            folder=folder,
            ports=_free_ports(2),
            cpus=os.cpu_count(),
            memory=memory[1] if memory else 1,
            max_array_size=max_array_size,
        )
        (folder / "slurm.conf").write_text(conf)
        (folder / "cgroup.conf").touch()
        try:
            self._start_munge()
            self._start("slurmctld", "-D", "-f", str(folder / "slurm.conf"))
            self._start("slurmd", "-D", "-f", str(folder / "slurm.conf"))
            self._wait(lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T"), "its node")
        except BaseException:
            self.stop()
            raise

    def _start(self, *command: str) -> None:
        with (self.folder / f"{command[0]}.out").open("wb") as log:
            self._processes.append(
                subprocess.Popen(command, env=os.environ | self.environment, stdout=log, stderr=log)
            )

    def _start_munge(self) -> None:
        self._start(
            *("munged", "--foreground", f"--key-file={self.folder / 'munge.key'}"),
            *(f"--socket={self.folder / 'munge' / 'socket'}", f"--pid-file={self.folder / 'munged.pid'}"),
            *(f"--log-file={self.folder / 'munged.log'}", f"--seed-file={self.folder / 'munged.seed'}"),
        )
        self._wait((self.folder / "munge" / "socket").exists, "munge")

    def _wait(self, ready: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + _SECONDS_TO_START
        while not ready():
            if time.monotonic() > end:
                raise RuntimeError(f"Slurm does not start: {what} is not there")
            time.sleep(0.05)

    def ask(self, *command: str) -> str:
        """What one of Slurm's commands prints; empty where it fails."""
        return _output(*command, **self.environment)

    def wait_for(self, *jobs: str, seconds: float) -> None:
        """Waits until none of the jobs is queued or running; raises TimeoutError."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            known = self.ask(
                "squeue", "--noheader", "--format=%A %F", "--states=PD,R,CG,CF,S,RQ,RD,RH"
            ).split()
            if not set(jobs) & set(known):
                return
            time.sleep(0.1)
        raise TimeoutError(self.ask("squeue"))

    def stop(self) -> None:
        """Takes back all jobs and ends the daemons that this cluster started."""
        self.ask("scancel", "--user=root")
        for process in reversed(self._processes):
            process.terminate()
        for process in self._processes:
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def _output(*command: str, **environment: str) -> str:
    done = subprocess.run(
        command, env=os.environ | environment, capture_output=True, text=True, timeout=60, check=False
    )
    return done.stdout


def _free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    try:
        for s in sockets:
            s.bind(("127.0.0.1", 0))
        return [s.getsockname()[1] for s in sockets]
    finally:
        for s in sockets:
            s.close()
