"""A daemon, a tracker and a subscriber of our own, and what they say."""
import json
import os
import re
import signal
import subprocess
import tempfile
import time
import urllib.request


class Daemon:
    def __init__(self, binary, arguments, limit=None):
        self.errors = tempfile.TemporaryFile(mode="w+")
        self.process = subprocess.Popen([binary, "--tracker-port", "0", "--client-port", "0", "--set", "metrics.port=0", *arguments], text=True,
                                        stdout=subprocess.PIPE, stderr=self.errors, preexec_fn=limit)
        line = self.process.stdout.readline()
        ports = dict(re.findall(r"(\w+)=(\d+)", line))
        if not ports:
            self.errors.seek(0)
            raise SystemExit("scripts/hostile: tissued did not start: " + self.errors.read())
        self.tracker, self.clients, self.metrics = (("127.0.0.1", int(ports[key])) for key in ("tracker", "clients", "metrics"))

    def counters(self):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.metrics[1]}/metrics", timeout=10) as reply:
            text = reply.read().decode()
        return {key: int(float(value)) for key, value in re.findall(r'^tissued_events_total\{event="([^"]+)"\} (\S+)', text, re.M)}

    def memory_mb(self):
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(re.search(r"VmRSS:\s+(\d+)", status.read()).group(1)) / 1024

    def lives(self):
        return self.process.poll() is None

    def end(self, number=signal.SIGTERM):
        if self.lives():
            self.process.send_signal(number)
        code = self.process.wait(20)
        self.process.stdout.close()
        return code


class Bench:
    def __init__(self, folder, bundle, seconds):
        self.tissued, self.tissuectl = os.path.join(folder, "tissued"), os.path.join(folder, "tissuectl")
        self.bundle, self.seconds = bundle, seconds
        self.scratch = tempfile.TemporaryDirectory(prefix="tissued-hostile-")

    def path(self, name):
        return os.path.join(self.scratch.name, name)

    def daemon(self, *arguments, limit=None):
        return Daemon(self.tissued, ["--bundle", self.bundle, "--set", "alarm.enabled=false", *arguments], limit)

    def daemon_of(self, config, *arguments):
        return Daemon(self.tissued, ["--config", config, *arguments])

    def track(self, to, seconds, *arguments):
        return subprocess.Popen([self.tissuectl, "track", self.bundle, "--to", "%s:%d" % to, "--seconds", str(seconds), "--json", "--period", "3", *arguments],
                                stdout=subprocess.PIPE, text=True)

    def watch(self, daemon, seconds, *arguments):
        return subprocess.Popen([self.tissuectl, "watch", "--from", "%s:%d" % daemon.clients, "--seconds", str(seconds), "--json", *arguments],
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def keys(self):
        """(all, tracker's, client's), files."""
        paths = [self.path(key) for key in ("keys", "tracker.keys", "client.keys")]
        if not os.path.exists(paths[0]):
            os.umask(0o077)
            lines = [subprocess.run([self.tissuectl, "key", role, "--role", role], check=True, capture_output=True, text=True).stdout
                     for role in ("tracker", "client")]
            for path, text in zip(paths, ("".join(lines), *lines)):
                with open(path, "w") as out:
                    out.write(text)
        return paths

    def under_load(self, daemon, disturb=None, tracking=(), watching=(), to=None):
        """Frames and answers while `disturb(until)` goes on in this thread; then, when it is over, two seconds of peace."""
        time.sleep(0.2)
        watch = self.watch(daemon, self.seconds + 1.0, *watching)
        memory = daemon.memory_mb()
        track = self.track(to or daemon.tracker, self.seconds, *tracking)
        before = daemon.counters()
        told = disturb(time.monotonic() + self.seconds - 0.5) if disturb else {}
        sent = json.loads(track.communicate()[0])
        summary = json.loads(watch.communicate()[0].splitlines()[-1])["summary"]
        row = {"sent": sent["frames"], "answered": summary["frames"], "told": told or {}, "broken": []}
        row.update({f"{key}_ms": value for key, value in summary["receive_to_send_ms"].items()})
        errors = [target["mean_error_mm"] for target in summary["targets"].values() if target.get("mean_error_mm") is not None]
        row["error_mm"] = max(errors) if errors else None
        if not daemon.lives():
            row["broken"].append("the daemon has ended")
            row["counts"] = {}
            return row
        row["grown_mb"] = daemon.memory_mb() - memory
        row["counts"] = {key: value - before[key] for key, value in daemon.counters().items() if value != before[key]}
        self.require_peace(daemon, row, tracking)
        return row

    def require_peace(self, daemon, row, tracking):
        """After the disturbance everything is as before."""
        sealed = [argument for k, argument in enumerate(tracking) if argument == "--keys" or (k > 0 and tracking[k - 1] == "--keys")]
        watched = ["--keys", self.keys()[2]] if sealed else []
        time.sleep(1.2)  # a stream that was somebody else's is silent by then
        before = daemon.counters()["frames_stepped"]
        watch = self.watch(daemon, 2.5, *watched)
        track = self.track(daemon.tracker, 2.0, *sealed)
        sent = json.loads(track.communicate()[0])["frames"]
        watch.communicate()
        stepped = daemon.counters()["frames_stepped"] - before
        row["peace"] = {"sent": sent, "stepped": stepped}
        if stepped < 0.95 * sent:
            row["broken"].append(f"afterwards only {stepped} of {sent} frames were stepped")
