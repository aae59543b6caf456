"""Who may read what: names that tell nothing, answers in a folder of their own, and their hashes in the open.

    OUT/bundles/NAME   what is diagnosed
    OUT/sealed         root's own, mode 700: the salt of the names, NAME.json with the answers
    OUT/seals          NAME.sha256 of the answers, for all to see before anything is diagnosed
    OUT/results/NAME   what the diagnosis said; written by a user who cannot read OUT/sealed
"""
import hashlib
import json
import os
import pwd
import secrets
import shutil
import subprocess
import tempfile

OTHER = "nobody"


class SealError(Exception):
    pass


class Folders:
    def __init__(self, out):
        self._name(out)
        for folder in (self.out, self.bundles, self.seals, self.results):
            os.makedirs(folder, exist_ok=True)
        os.makedirs(self.sealed, mode=0o700, exist_ok=True)
        os.chmod(self.sealed, 0o700)

    def _name(self, out):
        self.out = os.path.abspath(out)
        self.bundles, self.sealed, self.seals, self.results = (os.path.join(self.out, k) for k in ("bundles", "sealed", "seals", "results"))

    @classmethod
    def at(cls, out):
        """Those of a run that is over: read, not made."""
        folders = cls.__new__(cls)
        folders._name(out)
        return folders

    def salt(self):
        """Hex; drawn once, by whoever comes first."""
        path = os.path.join(self.sealed, "salt")
        if not os.path.exists(path):
            file, own = tempfile.mkstemp(prefix="salt.", dir=self.sealed)  # threads and machines draw at once, each its own
            with open(file, "w") as out:
                out.write(secrets.token_hex(16))
            try:
                os.link(own, path)  # fails where another was faster
            except FileExistsError:
                pass
            os.remove(own)
        return read(path)

    def name(self, seed):
        """Of a case: says nothing of its seed to who does not know the salt, and sorts by chance."""
        return hashlib.sha256(f"{self.salt()} {seed}".encode()).hexdigest()[:12]

    def answers(self, name):
        return os.path.join(self.sealed, name + ".json")

    def seal_file(self, name):
        return os.path.join(self.seals, name + ".sha256")

    def bundle(self, name):
        return os.path.join(self.bundles, name)

    def result(self, name):
        return os.path.join(self.results, name)


def read(path):
    with open(path) as source:
        return source.read()


def hash_of(path):
    return hashlib.sha256(read(path).encode()).hexdigest()


def seal(folders, name):
    """Publishes the hash of a case's answers, once."""
    digest = hash_of(folders.answers(name))
    with open(folders.seal_file(name), "w") as out:
        out.write(digest + "\n")
    return digest


def hash_of_all(folders, names):
    """One hash for many seals: of the sorted lines `HASH  NAME`."""
    lines = sorted(f"{read(folders.seal_file(name)).strip()}  {name}\n" for name in names)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def opened(folders, name):
    """The answers, if they are those that were sealed."""
    if hash_of(folders.answers(name)) != read(folders.seal_file(name)).strip():
        raise SealError(f"{folders.answers(name)} is not what was sealed: its hash differs from {folders.seal_file(name)}")
    return json.loads(read(folders.answers(name)))


class Reader:
    """As whom the diagnosis runs: `nobody` where we are root, else ourselves, and then permissions protect nothing."""

    def __init__(self):
        self.is_other = os.geteuid() == 0 and shutil.which("setpriv") is not None
        self.prefix = []
        if self.is_other:
            account = pwd.getpwnam(OTHER)
            self.uid, self.gid = account.pw_uid, account.pw_gid
            self.prefix = ["setpriv", f"--reuid={self.uid}", f"--regid={self.gid}", "--clear-groups", "--no-new-privs"]

    def words(self):
        if self.is_other:
            return f"diagnoses as user {OTHER}, who was seen to fail to read the answers"
        return "diagnoses as the user who made the answers (not root): folders are apart, but permissions do not protect"

    def own(self, folder):
        os.makedirs(folder, exist_ok=True)
        if self.is_other:
            os.chown(folder, self.uid, self.gid)

    def can(self, flag, path):
        return subprocess.run(self.prefix + ["test", flag, path], check=False).returncode == 0

    def check(self, folders, name, program):
        """SealError unless the reader sees the bundle and the program, and not the answers."""
        for flag, path in (("-r", os.path.join(folders.bundle(name), "bundle.json")), ("-x", program)):
            if not self.can(flag, path):
                raise SealError(f"user {OTHER} cannot reach {path}: choose an --out (and a build) that others may enter")
        if self.is_other and (self.can("-r", folders.answers(name)) or self.can("-x", folders.sealed)):
            raise SealError(f"user {OTHER} can read {folders.sealed}: nothing is concealed")
