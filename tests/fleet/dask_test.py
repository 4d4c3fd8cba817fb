"""The Dask program of docs/tasks/fleets.md on a scheduler and two workers, of which one is killed."""

import importlib.util
import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fleets


def start(place, module, *arguments):
    log = open(place / f"{module}.log", "ab")
    return subprocess.Popen([sys.executable, "-m", f"distributed.cli.{module}", *arguments], cwd=place,
                            stdout=log, stderr=log)


def main():
    if not importlib.util.find_spec("distributed"):
        fleets.skip("python3-distributed is not installed")
    with tempfile.TemporaryDirectory() as folder, socket.socket() as free:
        place = Path(folder)
        fleets.make_sets(place)
        seconds = fleets.calibrate_serially(place)
        os.environ["PATH"] = str(Path(fleets.COMMAND).parent) + os.pathsep + os.environ["PATH"]
        (place / "fleet.py").write_text(fleets.file_of_page("fleet.py"))
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        free.close()
        address = f"tcp://127.0.0.1:{port}"
        quiet = ["--no-dashboard"]
        processes = [start(place, "dask_scheduler", "--host", "127.0.0.1", "--port", str(port), *quiet)]
        processes += [start(place, "dask_worker", address, "--nthreads", "1", "--no-nanny", "--name",
                            name, "--local-directory", str(place / name), *quiet)
                      for name in ("one", "two")]
        try:
            begin = time.monotonic()
            program = subprocess.Popen([sys.executable, "fleet.py", address], cwd=place,
                                       stdout=subprocess.PIPE, text=True)
            fleets.wait_for("a quarter", lambda: fleets.num_done(place, "fleet") > fleets.SETS // 4, 300)
            processes[2].kill()
            print("killed a worker")
            out, _ = program.communicate(timeout=600)
            print(out.strip())
            assert program.returncode == 0, program.returncode
            # A program of the killed worker may still be calibrating its last set.
            fleets.wait_for("the orphan", lambda: not fleets.processes_of(place, "--chunk"))
            print(f"{fleets.SETS} sets: {seconds:.1f} s serially, {time.monotonic() - begin:.1f} s")
        finally:
            for process in processes:
                process.kill()
                process.wait()
        fleets.check_equal(place, "fleet")
        fleets.check_fleet(place, "fleet")


if __name__ == "__main__":
    sys.exit(main())
