"""What `./kinegraph evidence --check` finds, in a project of three files."""
import importlib.util
import json
import pathlib
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2] / "workflow/evidence.py"
TABLE = """page = "docs/page.md"
[step.fall]
run = ["true"]
figures.share = "x"
[block]
drop = '''
{fall[share]:.1f}
'''
"""
SHARE = {"percent": 97.26, "count": 107, "total": 110,
         "interval": {"low": 95.0, "high": 99.04}}


class EvidenceTest(unittest.TestCase):
    def setUp(self):
        spec = importlib.util.spec_from_file_location("evidence", SOURCE)
        self.evidence = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(self.evidence)
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        root = pathlib.Path(self.folder.name)
        self.evidence.ROOT, self.evidence.KEPT = root, root / "docs/evidence"
        (root / "docs/evidence").mkdir(parents=True)
        (root / "workflow/evidence").mkdir(parents=True)
        self.write("README.md", "A project.\n")
        self.write("workflow/evidence/page.toml", TABLE)
        self.keep(SHARE)
        self.page("97.3 [95.0, 99.0] (107/110)")
        self.write("docs/evidence/README.md", self.wanted()[
            self.evidence.KEPT / "README.md"])

    def write(self, name, text):
        (self.evidence.ROOT / name).write_text(text)

    def keep(self, share, run="true"):
        self.write("docs/evidence/fall.json", json.dumps({
            "commit": "abc", "machine": "one", "seconds": 1.0, "run": [run],
            "figures": {"share": share}}))

    def page(self, figure):
        self.write("docs/page.md", "Before.\n<!-- evidence:drop -->\n" + figure +
                   "\n<!-- /evidence -->\nAfter.\n")

    def wanted(self):
        steps, blocks, tables = self.evidence.load()
        texts, _ = self.evidence.rendered(steps, blocks, tables)
        return self.evidence.pages(steps, texts)[0]

    def wrong(self):
        steps, blocks, tables = self.evidence.load()
        texts, wrong = self.evidence.rendered(steps, blocks, tables)
        wanted, more = self.evidence.pages(steps, texts)
        return wrong + more + self.evidence.check(wanted)

    def test_what_was_made_is_right(self):
        self.assertEqual(self.wrong(), [])

    def test_a_typed_figure_is_found(self):
        self.page("97.4 [95.0, 99.0] (107/110)")
        self.assertIn("docs/page.md says\n  97.4", self.wrong()[0])

    def test_newer_evidence_is_found(self):
        self.keep({**SHARE, "percent": 97.7})
        self.assertIn("evidence says\n  97.7", self.wrong()[0])

    def test_other_commands_are_found(self):
        self.keep(SHARE, run="false")
        self.assertIn("its commands have changed", self.wrong()[0])

    def test_missing_evidence_and_lost_markers_are_found(self):
        (self.evidence.KEPT / "fall.json").unlink()
        self.assertIn("step 'fall' has not been run", self.wrong())
        self.keep(SHARE)
        self.write("docs/page.md", "97.3\n")
        self.assertIn("block 'drop' stands on no page", self.wrong())

    def table(self, rows):
        self.write("workflow/evidence/page.toml", TABLE.replace(
            "{fall[share]:.1f}", "{table[falls]}") + f"""
[table.falls]
rows = "{rows}"
columns = [["who", "{{name}}"], ["share", "{{share:.0f}}"]]
""")

    def test_tables_are_made_of_rows(self):
        self.table("[{'name': n, 'share': fall['share']} for n in 'ab']")
        self.page("| who | share |\n|---|---|\n| a | 97 [95, 99] (107/110) |\n"
                  "| b | 97 [95, 99] (107/110) |")
        self.assertEqual(self.wrong(), [])

    def test_a_last_row_sums(self):
        self.table("with_sum([{'name': n, 'share': 2} for n in 'ab'], ['share'], "
                   "name='all')")
        self.page("| who | share |\n|---|---|\n| a | 2 |\n| b | 2 |\n| all | 4 |")
        self.assertEqual(self.wrong(), [])

    def test_a_table_that_cannot_be_made_is_said(self):
        self.table("[{'name': 'a'}]")
        self.assertIn("table 'falls': KeyError 'share'", self.wrong())

    def test_limits_of_shares(self):
        # Of none in n: 1 - 0.05^(1/n); of all: nothing is ruled out.
        self.assertAlmostEqual(self.evidence.at_most(0, 16),
                               100.0 * (1.0 - 0.05 ** (1.0 / 16.0)), places=9)
        self.assertAlmostEqual(self.evidence.at_most(0, 400),
                               100.0 * (1.0 - 0.05 ** (1.0 / 400.0)), places=9)
        # Of n - 1 in n: what makes all n as likely as 95 in 100.
        self.assertAlmostEqual(self.evidence.at_most(4, 5),
                               100.0 * 0.95 ** 0.2, places=9)
        self.assertEqual(self.evidence.at_most(3, 3), 100.0)

    def test_figures_are_read_again_from_the_last_run(self):
        steps, _, _ = self.evidence.load()
        steps["fall"].update(read={"x": "x.json", "log": "log.txt",
                                   "lines": "lines.jsonl"})
        steps["fall"]["figures"]["words"] = "log.split()"
        steps["fall"]["figures"]["sum"] = "sum(x['n'] for x in lines)"
        build = self.evidence.ROOT / "build"
        self.assertRaises(self.evidence.Failure, self.evidence.keep, "fall",
                          steps["fall"], build)
        folder = build / "evidence/fall"
        folder.mkdir(parents=True)
        for name, text in (("x.json", "3.5"), ("log.txt", "two words"),
                           ("lines.jsonl", '{"n": 3}\n{"n": 4}\n'),
                           ("made.json", '{"commit": "abc", "run": ["true"]}')):
            (folder / name).write_text(text)
        self.evidence.keep("fall", steps["fall"], build)
        kept = json.loads((self.evidence.KEPT / "fall.json").read_text())
        self.assertEqual(kept["figures"],
                         {"share": 3.5, "words": ["two", "words"], "sum": 7})


if __name__ == "__main__":
    unittest.main()
