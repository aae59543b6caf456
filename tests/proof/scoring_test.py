"""The score of handmade reports, the same by the scorer of the open recordings where that is at hand, and the pre-made set of cases."""
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

from proof import found_numbers, page, scoring, seal, session

HERE = os.path.dirname(os.path.abspath(__file__))
SCORER = os.path.join(HERE, "..", "..", "..", "shared", "checks", "score_diagnosis.py")


def answers(name, kinds, **more):
    physics = [k for k in kinds if k != "parameters"]
    return {"name": name, "seed": 1, "stratum": "single", "shape": "dome", "kinds": kinds, "outside": [], "numbers": {k: {} for k in physics},
            "true": {}, "place": None, "visible": {}, "has_force": True, "held_out": {}, **more}


def finding(kind, probability, center=None, **parameters):
    return {"kind": kind, "probability": probability, "where": center and {"center": center, "radius": 10.0},
            "parameters": {k: {"value": v, "unit": "1"} for k, v in parameters.items()}}


def report(verdict, findings, alternatives=()):
    return {"verdict": verdict, "findings": findings, "alternatives": list(alternatives), "seconds": 12.0, "fit": {}}


LUMP = {"kind": "inclusion", "center": [10.0, 0.0, 30.0], "radius": 12.0}
CASES = [  # (answers, report, named exactly)
    (answers("null", []), report("no-mismatch", []), True),
    (answers("null-alarm", []), report("missing-physics", [finding("skin", 0.7)]), False),
    (answers("null-doubt", []), report("no-mismatch", [finding("skin", 0.3)]), True),
    (answers("numbers", ["parameters"]), report("parameters", [finding("parameters", 0.99)]), True),
    (answers("numbers-missed", ["parameters"]), report("no-mismatch", []), False),
    (answers("skin", ["skin", "parameters"]), report("missing-physics", [finding("skin", 0.9), finding("parameters", 0.9)]), True),
    (answers("pair", ["gravity", "inclusion"], place=LUMP), report("missing-physics", [finding("gravity", 0.9), finding("inclusion", 0.8, [12.0, 3.0, 36.0])]), True),
    (answers("half", ["gravity", "inclusion"], place=LUMP), report("missing-physics", [finding("gravity", 0.9)]), False),
    (answers("more", ["gravity"]), report("missing-physics", [finding("gravity", 0.9), finding("skin", 0.6)]), False),
    (answers("late", ["latency"]), report("measurement", [finding("latency", 1.0)]), True),
    (answers("strange", ["unknown"], outside=["pulling-cable"], place={**LUMP, "kind": "unknown"}),
     report("unexplained", [finding("unknown", 0.8, [10.0, 0.0, 39.0])]), True),
    (answers("strange-named", ["unknown"], outside=["permanent-set"]), report("missing-physics", [finding("softening", 0.8)]), False),
]


class Folder(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)

    def put(self, *path, text):
        path = os.path.join(self.scratch.name, *path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w") as out:
            out.write(text)
        return os.path.dirname(path)

    def rows(self):
        return [scoring.score_case(truth, self.put(truth["name"], "report.json", text=json.dumps(said))) for truth, said, _ in CASES]


class Named(Folder):
    def test_exactly_or_not(self):
        for row, (truth, _, right) in zip(self.rows(), CASES):
            self.assertEqual(row["right"], right, truth["name"])

    def test_no_report_is_wrong(self):
        row = scoring.score_case(answers("gone", []), self.scratch.name)
        self.assertFalse(row["right"])
        self.assertEqual(scoring.confusion([row]), {"none": {"failed": 1}})

    def test_the_figures_are_those_that_are_counted_by_hand(self):
        figures = scoring.figures(self.rows())
        counted = {"named exactly": (7, 12), "false alarms": (1, 5), "confident wrong names outside the library": (1, 2),
                   "places within 8 mm": (1, 3), "places within 8 mm, kinds of the library": (1, 2)}
        for name, pair in counted.items():
            self.assertEqual((figures[name]["hits"], figures[name]["count"]), pair, name)
        # (0.7)^2 (0.3)^2 | skin .9 | gravity .9, inclusion .8 | gravity .9 | gravity .9, skin .6 wrong | latency 1 | unknown .8 | softening .8 wrong
        squares = [0.49, 0.09, 0.01, 0.01, 0.04, 0.01, 0.01, 0.36, 0.0, 0.04, 0.64]
        self.assertAlmostEqual(figures["Brier score"]["value"], sum(squares) / len(squares))

    def test_a_pair_half_named_is_confused_with_nothing(self):
        table = scoring.confusion(self.rows())
        self.assertEqual(table["inclusion"], {"inclusion": 1, "none": 1})
        self.assertEqual(table["unknown"], {"unknown": 1, "softening": 1})
        self.assertEqual(table["none"], {"none": 2, "skin": 1})
        self.assertEqual(table["parameters"], {"parameters": 1, "no-mismatch": 1})

    @unittest.skipUnless(os.path.exists(SCORER), "../shared/checks is not here")
    def test_the_scorer_of_the_open_recordings_agrees(self):
        rows = self.rows()
        for truth, _, _ in CASES:
            place = truth["place"]
            physics = {} if place is None else {"inclusion": [{"center": place["center"], "radius": place["radius"]}]}
            self.put("truth", truth["name"], "truth.json", text=json.dumps({"kinds": truth["kinds"], "physics": physics, "held_out": []}))
        said = subprocess.run([sys.executable, SCORER, os.path.join(self.scratch.name, "truth"), self.scratch.name], check=True, capture_output=True,
                              text=True).stdout
        verdicts = dict(re.findall(r"^(\S+)\s+(right|WRONG)\s", said, re.MULTILINE))
        self.assertEqual(verdicts, {row["name"]: "right" if row["right"] else "WRONG" for row in rows})
        brier = scoring.figures(rows)["Brier score"]["value"]
        self.assertIn(f"Brier {brier:.3f}", said)


class HeldOut(Folder):
    def test_targets_count_where_they_are_and_markers_as_they_move(self):
        true = {"M01": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], "T1": [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0]]}
        # All of it 0.5 mm off; the explained model moves half as far as it should in the second frame.
        off = {"M01": [(0.5, 0.0, 0.0), (1.5, 0.0, 0.0)], "T1": [(5.5, 0.0, 0.0), (6.5, 0.0, 0.0)]}
        half = {"M01": [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)], "T1": [(5.0, 0.0, 0.0), (5.5, 0.0, 0.0)]}
        self.put("case", "held.assumed.csv", text=session.nexus_csv(50, "p", 2, None, off))
        folder = self.put("case", "held.csv", text=session.nexus_csv(50, "p", 2, None, half))
        found = scoring.held_out_errors(answers("case", [], held_out={"held": true}), folder)
        self.assertAlmostEqual(found["marker"][0], 0.0)
        self.assertAlmostEqual(found["marker"][1], 0.5 / math.sqrt(6.0))
        self.assertAlmostEqual(found["target"][0], 0.5 / math.sqrt(3.0))
        self.assertAlmostEqual(found["target"][1], 0.5 / math.sqrt(6.0))

    def test_a_prediction_that_is_missing_is_no_gain(self):
        self.assertIsNone(scoring.held_out_errors(answers("case", [], held_out={"held": {}}), self.scratch.name))


