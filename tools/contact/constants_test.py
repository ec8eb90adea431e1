#!/usr/bin/env python3
"""Tests of the inventory of constants on a small tree: a correct one passes, and each mistake is named."""
import pathlib
import tempfile
import unittest

import constants

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


if __name__ == "__main__":
    unittest.main()
