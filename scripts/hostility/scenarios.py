"""What is done to the daemon, by name. Each takes a Bench and returns a row: sent, answered, latencies, what was said, promises broken."""
import itertools
import multiprocessing
import os
import random
import resource
import signal
import socket
import struct
import subprocess
import time

from . import wire


def counts(row, *names):
    return ", ".join(f"{row['counts'].get(name, 0)} {name}" for name in names)


def require(row, holds, promise):
    if not holds:
        row["broken"].append(promise)


def network(*arguments, least):
    """Faults of the network between tracker and daemon, by `tissuectl track`; `least`: share of the frames to be answered."""
    def run(bench):
        daemon = bench.daemon()
        row = bench.under_load(daemon, tracking=arguments)
        daemon.end()
        row["said"] = counts(row, "frames_missing", "late_datagrams", "duplicate_datagrams", "frames_deadline", "frames_skipped")
        require(row, row["answered"] >= least * row["sent"], f"less than {least:.0%} of the frames were answered")
        return row
    return run


def flood(payloads, target, tracking=(), options=()):
    """`payloads`: from a random generator to an endless iterator of datagrams, sent as fast as this machine can."""
    def run(bench):
        daemon = bench.daemon(*options)
        address = getattr(daemon, target)

        def disturb(until):
            time.sleep(1.0)  # by then the tracker's stream has begun
            counter = multiprocessing.Value("Q", 0)
            sender = multiprocessing.Process(target=_send_all, args=(payloads, address, until, counter))
            sender.start()
            sender.join()
            return {"datagrams": counter.value}
        row = bench.under_load(daemon, disturb, tracking=tracking)
        daemon.end()
        row["said"] = f"{row['told']['datagrams']} foreign datagrams; " + counts(row, "kernel_drops", "foreign_datagrams", "requests_limited", "frames_skipped")
        require(row, row.get("grown_mb", 0) < 8, "memory grew by more than 8 MB")
        return row
    return run


def _send_all(payloads, address, until, counter):
    outlet = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    outlet.connect(address)
    outlet.setblocking(False)
    for payload in payloads(random.Random(7)):
        try:
            outlet.send(payload)
            counter.value += 1
        except OSError:
            pass  # no room, or nobody reads the answers
        if counter.value % 64 == 0 and time.monotonic() > until:
            return


def garbage(generator):
    good = wire.tracker_frame(5, [("A1", (1.0, 2.0, 3.0))], [("M1", (0.0, 0.0, 1.0))], 7)
    while True:
        kind = generator.randrange(4)
        if kind == 0:
            yield generator.randbytes(generator.randrange(0, 1472))
        elif kind == 1:
            yield good[:generator.randrange(len(good))]
        elif kind == 2:
            place = generator.randrange(len(good))
            yield good[:place] + bytes([generator.randrange(256)]) + good[place + 1:]
        else:
            yield wire.client_message("hello", 1)[:generator.randrange(48)]


def foreign_frames(_):
    return (wire.tracker_frame(number, [("A1", (500.0, 500.0, 500.0))]) for number in itertools.count(1))


def requests(generator):
    kinds = list(wire.CLIENT_TYPES)
    return (wire.client_message(generator.choice(kinds), number % 2**32) for number in itertools.count(1))


def absurd(bench):
    """A tracker that sends what cannot be: NaN, poses beyond the room, jumps of a metre, frame numbers and stamps that leap."""
    daemon = bench.daemon()

    def disturb(until):
        outlet, generator, number, sent = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), random.Random(3), 1, 0
        while time.monotonic() < until:
            number += generator.choice((1, 1, 1, 0, -5, 1000, 2**31))
            place = generator.choice(((float("nan"), 0, 0), (1e300, 0, 0), (9e4, 9e4, 9e4), (-1000.0, 0.0, 0.0), (0.0, 0.0, 60.0)))
            stamp = generator.choice((None, 0, 2**64 - 1, time.monotonic_ns()))
            outlet.sendto(wire.tracker_frame(number, [(f"A{generator.randrange(4)}", place)], [(f"M{generator.randrange(20):02}", place)], stamp), daemon.tracker)
            sent += 1
            time.sleep(0.002)
        return {"datagrams": sent}
    time.sleep(0.2)
    told = disturb(time.monotonic() + bench.seconds)
    row = {"sent": told["datagrams"], "answered": "-", "told": told, "broken": [], "counts": daemon.counters() if daemon.lives() else {}}
    require(row, daemon.lives(), "the daemon has ended")
    if daemon.lives():
        bench.require_peace(daemon, row, ())
    daemon.end()
    row["said"] = counts(row, "tracker:not_finite", "tracker:absurd_magnitude", "jump_suspects", "restarts", "steps_not_finite", "dt_clamped")
    return row


