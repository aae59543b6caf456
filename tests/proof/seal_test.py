"""What is concealed stays so, and what was sealed cannot be changed unseen."""
import concurrent.futures
import json
import os
import stat
import subprocess
import tempfile
import threading
import unittest

from proof import seal


class Sealing(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        os.chmod(self.scratch.name, 0o755)
        self.folders = seal.Folders(os.path.join(self.scratch.name, "out"))

    def tearDown(self):
        self.scratch.cleanup()

    def write(self, name, answers):
        with open(self.folders.answers(name), "w") as out:
            json.dump(answers, out)

    def test_names_tell_nothing_without_the_salt(self):
        other = seal.Folders(os.path.join(self.scratch.name, "other"))
        names = [self.folders.name(seed) for seed in range(1, 20)]
        self.assertEqual(names, [self.folders.name(seed) for seed in range(1, 20)])
        self.assertFalse(set(names) & {other.name(seed) for seed in range(1, 20)})
        self.assertNotEqual(names, sorted(names))

    def test_who_starts_at_once_draws_one_salt(self):
        for attempt in range(50):
            folders, together = seal.Folders(os.path.join(self.scratch.name, f"out{attempt}")), threading.Barrier(4)

            def draw(_):
                together.wait()
                return folders.salt()

            with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:
                self.assertEqual(len(set(pool.map(draw, range(4)))), 1)
            self.assertEqual(os.listdir(folders.sealed), ["salt"])
            self.assertEqual(stat.S_IMODE(os.stat(os.path.join(folders.sealed, "salt")).st_mode), 0o600)

    def test_the_hash_is_that_of_sha256sum(self):
        self.write("abc", {"kinds": ["skin"]})
        digest = seal.seal(self.folders, "abc")
        self.assertEqual(digest, subprocess.run(["sha256sum", self.folders.answers("abc")], check=True, capture_output=True, text=True).stdout.split()[0])

    def test_answers_that_were_changed_are_refused(self):
        self.write("abc", {"kinds": ["skin"]})
        seal.seal(self.folders, "abc")
        self.assertEqual(seal.opened(self.folders, "abc"), {"kinds": ["skin"]})
        self.write("abc", {"kinds": []})
        with self.assertRaises(seal.SealError):
            seal.opened(self.folders, "abc")

    def test_answers_are_their_maker_s_alone(self):
        self.assertEqual(stat.S_IMODE(os.stat(self.folders.sealed).st_mode), 0o700)

    @unittest.skipUnless(os.geteuid() == 0, "only root can become somebody else")
    def test_the_reader_sees_bundles_and_no_answers(self):
        self.write("abc", {})
        os.makedirs(self.folders.bundle("abc"))
        with open(os.path.join(self.folders.bundle("abc"), "bundle.json"), "w") as out:
            out.write("{}")
        reader = seal.Reader()
        reader.check(self.folders, "abc", "/bin/true")
        self.assertTrue(reader.can("-r", os.path.join(self.folders.bundle("abc"), "bundle.json")))
        self.assertFalse(reader.can("-r", self.folders.answers("abc")))
        os.chmod(self.folders.sealed, 0o755)
        with self.assertRaises(seal.SealError):
            reader.check(self.folders, "abc", "/bin/true")


if __name__ == "__main__":
    unittest.main()
