"""Runs the program with limits and collects its outcome."""

import dataclasses
import os
import resource
import signal
import subprocess
import time

OUTPUT_BYTES = 1 << 20  # bytes of stdout and stderr that are read
NOBODY = 65534  # user of the run if permissions must apply but the test runs as root


@dataclasses.dataclass
class Outcome:
    command: list
    exit_code: int | None = None  # absent if ended by a signal
    signal: int = 0
    timed_out: bool = False
    seconds: float = 0.0
    peak_mb: float = 0.0
    out: str = ""
    err: str = ""


@dataclasses.dataclass
class Conditions:
    """Limits, environment, streams and signals of a run."""

    limits: dict = dataclasses.field(default_factory=dict)  # resource.RLIMIT_*: value
    environment: dict = dataclasses.field(default_factory=dict)  # the value None removes a name
    closed: tuple = ()  # file descriptors closed at the start
    stdout: str | None = None  # a file such as /dev/full
    stderr: str | None = None
    as_nobody: bool = False
    signals: tuple = ()  # (seconds after the start, signal), in order
    time_limit_s: float = 30.0


class Program:
    def __init__(self, path, time_limit_s):
        self.path = os.path.abspath(path)
        self.time_limit_s = time_limit_s
        with open(self.path, "rb") as binary:
            self.sanitized = b"__asan_init" in binary.read()

    def run(self, arguments, folder, conditions=None):
        process = Process(self, arguments, folder, conditions or Conditions())
        return process.finish()


class Process:
    def __init__(self, program, arguments, folder, conditions):
        self.conditions = conditions
        self.limit_s = min(conditions.time_limit_s, program.time_limit_s)
        if program.sanitized:
            self.limit_s *= 10
        self.command = [program.path, *arguments]
        self.logs = []
        streams = []
        for name, other in (("stdout", conditions.stdout), ("stderr", conditions.stderr)):
            log = os.path.join(folder, f"log_{name}_{time.monotonic_ns()}")
            self.logs.append(None if other else log)
            streams.append(open(other or log, "wb"))
        self.begin = time.monotonic()
        self.child = subprocess.Popen(
            self.command, cwd=os.path.join(folder, "here"), stdin=subprocess.DEVNULL,
            stdout=streams[0], stderr=streams[1], env=self._environment(folder),
            start_new_session=True, preexec_fn=lambda: self._prepare(program))
        for stream in streams:
            stream.close()

    def _environment(self, folder):
        environment = dict(os.environ, TMPDIR=os.path.join(folder, "tmp"))
        for name, value in self.conditions.environment.items():
            environment.pop(name, None)
            if value is not None:
                environment[name] = value
        return environment

    def _prepare(self, program):
        limits = dict(self.conditions.limits)
        if not program.sanitized:
            limits.setdefault(resource.RLIMIT_AS, 4 << 30)
        limits.setdefault(resource.RLIMIT_CORE, 0)
        for name, value in limits.items():
            resource.setrlimit(name, (value, value))
        if resource.RLIMIT_FSIZE in limits:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        if self.conditions.as_nobody and os.geteuid() == 0:
            os.setgroups([])
            os.setgid(NOBODY)
            os.setuid(NOBODY)
        for descriptor in self.conditions.closed:
            os.close(descriptor)

    def _poll(self):
        pid, status, usage = os.wait4(self.child.pid, os.WNOHANG)
        return None if pid == 0 else (status, usage)

    def finish(self):
        outcome = Outcome(self.command)
        waiting = list(self.conditions.signals)
        ended = None
        while ended is None:
            ended = self._poll()
            now = time.monotonic() - self.begin
            if ended is None and waiting and now >= waiting[0][0]:
                os.kill(self.child.pid, waiting.pop(0)[1])
            elif ended is None and now > self.limit_s:
                outcome.timed_out = True
                os.killpg(self.child.pid, signal.SIGKILL)
            if ended is None:
                time.sleep(0.002)
        status, usage = ended
        self.child.returncode = 0  # the child has been waited for
        outcome.seconds = time.monotonic() - self.begin
        outcome.peak_mb = usage.ru_maxrss / 1024
        if os.WIFEXITED(status):
            outcome.exit_code = os.WEXITSTATUS(status)
        else:
            outcome.signal = os.WTERMSIG(status)
        outcome.out, outcome.err = (self._take(log) for log in self.logs)
        return outcome

    @staticmethod
    def _take(log):
        if log is None:
            return ""
        with open(log, "rb") as stream:
            text = stream.read(OUTPUT_BYTES).decode("utf-8", "replace")
        os.remove(log)
        return text
