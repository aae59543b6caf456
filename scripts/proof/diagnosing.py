"""Runs `tissuectl diagnose` on a bundle and `predict` on its held-out trials, as the reader of seal.py."""
import json
import os
import subprocess
import time

from .seal import read


def environment():
    """One thread, and none of mpirun's marks: a program started here is a world of its own."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "PMIX_", "PMI_", "OPAL_", "PRTE_"))}
    return {**kept, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def is_done(folders, name):
    return os.path.exists(os.path.join(folders.result(name), "done.json"))


def _run(reader, children, command, log):
    return children.run(reader.prefix + command, stdout=log, stderr=subprocess.STDOUT, env=environment(), cwd="/")


def diagnose(folders, reader, children, tissuectl, name, budget):
    """Writes report.json, model.json, TRIAL.csv and TRIAL.assumed.csv; done.json comes last. Returns seconds."""
    bundle, out, began = folders.bundle(name), folders.result(name), time.monotonic()
    reader.own(out)
    log_path = os.path.join(out, "log.txt")
    with open(log_path, "w") as log:
        code, processor = _run(reader, children, [tissuectl, "diagnose", bundle, "--out", out, "--threads", "1", "--budget", str(budget), "--processor-time"], log)
        seconds, failed = time.monotonic() - began, []
        for trial in json.loads(read(os.path.join(bundle, "bundle.json")))["held_out"]:
            for model, path in (([], f"{trial}.assumed.csv"), (["--model", os.path.join(out, "model.json")], f"{trial}.csv")):
                if model and not os.path.exists(model[1]):
                    failed.append(path)
                elif _run(reader, children, [tissuectl, "predict", bundle, *model, "--trial", trial, "--out", os.path.join(out, path)], log)[0] != 0:
                    failed.append(path)
    with open(os.path.join(out, "done.json"), "w") as done:
        json.dump({"exit": code, "seconds": seconds, "processor_seconds": processor, "not_predicted": failed}, done)
    return seconds
