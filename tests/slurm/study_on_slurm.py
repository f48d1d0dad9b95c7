#!/usr/bin/env python3
"""Runs a small study as a job array on a real Slurm on this machine, with daemons, ports and a folder of its own, which
are removed afterwards.

    study_on_slurm.py KERF SOURCE_FOLDER

Exit code 0: all checks passed, 1: a check failed, 77: skipped, with the reason (for example, Slurm or munge is not
installed).
"""

import ctypes
import glob
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

LIMIT_S = 240
SKIPPED = 77

STUDY = """
[study]
paths = ["idle"]
holdings = ["path"]
ticks_per_case = 1000
ticks_of_defaults = 1000
reference_tolerance = 0.05
[base]
voxel_mm = 0.4
[[knob]]
name = "rim_samples_per_pitch"
values = [1, 2, 3, 4, 5, 6, 7]
"""

CONFIG = """
ClusterName=kerf
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock
CryptoType=crypto/munge
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def find(program):
    return shutil.which(program) or shutil.which(program, path="/usr/sbin:/sbin:/usr/local/sbin")


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def wait_for(what, condition, limit_s=60):
    end = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError(f"not true within {limit_s} s: {what}")
        time.sleep(0.2)


class DaemonEnded(RuntimeError):
    """A daemon that ended immediately, for example because its port was taken after it was found free. Other ports may work."""


class Cluster:
    """Munge, controller and node, with all files in `folder`."""

    def __init__(self, folder):
        self.folder = folder
        self.host = socket.gethostname().split(".")[0]
        self.env = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"))
        for key in [k for k in self.env if k.startswith(("SLURM_", "SBATCH_")) and k != "SLURM_CONF"]:
            del self.env[key]
        self.daemons = []

    def start(self):
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        user = subprocess.run(["id", "-un"], check=True, capture_output=True, text=True).stdout.strip()
        (self.folder / "slurm.conf").write_text(
            CONFIG.format(folder=self.folder, host=self.host, user=user, controller_port=free_port(), node_port=free_port()))
        self.launch("munged", "-F", "-f", f"--socket={self.folder}/munge.sock", f"--key-file={key}",
                    f"--pid-file={self.folder}/munge.pid", f"--log-file={self.folder}/munge.log",
                    f"--seed-file={self.folder}/munge.seed")
        wait_for("munge is ready", lambda: (self.folder / "munge.sock").exists(), 20)
        self.launch("slurmctld", "-D", "-c", "-f", self.env["SLURM_CONF"])
        self.launch("slurmd", "-D", "-c", "-f", self.env["SLURM_CONF"])

        def idle():
            ended = [d.args[0] for d in self.daemons if d.poll() is not None]
            if ended:
                raise DaemonEnded(f"daemons that ended: {', '.join(ended)}")
            return "idle" in self.call("sinfo", "-h", "-o", "%T", check=False).split()

        wait_for("the node is idle", idle, 60)

    def launch(self, program, *arguments):
        with open(self.folder / f"{program}.out", "w") as out:
            self.daemons.append(subprocess.Popen([find(program), *arguments], env=self.env, stdin=subprocess.DEVNULL, stdout=out,
                                                 stderr=subprocess.STDOUT, preexec_fn=die_with_parent, start_new_session=True))

    def run(self, *command, env=()):
        return subprocess.run(command, env=dict(self.env, **dict(env)), capture_output=True, text=True, stdin=subprocess.DEVNULL,
                              timeout=60, cwd=self.folder)

    def call(self, *command, check=True, env=()):
        done = self.run(*command, env=env)
        if check and done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))}: exit {done.returncode}: {done.stderr.strip()}")
        return done.stdout

    def submit(self, *arguments, env=()):
        return self.call("sbatch", "--parsable", *map(str, arguments), env=env).split(";")[0].strip()

    def wait_until_ended(self, job):
        def has_ended():
            # The controller gives no information on the job if it does not answer in time or has already forgotten the
            # job.
            done = self.run("squeue", "-h", "-j", job)
            return not done.stdout.strip() if done.returncode == 0 else "Invalid job id" in done.stderr

        wait_for(f"job {job} has ended", has_ended, 120)

    def stop(self):
        if len(self.daemons) == 3:
            subprocess.run(["scancel", "--full", "-u", str(os.getuid())], env=self.env, capture_output=True, timeout=20, check=False)
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        # Processes started by the node's daemon survive the daemon. Those of this test have this folder in their
        # environment.
        for environ in glob.glob("/proc/[0-9]*/environ"):
            pid = int(environ.split("/")[2])
            try:
                whole = pathlib.Path(environ).read_bytes() + pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
                if pid != os.getpid() and os.fsencode(str(self.folder)) in whole:
                    os.kill(pid, signal.SIGKILL)
            except OSError:
                pass

    def show_logs(self):
        for log in sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out")):
            print(f"---- {log.name}\n{log.read_text(errors='replace')[-2000:]}", file=sys.stderr)


def hashes(folder):
    """Returns the contents of the records, without times."""
    found = {}
    for record in (folder / "cases").glob("*.json"):
        text = record.read_text()
        found[record.name] = re.findall(r'"(?:id|state|input|force_hash|bone_hash|force_p95|volume)": (.*)', text)
    return found


def check(condition, what):
    if not condition:
        raise RuntimeError(what)
    print(f"ok: {what}", flush=True)


def run_study(cluster, kerf, source):
    folder = cluster.folder
    (folder / "small.toml").write_text(STUDY)
    script = source / "tools/study.sbatch"
    env = {"KERF": str(kerf)}
    merge = f"{kerf} study --merge -o out"

    # There are four shards, one of which never runs. The merge depends on all of them, however they end.
    array = cluster.submit("--hold", "--array=0-3", script, "small.toml", "out", env=env)
    merged = cluster.submit(f"--dependency=afterany:{array}", "--output=merge.log", "--wrap", merge)
    cluster.call("scancel", f"{array}_2")
    cluster.call("scontrol", "release", array)
    cluster.wait_until_ended(array)
    cluster.wait_until_ended(merged)
    log = (folder / "merge.log").read_text()
    check(re.search(r"shard 2/4 is missing: \d+ cases?: idle\.path\.", log), "the merge names the shard that was cancelled")
    check(len(re.findall(r"shard \d/4 is", log)) == 1, "the merge names no other shard")
    check((folder / "out/shard-3-of-4/plan.json").exists(), "the other shards ran")

    # Adds the lost shard and repeats an existing one: nothing is counted twice.
    again = cluster.submit("--array=2,3", script, "small.toml", "out", env=dict(env, KERF_SHARDS="4"))
    merged = cluster.submit(f"--dependency=afterok:{again}", "--output=merge_2.log", "--wrap", merge + " && echo whole")
    cluster.wait_until_ended(again)
    cluster.wait_until_ended(merged)
    log = (folder / "merge_2.log").read_text()
    check("whole" in log and "missing" not in log, "the study is complete once the lost shard has run")

    done = subprocess.run([kerf, "study", "small.toml", "-o", "alone"], cwd=folder, capture_output=True, text=True, timeout=120)
    check(done.returncode == 0, f"the same study runs without Slurm {done.stderr.strip()}")
    alone = hashes(folder / "alone")
    check(len(alone) == 16 and hashes(folder / "out") == alone, "16 records, the same as those made without Slurm")


def main():
    kerf, source = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
    missing = [p for p in ("munged", "slurmctld", "slurmd", "sbatch") if not find(p)]
    if missing:
        print(f"skipped: {', '.join(missing)} not installed (Debian: slurm-wlm munge)")
        return SKIPPED

    def give_up(number, _):
        raise RuntimeError(f"ended by signal {number}" if number != signal.SIGALRM else f"not finished within {LIMIT_S} s")

    for number in (signal.SIGALRM, signal.SIGTERM, signal.SIGINT):
        signal.signal(number, give_up)
    signal.alarm(LIMIT_S)
    for last in (False, False, True):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_slurm_", dir="/tmp"))
        folder.chmod(0o755)
        cluster = Cluster(folder)
        try:
            cluster.start()
            run_study(cluster, kerf, source)
            return 0
        except (RuntimeError, subprocess.SubprocessError, OSError) as e:
            print(f"failed: {e}", file=sys.stderr)
            cluster.show_logs()
            if last or not isinstance(e, DaemonEnded):
                return 1
        finally:
            cluster.stop()
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
