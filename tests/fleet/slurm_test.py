"""The Slurm array of docs/tasks/fleets.md on slurmctld and two slurmd of this machine, of which one
is killed, and so are a step and a task."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fleets

CHUNKS = 20
CONFIG = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={place}/munge.sock,cred_expire=10
StateSaveLocation={place}/state
SlurmdSpoolDir={place}/spool/%n
SlurmctldPidFile={place}/slurmctld.pid
SlurmdPidFile={place}/slurmd-%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
KillWait=2
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    """munged, slurmctld and slurmd n1, n2."""

    def __init__(self, place):
        self.place = place
        for name in ("state", "spool/n1", "spool/n2"):
            (place / name).mkdir(parents=True)
        (place / "key").write_bytes(os.urandom(1024))
        (place / "key").chmod(0o600)
        config = place / "slurm.conf"
        config.write_text(CONFIG.format(host=socket.gethostname().partition(".")[0], place=place,
                                        ports=free_ports(3)))
        os.environ["SLURM_CONF"] = str(config)
        self.run("munged", "--force", "-S", place / "munge.sock", f"--key-file={place}/key",
                 f"--pid-file={place}/munged.pid", f"--log-file={place}/munged.log",
                 f"--seed-file={place}/seed")
        self.run("slurmctld", "-f", config, "-L", place / "slurmctld.log")
        self.start_node("n1")
        self.start_node("n2")

    def run(self, *command):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, cwd=self.place)
        assert done.returncode == 0, (command, done.stderr)
        return done.stdout

    def start_node(self, name):
        self.run("slurmd", "-N", name, "-f", self.place / "slurm.conf", "-L",
                 self.place / f"{name}.log")

    def kill_node(self, name):
        os.kill(int((self.place / f"slurmd-{name}.pid").read_text()), signal.SIGKILL)
        print("killed slurmd", name)

    def num_jobs(self):
        return len(self.run("squeue", "--noheader", "--array").splitlines())

    def stop(self):
        subprocess.run(["scancel", "--user=root"], capture_output=True)
        for name in ("slurmd-n1", "slurmd-n2", "slurmctld", "munged"):
            pid = self.place / f"{name}.pid"
            try:
                os.kill(int(pid.read_text()), signal.SIGTERM)
            except (OSError, ValueError):
                pass
        time.sleep(1)
        while fleets.kill_one(self.place, "slurmstepd") or fleets.kill_one(self.place, "slurmd"):
            pass


def trouble(cluster, place):
    """Kills a task, a step and a node while the first chunks are calibrated."""
    fleets.wait_for("a first set", lambda: fleets.num_done(place, "fleet") > 0)
    fleets.wait_for("a task", lambda: fleets.kill_one(place, "--chunk"))
    fleets.wait_for("a step", lambda: fleets.kill_one(place, "slurmstepd"))
    cluster.kill_node("n2")
    fleets.wait_for("more sets", lambda: fleets.num_done(place, "fleet") > fleets.SETS // 4)
    cluster.start_node("n2")


def run_array(cluster, place, troubled):
    cluster.run("sbatch", "fleet.sh")
    if troubled:
        trouble(cluster, place)
    fleets.wait_for("the array", lambda: cluster.num_jobs() == 0, 600)


def main():
    for program in ("slurmctld", "slurmd", "munged", "sbatch"):
        if not shutil.which(program):
            fleets.skip(f"{program} is not installed")
    if os.geteuid() != 0:
        fleets.skip("needs root")
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        place.chmod(0o755)
        fleets.make_sets(place)
        seconds = fleets.calibrate_serially(place)
        os.environ["PATH"] = str(Path(fleets.COMMAND).parent) + os.pathsep + os.environ["PATH"]
        (place / "fleet.sh").write_text(fleets.file_of_page("fleet.sh"))
        cluster = Cluster(place)
        try:
            begin = time.monotonic()
            run_array(cluster, place, True)
            rounds = 1
            while fleets.num_done(place, "fleet") < fleets.SETS:
                before = fleets.times(place, "fleet")
                run_array(cluster, place, False)
                fleets.check_nothing_twice(before, fleets.times(place, "fleet"))
                rounds += 1
                assert rounds < 5, f"{fleets.num_done(place, 'fleet')} of {fleets.SETS} sets"
            print(f"{fleets.SETS} sets: {seconds:.1f} s serially, {time.monotonic() - begin:.1f} s in "
                  f"{rounds} arrays with the kills")
        finally:
            cluster.stop()
        fleets.check_equal(place, "fleet")
        fleets.check_fleet(place, "fleet")


if __name__ == "__main__":
    sys.exit(main())
