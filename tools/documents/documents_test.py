#!/usr/bin/env python3
"""Tests of the checks on small trees: a correct tree passes, and each mistake is named."""
import pathlib
import subprocess
import tempfile
import unittest

import check
import figures


class Tree(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        subprocess.run(["git", "init", "-q", self.root], check=True)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


class Figures(Tree):
    def setUp(self):
        super().setUp()
        self.write("docs/performance/bus/hop.csv", 'transport,p50_us,words\nLATEST,18.431,"17 x, 17.2 x"\nUDP,12.031,\n')
        self.write("docs/performance/runs.csv", "folder,command,date,commit,machine\nbus,oos bench bus,,,\n")
        self.figures("hop_us,18.4,us,bus/hop.csv|transport=LATEST|p50_us,,\n")
        self.write("libs/bus/README.md", "A hop takes <!--figure:hop_us-->18.4<!--/figure--> µs.\n")

    def figures(self, rows):
        self.write("docs/performance/figures.csv", "id,value,unit,source,digits,scale\n" + rows)

    def test_fresh_figures_pass(self):
        self.assertEqual(figures.update(self.root, True), [])

    def test_a_figure_measured_anew_is_stale_until_it_is_filled_in(self):
        self.write("docs/performance/bus/hop.csv", "transport,p50_us\nLATEST,20.9\n")
        self.assertTrue(figures.update(self.root, True))
        figures.update(self.root, False)
        self.assertEqual(figures.update(self.root, True), [])
        self.assertIn(">20.9<", (self.root / "libs/bus/README.md").read_text())

    def test_a_figure_changed_by_hand_is_stale(self):
        self.write("libs/bus/README.md", "A hop takes <!--figure:hop_us-->12<!--/figure--> µs.\n")
        self.assertTrue(figures.update(self.root, True))

    def test_a_figure_without_a_source_is_named(self):
        self.write("libs/bus/README.md", "A hop takes <!--figure:hop_us-->18.4<!--/figure--> µs, <!--figure:x-->1<!--/figure-->.\n")
        self.assertIn("no figure 'x'", figures.update(self.root, True)[0])

    def test_a_figure_that_nobody_quotes_is_named(self):
        self.write("libs/bus/README.md", "Fast.\n")
        self.assertIn("no document quotes hop_us", figures.update(self.root, True)[0])

    def test_a_measured_figure_without_a_mark_is_named(self):
        self.write("libs/bus/README.md", "<!--figure:hop_us-->18.4<!--/figure--> µs, or 12 us.\n")
        self.assertIn("or 12 us", figures.update(self.root, True)[0])

    def test_a_measured_figure_without_a_mark_is_named_in_the_results_too(self):
        self.write("docs/performance/bus.md", "It takes 12 µs.\n")
        self.assertIn("It takes 12 µs.", figures.update(self.root, True)[0])

    def test_what_is_not_measured_needs_no_mark(self):
        self.write("docs/decisions/D07-bus.md", "Then it took 12 µs.\n")
        self.write("docs/performance/bus.md", "A tick of 1 ms.\n")
        self.assertEqual(figures.update(self.root, True), [])

    def test_numbers_inside_text_are_cells_too(self):
        self.assertEqual(figures.cell(self.root, "bus/hop.csv|transport=LATEST|words#2"), "17.2")

    def test_tables_are_those_of_their_files(self):
        self.write("docs/bus.md", "<!--table:bus/hop.csv-->\n<!--/table-->\n")
        self.assertTrue(figures.update(self.root, True))
        figures.update(self.root, False)
        self.assertIn("| UDP | 12 |", (self.root / "docs/bus.md").read_text())

    def test_a_run_of_one_table_is_noted_once_and_goes_with_a_run_of_its_folder(self):
        self.write("docs/performance/runs.csv", "folder,command,date,commit,machine\nbus,oos bench bus,,,\nbusy,other,,,\n")
        subprocess.run(["git", "-C", self.root, "-c", "user.name=a", "-c", "user.email=a", "commit", "-q", "--allow-empty",
                        "-m", "a"], check=True)

        def noted(folder):
            figures.note_run(self.root, folder, "command")
            return [row["folder"] for row in figures.read_rows(self.root / "docs/performance/runs.csv")]

        self.assertEqual(noted("bus/hop"), ["bus", "bus/hop", "busy"])
        self.assertEqual(noted("bus/hop"), ["bus", "bus/hop", "busy"])
        self.assertEqual(noted("bus"), ["bus", "busy"])

    def test_numbers_are_rounded_and_scaled(self):
        self.assertEqual(figures.written("0.00431", "2", "1000"), "4.3")
        self.assertEqual(figures.written("44302", "5", ""), "44,302")
        self.assertEqual(figures.written("2.22e-16", "", ""), "2.22e-16")
        self.assertEqual(figures.written("yes", "", ""), "yes")


class Check(Tree):
    def setUp(self):
        super().setUp()
        self.write("libs/vps/CMakeLists.txt", "add_room(vps)\n")
        self.write("libs/vps/README.md", "[walk](walk.cpp): `QueryTree`, `Walk.Finds*`\n")
        self.write("libs/vps/walk.cpp", "// D5\nint QueryTree();\nTEST(Walk, FindsEveryPoint) {}\n")
        self.write("docs/decisions/D05-planes.md", "# D5. Planes\n")

    def found(self):
        return list(check.findings(self.root))

    def test_a_sound_tree_passes(self):
        self.assertEqual(self.found(), [])

    def test_a_broken_link_is_named(self):
        self.write("docs/a.md", "[b](b.md), [c](https://example.org), [d](#here)\n")
        self.assertEqual(self.found(), ["docs/a.md: link to a missing file, b.md"])

    def test_a_test_that_was_renamed_is_named(self):
        self.write("docs/a.md", "`Walk.Loses*`, `Walk.FindsEveryPoint`\n")
        self.assertEqual(self.found(), ["docs/a.md: no test is called Walk.Loses*"])

    def test_code_that_was_renamed_is_named(self):
        self.write("libs/vps/LEDGER.md", "| Eq. 1 | `QueryTree`, `QueryShrub` |\n")
        self.assertEqual(self.found(), ["libs/vps/LEDGER.md: no code is called QueryShrub"])

    def test_a_decision_that_is_cited_and_not_written_is_named(self):
        self.write("libs/vps/walk.cpp", "// D5, decision 6\nint QueryTree();\nTEST(Walk, FindsEveryPoint) {}\n")
        self.assertEqual(self.found(), ["libs/vps/walk.cpp: decision 0006 is not in docs/decisions"])

    def test_a_room_without_readme_is_named(self):
        self.write("libs/bus/CMakeLists.txt", "add_room(bus)\n")
        self.assertEqual(self.found(), ["libs/bus: a room without README.md"])

    def test_a_folder_of_four_sources_that_no_readme_explains_is_named(self):
        for name in "abcd":
            self.write(f"libs/vps/tree/{name}.cpp", "")
        self.assertEqual(self.found(), ["libs/vps/tree: 4 source files, and no README.md says what for"])
        self.write("libs/vps/README.md", "| `tree/` | the tree |\n")
        self.assertEqual(self.found(), [])
        self.write("libs/vps/README.md", "another_tree/ is none.\n")
        self.assertEqual(len(self.found()), 1)
        self.write("libs/vps/tree/README.md", "# tree\n")
        self.assertEqual(self.found(), [])


if __name__ == "__main__":
    unittest.main()
