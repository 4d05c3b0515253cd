"""Running programs: for what they print, and for what they take."""

import os
import resource
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
GPSRECON = ROOT / "build/release/bin/gpsrecon"


class Failure(Exception):
    """A script cannot go on."""


class ProgramFailed(Failure):
    """A program ended with `code`, which is not 0."""

    def __init__(self, command, code, errors):
        super().__init__(f"{' '.join(command)}: exit code {code}: {errors.strip()}")
        self.code = code


class RunFailed(Exception):
    """A measured run that came to no result, which is one."""


def output_of(command, folder=None):
    """What a command prints; raises ProgramFailed."""
    command = list(map(str, command))
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if result.returncode != 0:
        raise ProgramFailed(command, result.returncode, result.stderr)
    return result.stdout


class Gpsrecon:
    """The program gpsrecon, without its messages, in the working folder `folder`, with `threads` threads."""

    def __init__(self, path=GPSRECON, threads=None, folder=None):
        self.path, self.folder = path, folder
        self.always = ["--quiet", *(["--threads", threads] if threads else [])]

    def command(self, *arguments):
        return [self.path, *arguments, *self.always]

    def run(self, *arguments):
        """What it prints; raises ProgramFailed."""
        return output_of(self.command(*arguments), self.folder)

    def version(self):
        return output_of([self.path, "--version"]).strip()


# Starts a program and writes what it took to a file descriptor. A process of its own, and as small as can be: peak
# memory is never below that of the process that a program was forked from.
LAUNCHER = """
import os, sys, time
started = time.perf_counter()
child = os.fork()
if child == 0:
    try:
        os.execvp(sys.argv[2], sys.argv[2:])
    except OSError as error:
        os.write(2, f'{sys.argv[2]}: {error.strerror}'.encode())
        os._exit(127)
_, status, usage = os.wait4(child, 0)
wall = time.perf_counter() - started
code = os.waitstatus_to_exitcode(status)
os.write(int(sys.argv[1]), f'{code} {wall} {usage.ru_utime + usage.ru_stime} {usage.ru_maxrss}'.encode())
"""


def run_measured(command, timeout=None, memory_limit=None):
    """Wall and processor seconds and peak resident memory (MB) of a command, children included. Raises RunFailed where
    it fails, takes longer than `timeout` seconds, or needs more than `memory_limit` bytes of address space."""
    def limit():
        if memory_limit:
            resource.setrlimit(resource.RLIMIT_AS, (memory_limit, memory_limit))

    read, write = os.pipe()
    with tempfile.TemporaryFile() as output, open(read) as measured:
        launcher = subprocess.Popen([sys.executable, "-I", "-S", "-c", LAUNCHER, str(write), *map(str, command)],
                                    stdin=subprocess.DEVNULL, stdout=output, stderr=output, pass_fds=[write],
                                    preexec_fn=limit, start_new_session=True,
                                    env={**os.environ, "OMP_WAIT_POLICY": "PASSIVE"})
        os.close(write)
        try:
            launcher.wait(timeout)
        except subprocess.TimeoutExpired:
            raise RunFailed(f"stopped after {timeout:g} s") from None
        finally:
            if launcher.poll() is None:
                os.killpg(launcher.pid, signal.SIGKILL)
                launcher.wait()
        code, wall, cpu, peak_kb = measured.read().split()
        if int(code) != 0:
            output.seek(0)
            lines = output.read().decode(errors="replace").strip().splitlines()
            why = f"signal {-int(code)}" if int(code) < 0 else f"exit code {code}"
            raise RunFailed(f"{why}: {lines[-1][:200]}" if lines else why)
    return {"wall_s": round(float(wall), 3), "cpu_s": round(float(cpu), 3),
            "memory_MB": round(int(peak_kb) * 1024 / 1e6, 1)}


def exit_code_of(main):
    """Of a script: what `main` returns, or 3 and one line on standard error where it could not go on."""
    try:
        return main()
    except (Failure, RunFailed, OSError) as error:
        print(f"{Path(sys.argv[0]).name}: {error}", file=sys.stderr)
        return 3