class Numbers(unittest.TestCase):
    def test_axes_have_no_sign(self):
        found = found_numbers.compare("anisotropy", finding("anisotropy", 1.0, k=3.3, axis=[0.0, 0.0, -2.0]), {"k": 3.0, "axis": [0.0, 0.6, 0.8]})
        self.assertAlmostEqual(found[0]["error"], 0.1)
        self.assertAlmostEqual(found[1]["error"], math.degrees(math.acos(0.8)))

    def test_a_gradient_may_be_said_from_its_other_end(self):
        true = {"k": 0.02, "axis": [0.0, 1.0, 0.0]}
        self.assertAlmostEqual(found_numbers.compare("stiffness-gradient", finding("stiffness-gradient", 1.0, k=-0.02, axis=[0.0, -1.0, 0.0]), true)[0]["error"], 0.0)
        self.assertAlmostEqual(found_numbers.compare("stiffness-gradient", finding("stiffness-gradient", 1.0, k=0.02, axis=[0.0, -1.0, 0.0]), true)[0]["error"], 2.0)

    def test_slipped_markers_are_a_set(self):
        true = {"markers": {"M03": {}, "M07": {}}}
        self.assertEqual(found_numbers.compare("marker-slip", finding("marker-slip", 1.0, markers=["M07", "M03"]), true)[0]["error"], 0.0)
        self.assertEqual(found_numbers.compare("marker-slip", finding("marker-slip", 1.0, markers=["M07", "M04"]), true)[0]["error"], 1.0)


def result_of(rows, wanted):
    return {"rows": rows, "summary": scoring.summary(rows), "seeds": [1, wanted], "wanted": wanted, "seal": "0" * 64}


class Page(Folder):
    def check(self, words):
        """Well formed, and loads nothing."""
        xml.etree.ElementTree.fromstring(words.replace("<!DOCTYPE html>", "").replace('<meta charset="utf-8">', ""))
        for forbidden in ("<script", "src=", "href=", "url(", "@import"):
            self.assertNotIn(forbidden, words)
        self.assertNotIn("nan", re.sub(r"[a-z]*nan[a-z]+", "", words))

    def test_it_says_every_case_and_loads_nothing(self):
        words = page.html(result_of(self.rows(), 14), "diagnoses as <nobody>")
        self.check(words)
        for truth, _, _ in CASES:
            self.assertIn(truth["name"][:8], words)
        self.assertIn("2 more are not diagnosed yet", words)
        self.assertIn("&lt;nobody&gt;", words)

    def test_one_case_without_report_is_a_page_too(self):
        self.check(page.html(result_of([scoring.score_case(answers("gone", []), self.scratch.name)], 1), ""))


class PreMade(unittest.TestCase):
    """Two cases as scripts/prove left them (frames thinned): sealed answers, reports, predictions."""

    def setUp(self):
        self.folders = seal.Folders.at(os.path.join(HERE, "premade"))
        self.names = sorted(os.listdir(self.folders.results))
        self.rows = [scoring.score_case(seal.opened(self.folders, name), self.folders.result(name)) for name in self.names]

    def test_their_score_is_what_it_was(self):
        with open(os.path.join(HERE, "premade", "expected.json")) as source:
            expected = json.load(source)
        self.assertEqual(len(self.rows), len(expected))
        for row in self.rows:
            wanted = expected[row["name"]]
            for key in ("kinds", "claimed", "verdict", "right"):
                self.assertEqual(row[key], wanted[key], row["name"])
            for what in ("marker", "target"):
                for found, value in zip(row["errors"][what], wanted["errors"][what]):
                    self.assertAlmostEqual(found, value, places=4)

    def test_their_page_can_be_written(self):
        self.assertIn("Blind proof", page.html(result_of(self.rows, len(self.rows)), ""))


if __name__ == "__main__":
    unittest.main()