def spoofed(bench):
    """Single frames far ahead, which say that they come from the tracker's own address and port."""
    if os.geteuid() != 0:
        return {"said": "skipped: only root may write a source address", "broken": []}
    daemon = bench.daemon()

    def disturb(until):
        time.sleep(0.5)
        outlet, sent = socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_RAW), 0
        source = source_of(daemon.tracker)
        while time.monotonic() < until:
            frame = wire.tracker_frame(10**6 + 7919 * sent, [("A1", (200.0, 200.0, 200.0))])
            outlet.sendto(wire.spoofed(source, daemon.tracker, frame), daemon.tracker)
            sent += 1
            time.sleep(0.05)
        return {"datagrams": sent}
    row = bench.under_load(daemon, disturb)
    daemon.end()
    row["said"] = f"{row['told']['datagrams']} in the tracker's name; " + counts(row, "jump_suspects", "forward_jumps", "restarts")
    require(row, row["counts"].get("forward_jumps", 0) == 0, "a single frame carried the stream away")
    require(row, row["answered"] >= 0.97 * row["sent"], "less than 97 % of the frames were answered")
    return row


def source_of(destination):
    """Of the socket that is connected to `destination`, as the kernel's table has it."""
    wanted = "0100007F:%04X" % destination[1]
    with open("/proc/net/udp") as table:
        for line in table.readlines()[1:]:
            local, remote = line.split()[1:3]
            if remote == wanted:
                return "127.0.0.1", int(local.split(":")[1], 16)
    raise SystemExit("scripts/hostile: no tracker is connected")


