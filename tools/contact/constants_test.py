#!/usr/bin/env python3
"""Tests of the inventory of constants on a small tree: a correct one passes, and each mistake is named."""
import pathlib
import tempfile
import unittest

import constants
import constants_sensitivity

CODE = """// constexpr int kInAComment = 1;
namespace vps {
constexpr double kShare = 0.5;  // of a voxel
void Walk() {
  constexpr float kSmaller = 0.25f,
                  kLarger = 1.5f;
  const std::uint32_t kTable[2] = {1, 2};
  const float step = 0.5f;
  const double area = 4.0 * radius;
  enum { kNames = 3 };
}
}  // namespace vps
"""
ROWS = """file,name,value,kind,why
libs/vps/walk/walk.cpp,kShare,0.5,tuned,measured
libs/vps/walk/walk.cpp,kSmaller,0.25f,free,time
libs/vps/walk/walk.cpp,kLarger,1.5f,free,time
libs/vps/walk/walk.cpp,kTable,"{1, 2}",unit or format,bits
libs/vps/walk/walk.cpp,4.0 * radius,4.0,tuned,reach
"""
WALK = "libs/vps/walk/walk.cpp"


class Constants(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write(WALK, CODE)
        self.write(constants.CSV, ROWS)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def found(self):
        return list(constants.findings(self.root))

    def test_an_inventory_that_is_complete_passes(self):
        self.assertEqual(self.found(), [])

    def test_a_constant_that_is_new_is_named_with_its_line(self):
        self.write(WALK, CODE.replace("void Walk", "static constexpr int kPasses = 24;\nvoid Walk"))
        self.assertEqual(len(self.found()), 1)
        self.assertTrue(self.found()[0].startswith(f"{WALK}:4: kPasses is not in {constants.CSV}; add a row with its value, 24"))

    def test_a_constant_that_is_gone_is_named(self):
        self.write(WALK, CODE.replace("constexpr double kShare = 0.5;", ""))
        self.assertEqual(self.found(), [f"{constants.CSV}:2: kShare: {WALK} has it no more; remove the row"])

    def test_a_value_that_was_changed_is_named(self):
        self.write(WALK, CODE.replace("kLarger = 1.5f", "kLarger = 2.0f"))
        self.assertEqual(len(self.found()), 1)
        self.assertIn(f"{WALK}:6: kLarger is 2.0f, {constants.CSV}:4 says 1.5f", self.found()[0])

    def test_an_expression_that_was_changed_is_named(self):
        self.write(WALK, CODE.replace("4.0 * radius", "3.0 * radius"))
        self.assertEqual(len(self.found()), 1)
        self.assertIn("no such expression", self.found()[0])

    def test_a_kind_that_is_none_and_a_missing_reason_are_named(self):
        self.write(constants.CSV, ROWS.replace("tuned,measured", "lucky,"))
        self.assertEqual(len(self.found()), 2)

    def test_a_name_that_a_file_has_twice_has_two_rows(self):
        self.write(WALK, CODE + "constexpr double kShare = 0.7;\n")
        self.assertEqual(len(self.found()), 1)
        self.write(constants.CSV, ROWS + f"{WALK},kShare,0.7,free,time\n")
        self.assertEqual(self.found(), [])

    def test_tests_and_benches_have_constants_of_their_own(self):
        self.write("libs/vps/walk/walk_test.cpp", "constexpr int kTrials = 10;\n")
        self.assertEqual(self.found(), [])

    def test_a_page_that_is_older_than_the_inventory_is_named(self):
        self.write(constants.PAGE, constants.page(self.root))
        self.assertEqual(list(constants.check(self.root)), [])
        self.write(constants.CSV, ROWS.replace("measured", "derived later"))
        self.assertEqual(len(list(constants.check(self.root))), 1)


def measured(factor, failed="", **figures):
    """Rows of constants_sensitivity.csv about kShare; figures of cold queries that are not 1."""
    row = {"file": WALK, "name": "kShare", "value": "0.5", "factor": factor, "differs": "0", "tests": "3", "failed": failed}
    row |= dict.fromkeys(constants.FIGURES, "1") | figures | ({"differs": "1"} if figures else {})
    return [row | {"queries": "cold"}]


class Kinds(unittest.TestCase):
    def why(self, kind, *measurements):
        found = {rows[0]["factor"]: rows for rows in measurements}
        row = {"file": WALK, "name": "kShare", "value": "0.5", "kind": kind}
        return constants.unproven(row, found, constants.scatter_of({(WALK, "kShare"): found}))

    def test_only_what_was_measured_is_indifferent(self):
        self.assertIn("not measured", self.why("indifferent"))
        self.assertIn("not measured", self.why("indifferent", measured("2")))
        self.assertIsNone(self.why("tuned"))
        self.assertIsNone(self.why("indifferent", measured("0.5", p99="1.01"), measured("2")))

    def test_one_that_changes_a_figure_is_tuned(self):
        self.assertIn("call it tuned", self.why("indifferent", measured("0.5"), measured("2", p99="1.1")))
        self.assertIn("call it tuned", self.why("indifferent", measured("0.5", places="0.9"), measured("2")))

    def test_a_change_counts_where_it_is_larger_than_scatter(self):
        rows = measured("0.5"), measured("2", p99="1.1")
        self.assertIsNone(self.why("indifferent", *rows, measured("1.01", p99="1.12")))
        self.assertIn("call it tuned", self.why("indifferent", *rows, measured("1.01", worst="1.12")))

    def test_one_without_which_a_test_fails_is_tuned(self):
        self.assertIn("call it tuned", self.why("limit", measured("0.5"), measured("2", failed="Walk.IsRight")))

    def test_a_limit_may_matter_where_it_is_halved(self):
        self.assertIsNone(self.why("limit", measured("0.5", places="0.5"), measured("2")))

    def test_one_that_was_measured_with_another_value_has_to_be_measured(self):
        other = [row | {"value": "0.4"} for row in measured("2")]
        self.assertIn("not measured at 0.5", self.why("limit", measured("0.5"), other))


class Copy(unittest.TestCase):
    def converted(self, code, **row):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in ((WALK, code), (constants_sensitivity.HEADER, ""), (constants_sensitivity.PATCHES, "kMaxPatches = 512")):
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text, encoding="utf-8")
            rows = [{"file": WALK, "name": "kShare", "value": "0.5", "why": "of a voxel"} | row]
            return constants_sensitivity.Variable(root, rows)

    def test_reads_a_constant_when_the_program_starts_and_what_follows_from_it(self):
        text = self.converted("constexpr double kShare = 0.5;\nconstexpr double kTwice = 2.0 * kShare;\n").texts[WALK]
        self.assertIn(f'const double kShare = vps::Studied<double>(0.5, "{WALK}:kShare");', text)
        self.assertIn("\nconst double kTwice = 2.0 * kShare;", text)

    def test_scales_the_angle_of_a_cosine(self):
        self.assertIn("StudiedCosine<double>(0.5", self.converted("constexpr double kShare = 0.5;\n", why="cosine").texts[WALK])

    def test_leaves_a_size_that_the_compiler_has_to_know(self):
        variable = self.converted("constexpr int kShare = 4;\nint table[kShare];\n", value="4")
        self.assertEqual([row["name"] for row in variable.fixed], ["kShare"])
        self.assertIn("constexpr int kShare = 4;", variable.texts[WALK])


if __name__ == "__main__":
    unittest.main()
