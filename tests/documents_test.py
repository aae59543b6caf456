"""Every link of the tree's documents leads somewhere, and every script that they name exists."""
import os
import re
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ROOMS = ("", "core", "core/diagnosis", "daemon", "protocol", "scripts")


def documents():
    for room in ROOMS:
        for name in sorted(os.listdir(os.path.join(ROOT, room))):
            if name.endswith(".md"):
                yield os.path.join(room, name)


def text(path):
    with open(os.path.join(ROOT, path)) as source:
        return source.read()


def prose(words):
    """Without what stands in backticks, which may look like a link."""
    return re.sub(r"`[^`\n]*`", "", words)


def anchors(path):
    """As GitHub makes them of headings."""
    headings = re.findall(r"^#+ (.*)$", text(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


class Documents(unittest.TestCase):
    def test_all_are_looked_at(self):
        self.assertGreaterEqual(len(list(documents())), 6)

    def test_links_lead_somewhere(self):
        for document in documents():
            for target in re.findall(r"\]\(([^)]+)\)", prose(text(document))):
                path, _, anchor = target.partition("#")
                if "://" in path:
                    continue
                here = os.path.normpath(os.path.join(os.path.dirname(document), path)) if path else document
                self.assertTrue(os.path.exists(os.path.join(ROOT, here)), f"{document}: {target}")
                if anchor:
                    self.assertIn(anchor, anchors(here), f"{document}: {target}")

    def test_scripts_that_are_named_exist(self):
        for document in documents():
            for script in re.findall(r"\bscripts/([\w./-]*\w)", text(document)):
                self.assertTrue(os.path.exists(os.path.join(ROOT, "scripts", script)), f"{document}: scripts/{script}")

    def test_every_script_is_in_the_list_of_scripts(self):
        listed = text("scripts/README.md").split("\n## ")[0]
        for name in sorted(os.listdir(os.path.join(ROOT, "scripts"))):
            if os.access(os.path.join(ROOT, "scripts", name), os.X_OK) and os.path.isfile(os.path.join(ROOT, "scripts", name)):
                self.assertRegex(listed, rf"`{re.escape(name)}\b", name)


if __name__ == "__main__":
    unittest.main()