def replayed(bench):
    """Somebody in between repeats every sealed datagram twice, sends it from elsewhere, and changes a byte of a copy."""
    keys, tracker_keys, client_keys = bench.keys()
    daemon = bench.daemon("--keys", keys)
    inlet, outlet, other = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3))
    inlet.bind(("127.0.0.1", 0))
    outlet.connect(daemon.tracker)
    for end in (inlet, outlet):
        end.setblocking(False)

    def disturb(until):
        sent, sender, seen = 0, None, []
        while time.monotonic() < until + 0.5:
            try:
                datagram, sender = inlet.recvfrom(2048)
                outlet.send(datagram)
                seen.append(datagram)
                if datagram[5] == 0:
                    copies = [seen[-1], seen[len(seen) // 2]]
                    for copy in copies:
                        outlet.send(copy)
                    other.sendto(datagram, daemon.tracker)
                    place = sent % len(datagram)
                    outlet.send(datagram[:place] + bytes([datagram[place] ^ 1]) + datagram[place + 1:])
                    sent += 4
            except BlockingIOError:
                time.sleep(0.0005)
            try:
                answer = outlet.recv(2048)
                if sender:
                    inlet.sendto(answer, sender)
            except BlockingIOError:
                pass
        return {"datagrams": sent}
    row = bench.under_load(daemon, disturb, tracking=("--keys", tracker_keys), watching=("--keys", client_keys), to=inlet.getsockname())
    daemon.end()
    refused = {key: value for key, value in row["counts"].items() if key.startswith("seal:") and key != "seal:accepted"}
    row["said"] = f"{row['told']['datagrams']} repeated or forged; refused: " + ", ".join(f"{value} {key[5:]}" for key, value in refused.items())
    require(row, row["counts"].get("tracker:accepted", 0) <= row["told"]["datagrams"] // 4, "a datagram was taken twice")
    require(row, row["answered"] >= 0.9 * row["sent"], "less than 90 % of the frames were answered")
    return row


def amplification(bench):
    """Bytes that come back for those that are sent by somebody who never shows that he receives."""
    daemon = bench.daemon("--set", "clients.prove_addresses=true")

    def disturb(until):
        spy = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        spy.setblocking(False)
        out = back = 0
        for payload in requests(random.Random(5)):
            spy.sendto(payload, daemon.clients)
            out += len(payload)
            time.sleep(0.0005)
            try:
                while True:
                    back += len(spy.recv(4096))
            except BlockingIOError:
                pass
            if time.monotonic() > until:
                return {"out": out, "back": back}
    row = bench.under_load(daemon, disturb)
    daemon.end()
    told = row["told"]
    row["amplification"] = told["back"] / told["out"]
    row["said"] = f"{told['out']} bytes asked, {told['back']} answered: factor {row['amplification']:.2f}; " + counts(row, "requests_unproven")
    require(row, row["amplification"] <= 1.0, "more was sent than was asked")
    return row


def deaf_subscribers(bench):
    """A hundred who subscribe to everything and never read."""
    daemon = bench.daemon("--set", "clients.max_subscribers=101")
    deaf = []

    def disturb(until):
        for _ in range(100):
            end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            end.connect(daemon.clients)
            deaf.append(end)
        sequence = 0
        while time.monotonic() < until:
            sequence += 1
            for end in deaf:
                end.send(wire.client_message("subscribe", sequence))
            time.sleep(2.0)
        return {}
    row = bench.under_load(daemon, disturb)
    daemon.end()
    row["said"] = counts(row, "datagrams_sent", "sends_failed", "clients_refused")
    require(row, row["answered"] >= 0.9 * row["sent"], "less than 90 % of the frames were answered")
    require(row, row.get("grown_mb", 0) < 8, "memory grew by more than 8 MB")
    return row


def tracker_restart(bench):
    """The tracker ends and begins anew, from another port and at frame 1, every second."""
    daemon = bench.daemon()

    def disturb(until):
        restarts = 0
        while time.monotonic() < until:
            bench.track(daemon.tracker, 0.7).communicate()
            restarts += 1
        return {"restarts": restarts}
    time.sleep(0.2)
    watch = bench.watch(daemon, bench.seconds)
    told = disturb(time.monotonic() + bench.seconds)
    watch.communicate()
    row = {"sent": 70 * told["restarts"], "answered": daemon.counters()["frames_stepped"], "counts": daemon.counters(), "broken": []}
    bench.require_peace(daemon, row, ())
    daemon.end()
    row["said"] = f"{told['restarts']} restarts; " + counts(row, "restarts", "restart_suspects", "foreign_datagrams")
    require(row, row["answered"] >= 0.8 * row["sent"], "less than 80 % of the frames were stepped")
    return row


def killed(bench):
    """kill -9 at random moments while it records: what is lost, and what can still be read."""
    generator, lost_ms, torn, replayed_steps, broken = random.Random(11), [], [], 0, []
    for trial in range(max(3, int(bench.seconds / 2))):
        file = bench.path(f"killed-{trial}.rec")
        daemon = bench.daemon("--record", file)
        outlet = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        end, number, when = time.monotonic() + generator.uniform(0.7, 2.0), 0, {}
        due = time.monotonic()
        while time.monotonic() < end:
            number += 1
            outlet.sendto(wire.tracker_frame(number, [("A1", (50.0, 0.0, 30.0))], stamp_ns=number * 2_000_000), daemon.tracker)
            when[number] = time.monotonic()
            due += 0.002
            time.sleep(max(0.0, due - time.monotonic()))
        killed_at = time.monotonic()
        daemon.end(signal.SIGKILL)
        found, rest = wire.records(file)
        last = max((struct.unpack_from("<I", body)[0] for kind, _, body in found if kind == 1), default=0)
        lost_ms.append(1e3 * (killed_at - when.get(last + 1, killed_at)))
        torn.append(rest)
        replay = subprocess.run([bench.tissuectl, "replay", file, "--json"], capture_output=True, text=True, check=False)
        if replay.returncode != 0:
            broken.append(f"replay of {file}: {replay.stderr.strip() or replay.stdout.strip()}")
        else:
            replayed_steps += 1
    row = {"broken": broken, "lost_ms": lost_ms, "torn_bytes": torn}
    row["said"] = f"{len(lost_ms)} kills: at most {max(lost_ms):.0f} ms lost, {sum(1 for rest in torn if rest)} torn tails, {replayed_steps} replayed bit for bit"
    require(row, max(lost_ms) <= 100.0, "more than 100 ms were lost")
    return row


def disk_full(bench):
    """The recording's disk is full after 200 kB."""
    file = bench.path("full.rec")
    daemon = bench.daemon("--record", file, limit=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000)))
    row = bench.under_load(daemon)
    ended = daemon.end()
    found, rest = wire.records(file)
    row["said"] = f"{len(found)} records kept, {rest} bytes torn; " + counts(row, "records_lost", "recording_failed", "frames_skipped")
    require(row, ended == 0, "the daemon did not end as it should")
    require(row, row["counts"].get("recording_failed") == 1, "nobody was told")
    require(row, row["answered"] >= 0.97 * row["sent"], "less than 97 % of the frames were answered")
    return row


def clock(bench):
    """The machine's wall clock jumps by an hour, back and forth."""
    daemon = bench.daemon()

    def disturb(until):
        began, real = time.monotonic(), time.time()
        try:
            for turn in itertools.count():
                if time.monotonic() > until:
                    return {"jumps": turn}
                time.clock_settime(time.CLOCK_REALTIME, real + time.monotonic() - began + (-3600.0, 3600.0)[turn % 2])
                time.sleep(0.5)
        except PermissionError:
            return {"jumps": 0}
        finally:
            try:
                time.clock_settime(time.CLOCK_REALTIME, real + time.monotonic() - began)
            except PermissionError:
                pass
    row = bench.under_load(daemon, disturb)
    daemon.end()
    row["said"] = f"{row['told']['jumps']} jumps of an hour; " + counts(row, "frames_skipped", "stamps_refused") if row["told"]["jumps"] else "skipped: this machine's clock may not be set"
    require(row, row["answered"] >= 0.97 * row["sent"], "less than 97 % of the frames were answered")
    return row


def stuck(bench):
    """The whole daemon is stopped by a debugger's signal, half a second at a time."""
    daemon = bench.daemon()

    def disturb(until):
        stops = 0
        while time.monotonic() < until:
            daemon.process.send_signal(signal.SIGSTOP)
            time.sleep(0.5)
            daemon.process.send_signal(signal.SIGCONT)
            time.sleep(0.5)
            stops += 1
        return {"stops": stops}
    row = bench.under_load(daemon, disturb)
    daemon.end()
    row["said"] = f"stopped {row['told']['stops']} times; " + counts(row, "frames_skipped", "kernel_drops", "steps_braked")
    return row


ALL = {
    "undisturbed": network(least=0.98),
    "loss-10": network("--loss", "0.1", least=0.8),
    "loss-50": network("--loss", "0.5", least=0.4),
    "reorder-20": network("--reorder", "0.2", least=0.75),
    "duplicate-30": network("--duplicate", "0.3", least=0.97),
    "delay-and-jitter": network("--delay-ms", "80", "--jitter-ms", "25", least=0.5),
    "all-at-once": network("--loss", "0.1", "--reorder", "0.1", "--duplicate", "0.1", "--delay-ms", "30", "--jitter-ms", "10", least=0.4),
    "garbage-at-tracker": flood(garbage, "tracker"),
    "garbage-at-clients": flood(garbage, "clients"),
    "foreign-tracker": flood(foreign_frames, "tracker"),
    "requests-flood": flood(requests, "clients"),
    "absurd-tracker": absurd,
    "spoofed-frames": spoofed,
    "replayed": replayed,
    "amplification": amplification,
    "deaf-subscribers": deaf_subscribers,
    "tracker-restart": tracker_restart,
    "stopped": stuck,
    "killed": killed,
    "disk-full": disk_full,
    "clock": clock,
}
