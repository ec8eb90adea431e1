#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/pose.hpp"
#include "tools/oos/meshes/verbs.hpp"
#include "vps/oracle/closed_form.hpp"
#include "vps/testing/shapes.hpp"

namespace oos {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Row {
  double distance_m = 0.0;
  glm::dvec3 force{0.0};
  glm::dvec3 moment{0.0};
  double contacts = 0.0;
  double points = 0.0;
  double time_us = 0.0;
  double force_error = -1.0;  // -1: empty
};

class QueryVerbTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / "oos_query";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }

  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  std::string WriteMesh(const std::string& name, const vps::TriangleMesh& mesh) const {
    std::ostringstream text;
    text.precision(17);
    for (const auto& v : mesh.vertices) text << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (const auto& t : mesh.triangles) text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    return Write(name, text.str());
  }

  std::string out() const { return (folder_ / "out.csv").string(); }

  std::vector<Row> ReadOut() const {
    std::ifstream stream(out());
    std::string line;
    std::getline(stream, line);
    EXPECT_EQ(line, "signed_distance_m,fx,fy,fz,mx,my,mz,contacts,points_tested,time_us,force_error");
    std::vector<Row> rows;
    while (std::getline(stream, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream fields(line);
      Row r;
      fields >> r.distance_m >> r.force.x >> r.force.y >> r.force.z >> r.moment.x >> r.moment.y >> r.moment.z >>
          r.contacts >> r.points >> r.time_us;
      EXPECT_TRUE(fields) << line;
      if (double error = 0.0; fields >> error) r.force_error = error;
      rows.push_back(r);
    }
    return rows;
  }

  // Runs a query that must fail; returns its stderr. No result file may exist afterwards.
  std::string ComplaintOf(const std::vector<std::string>& words) const {
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, words), kBadUsage);
    EXPECT_FALSE(fs::exists(out()));
    for (const auto& entry : fs::directory_iterator(folder_)) {
      EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr("partial")));
    }
    std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    return text;
  }

  fs::path folder_;
};

TEST_F(QueryVerbTest, OracleGivesTheClosedFormsOfABoxOnABox) {
  const std::string ground = WriteMesh("ground.obj", vps::MakeBox({0.4, 0.4, 0.2}));
  const std::string box = WriteMesh("box.obj", vps::MakeBox({0.06, 0.04, 0.02}));
  const std::string poses = Write("poses.csv",
                                  "px,py,pz,qw,qx,qy,qz\n0,0,0.112,1,0,0,0\n0.05,0.02,0.107,1,0,0,0\n"
                                  "0,0,0.107,0.70710678118654757,0,0,0.70710678118654757\n");
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", ground, box, "--poses", poses, "--out", out(), "--method", "oracle"}),
            kHolds);
  const auto rows = ReadOut();
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_NEAR(rows[0].distance_m, 0.002, 1e-8);
  EXPECT_EQ(rows[0].force, glm::dvec3(0.0));
  const double force = vps::oracle::PlateOnHalfSpaceForce(0.06 * 0.04, 0.003);
  for (int i = 1; i < 3; ++i) {
    EXPECT_NEAR(rows[i].distance_m, -0.003, 3e-6);
    EXPECT_LT(glm::distance(rows[i].force, {0.0, 0.0, force}), 1e-3 * force);
    EXPECT_LT(glm::length(rows[i].moment), 1e-3 * force * 0.05);
    EXPECT_GT(rows[i].contacts, 0.0);
    EXPECT_GT(rows[i].time_us, 0.0);
  }
}

TEST_F(QueryVerbTest, OracleGivesTheCapOfASphereInMillimetres) {
  const std::string ground = WriteMesh("ground.obj", vps::MakeBox({200, 200, 100}));
  const std::string ball = WriteMesh("ball.obj", vps::MakeSphere(30.0, 128));
  const std::string poses = Write("poses.csv", "0,0,0.076,1,0,0,0\n");
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", ground, ball, "--poses", poses, "--out", out(), "--method=oracle", "--scale", "0.001"}),
            kHolds);
  const auto rows = ReadOut();
  ASSERT_EQ(rows.size(), 1U);
  const double force = vps::oracle::SphereOnHalfSpaceForce(0.03, 0.004);
  EXPECT_NEAR(rows[0].distance_m, -0.004, 4e-6);
  EXPECT_NEAR(rows[0].force.z, force, 0.01 * force);
}

// Eq. 1-2: all points of the face are V = depth deep, so lambda sum V n is the depth, in metres, along the normal.
TEST_F(QueryVerbTest, PaperReportsItsOwnSums) {
  const std::string ground = WriteMesh("ground.obj", vps::MakeBox({0.1, 0.1, 0.1}));
  const std::string box = WriteMesh("box.obj", vps::MakeBox({0.04, 0.04, 0.02}));
  const std::string poses = Write("poses.csv", "0,0,0.0595,1,0,0,0\n0,0,0.07,1,0,0,0\n");
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, {"query", ground, box, "--poses", poses, "--out", out(),
                                                                "--voxel_m", "0.001", "--points", "8000"}),
            kHolds);
  const auto rows = ReadOut();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_NEAR(rows[0].distance_m, -0.0005, 0.001);
  EXPECT_GT(rows[0].contacts, 2000.0);
  EXPECT_NEAR(rows[0].force.z, 0.0005, 0.0002);
  EXPECT_GT(rows[1].distance_m, 0.0);
  EXPECT_LE(rows[1].distance_m, 0.01);
  EXPECT_EQ(rows[1].contacts, 0.0);
}

TEST_F(QueryVerbTest, FastGivesTheIntegral) {
  const std::string ground = WriteMesh("ground.obj", vps::MakeBox({0.1, 0.1, 0.1}));
  const std::string box = WriteMesh("box.obj", vps::MakeBox({0.04, 0.04, 0.02}));
  const std::string poses = Write("poses.csv", "0.01,0,0.0595,1,0,0,0\n0,0,0.07,1,0,0,0\n");
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", ground, box, "--poses", poses, "--out", out(), "--method", "fast", "--voxel_m", "0.001",
                      "--points", "8000"}),
            kHolds);
  const auto rows = ReadOut();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_NEAR(rows[0].distance_m, -0.0005, 2e-5);
  const double force = vps::oracle::PlateOnHalfSpaceForce(0.04 * 0.04, 0.0005);
  EXPECT_LT(glm::distance(rows[0].force, {0.0, 0.0, force}), 0.02 * force);
  EXPECT_GT(rows[1].distance_m, 0.0);
  EXPECT_LE(rows[1].distance_m, 0.01);
}

// A ball in a half space, and apart from it.
TEST_F(QueryVerbTest, FastKeepsAnAccuracyAndGivesItsError) {
  const std::string ground = WriteMesh("ground.obj", vps::MakeBox({0.2, 0.2, 0.1}));
  const std::string ball = WriteMesh("ball.obj", vps::MakeSphere(0.03, 128));
  const std::string poses = Write("poses.csv", "0,0,0.076,1,0,0,0\n0,0,0.0801,1,0,0,0\n0,0,0.1,1,0,0,0\n");
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", ground, ball, "--poses", poses, "--out", out(), "--method", "fast", "--accuracy", "0.05",
                      "--voxel_m", "0.001"}),
            kHolds);
  const auto rows = ReadOut();
  ASSERT_EQ(rows.size(), 3U);
  const double force = vps::oracle::SphereOnHalfSpaceForce(0.03, 0.004);
  EXPECT_NEAR(rows[0].force.z, force, 0.05 * force);
  EXPECT_GT(rows[0].force_error, 0.0);
  EXPECT_LE(rows[0].force_error, 0.05 * rows[0].force.z);
  EXPECT_NEAR(rows[0].distance_m, -0.004, 1e-3);
  for (int i = 1; i < 3; ++i) {
    EXPECT_EQ(rows[i].contacts, 0.0);
    EXPECT_EQ(rows[i].force, glm::dvec3(0.0));
    EXPECT_GE(rows[i].distance_m, 0.0);
    EXPECT_LE(rows[i].distance_m, i == 1 ? 1e-4 + 1e-5 : 0.02 + 1e-5);
  }
  EXPECT_GT(rows[2].distance_m, 0.015);
  fs::remove(out());
  EXPECT_THAT(ComplaintOf({"query", ground, ball, "--poses", poses, "--out", out(), "--accuracy", "0.05"}),
              HasSubstr("--method fast"));
  EXPECT_THAT(
      ComplaintOf({"query", ground, ball, "--poses", poses, "--out", out(), "--method", "fast", "--accuracy", "5"}),
      HasSubstr("--accuracy must be below 1"));
}

// A ball on a sheet of 4 mm, from both sides: as on a half space, the volume of its cap over its own surface.
TEST_F(QueryVerbTest, AnOpenMeshIsASheetWithTwoSides) {
  vps::TriangleMesh plate{{{-0.05, -0.05, 0}, {0.05, -0.05, 0}, {0.05, 0.05, 0}, {-0.05, 0.05, 0}},
                          {{0, 1, 2}, {0, 2, 3}}};
  const std::string sheet = WriteMesh("sheet.obj", plate);
  const std::string ball = WriteMesh("ball.obj", vps::MakeSphere(0.02, 128));
  const std::string poses = Write("poses.csv", "0,0,0.021,1,0,0,0\n0,0,-0.021,1,0,0,0\n0,0,0.03,1,0,0,0\n");
  const double force = vps::oracle::SphereOnHalfSpaceForce(0.02, 0.001);
  for (const char* method : {"oracle", "fast"}) {
    ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                       {"query", sheet, ball, "--poses", poses, "--out", out(), "--method", method, "--voxel_m",
                        "0.001", "--points", "40000", "--sheet_thickness_m", "0.004", "--sampled", "B"}),
              kHolds);
    const auto rows = ReadOut();
    ASSERT_EQ(rows.size(), 3U);
    for (int side = 0; side < 2; ++side) {
      EXPECT_NEAR(rows[side].distance_m, -0.001, 5e-5) << method;
      const glm::dvec3 expected(0, 0, side == 0 ? force : -force);
      EXPECT_LT(glm::distance(rows[side].force, expected), 0.03 * force) << method << " " << rows[side].force.z / force;
    }
    EXPECT_GT(rows[2].distance_m, 0.0);
  }
}

// Force on B and its moment about B's origin, in A's frame; the opposite on A, about A's origin, in B's frame.
std::pair<glm::dvec3, glm::dvec3> OnTheOther(const Row& row, const core::Pose& X_AB) {
  const glm::dvec3 moment_about_A = row.moment + glm::cross(X_AB.translation, row.force);
  return {X_AB.inverse().rotate(-row.force), X_AB.inverse().rotate(-moment_about_A)};
}

// A needle of 1 mm whose end is pressed into a plate, askew.
class NeedleOnAPlate : public QueryVerbTest {
 protected:
  void SetUp() override {
    QueryVerbTest::SetUp();
    plate_ = WriteMesh("plate.obj", vps::MakeBox({0.02, 0.02, 0.01}));
    needle_ = WriteMesh("needle.obj", vps::MakeBox({0.001, 0.001, 0.03}));
    X_PN_.rotation = core::QuaternionFromRotationVector({0.3, -0.2, 0.5});
    X_PN_.translation = glm::dvec3(0.004, -0.007, 0.0048) - X_PN_.rotation * glm::dvec3(0.0, 0.0, -0.015);
  }

  // The first row; and what was printed.
  Row Query(const std::string& A, const std::string& B, const core::Pose& X_AB, std::vector<std::string> more) {
    std::ostringstream row;
    row.precision(17);
    const auto& p = X_AB.translation;
    const auto& q = X_AB.rotation;
    row << p.x << ',' << p.y << ',' << p.z << ',' << q.w << ',' << q.x << ',' << q.y << ',' << q.z << '\n';
    std::vector<std::string> words{"query", A, B, "--poses", Write("poses.csv", row.str()), "--out", out()};
    words.insert(words.end(), more.begin(), more.end());
    testing::internal::CaptureStdout();
    EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, words), kHolds);
    printed_ = testing::internal::GetCapturedStdout();
    const auto rows = ReadOut();
    return rows.empty() ? Row{} : rows.front();
  }

  std::string plate_, needle_, printed_;
  core::Pose X_PN_;
};

TEST_F(NeedleOnAPlate, GivesTheSameWrenchInEitherOrderAndAgreesWithTheOracle) {
  const Row exact = Query(plate_, needle_, X_PN_, {"--method", "oracle"});
  EXPECT_THAT(printed_, HasSubstr("B is sampled (smallest feature 1 mm, of A 10 mm)\n"));
  ASSERT_GT(exact.force.z, 0.0);
  for (const char* method : {"oracle", "fast"}) {
    const Row second = Query(plate_, needle_, X_PN_, {"--method", method});
    EXPECT_THAT(printed_, HasSubstr("B is sampled"));
    const Row first = Query(needle_, plate_, X_PN_.inverse(), {"--method", method});
    EXPECT_THAT(printed_, HasSubstr("A is sampled (smallest feature 1 mm, of B 10 mm)"));
    const auto [force, moment] = OnTheOther(second, X_PN_);
    const double size = glm::length(force);
    EXPECT_LT(glm::distance(first.force, force), 1e-9 * size) << method;
    EXPECT_LT(glm::distance(first.moment, moment), 1e-9 * size * 0.03) << method;
    EXPECT_LT(glm::distance(second.force, exact.force), 0.02 * size) << method;
    EXPECT_LT(glm::distance(second.moment, exact.moment), 0.02 * size * 0.03) << method;
    EXPECT_NEAR(first.distance_m, second.distance_m, 1e-12) << method;
  }
}

TEST_F(NeedleOnAPlate, GivesThePapersSumsInEitherOrder) {
  const Row second = Query(plate_, needle_, X_PN_, {"--method", "paper"});
  const Row first = Query(needle_, plate_, X_PN_.inverse(), {"--method", "paper"});
  ASSERT_GT(second.contacts, 0.0);
  const auto [force, moment] = OnTheOther(second, X_PN_);
  EXPECT_LT(glm::distance(first.force, force), 1e-9 * glm::length(force));
  EXPECT_LT(glm::distance(first.moment, moment), 1e-9 * glm::length(force) * 0.03);
}

TEST_F(NeedleOnAPlate, IsSampledOnTheSideThatIsAskedFor) {
  const Row exact = Query(plate_, needle_, X_PN_, {"--method", "oracle", "--sampled", "A"});
  EXPECT_THAT(printed_, HasSubstr("A is sampled (as asked for)\n"));
  const Row fast = Query(plate_, needle_, X_PN_, {"--method", "fast", "--sampled", "A"});
  EXPECT_THAT(printed_,
              HasSubstr("A is sampled (as asked for); voxels of B 0.117 mm (1/256 of its longest side, 30 mm)"));
  EXPECT_LT(glm::distance(fast.force, exact.force), 0.03 * glm::length(exact.force));
  EXPECT_LT(glm::distance(fast.moment, exact.moment), 0.03 * glm::length(exact.force) * 0.03);
}

TEST_F(QueryVerbTest, OfEqualBodiesTheSecondIsSampled) {
  const std::string box = WriteMesh("box.obj", vps::MakeBox({0.04, 0.04, 0.02}));
  const std::string poses = Write("poses.csv", "0,0,0.0195,1,0,0,0\n");
  testing::internal::CaptureStdout();
  ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", box, box, "--poses", poses, "--out", out(), "--voxel_m", "0.001", "--points", "4000"}),
            kHolds);
  EXPECT_THAT(
      testing::internal::GetCapturedStdout(),
      HasSubstr("B is sampled (smallest feature 20 mm, of A 20 mm); voxels of A 1 mm (as asked for); points on B "
                "4000 (as asked for)"));
}

// A peg of 10 mm in a hole with 0.1 mm on each side, pressed aside by a quarter of that: the voxels chosen for an
// accuracy keep it.
TEST_F(QueryVerbTest, AnAccuracyHoldsInAClearance) {
  const std::string hole = WriteMesh("hole.obj", vps::MakeBlockWithHole(0.04, 0.01, 0.0051, 64));
  const std::string peg = WriteMesh("peg.obj", vps::MakeCylinder(0.005, 0.02, 64));
  const std::string poses = Write("poses.csv", "0.000125,0,0.001,1,0,0,0\n");
  Row rows[2];
  for (int i = 0; i < 2; ++i) {
    testing::internal::CaptureStdout();
    std::vector<std::string> words{"query", hole, peg, "--poses", poses, "--out", out(), "--method"};
    if (i == 0) words.push_back("oracle");
    if (i == 1) words.insert(words.end(), {"fast", "--accuracy", "0.05"});
    ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()}, words), kHolds);
    const std::string printed = testing::internal::GetCapturedStdout();
    EXPECT_EQ(i == 1, printed.find("the accuracy in a clearance of 0.0999 mm") != std::string::npos) << printed;
    rows[i] = ReadOut().front();
  }
  ASSERT_LT(rows[0].force.x, 0.0);
  EXPECT_LT(glm::distance(rows[0].force, rows[1].force), 0.05 * glm::length(rows[0].force));
}

TEST_F(QueryVerbTest, AMeshInTheWrongUnitGivesOneLine) {
  const std::string poses = Write("poses.csv", "0,0,1,1,0,0,0\n");
  const std::string metres = WriteMesh("metres.obj", vps::MakeBox({0.04, 0.04, 0.02}));
  const std::string millimetres = WriteMesh("millimetres.obj", vps::MakeBox({15.0, 9.0, 9.0}));
  const std::string large = WriteMesh("large.obj", vps::MakeBox({80.0, 9.0, 9.0}));
  EXPECT_THAT(ComplaintOf({"query", metres, large, "--poses", poses, "--out", out()}),
              testing::AllOf(HasSubstr("large.obj"), HasSubstr("80 m"), HasSubstr("--scale 0.001")));
  EXPECT_THAT(ComplaintOf({"query", metres, millimetres, "--poses", poses, "--out", out()}),
              testing::AllOf(HasSubstr("millimetres.obj"), HasSubstr("15 m"), HasSubstr("--scale")));
  EXPECT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", large, large, "--poses", poses, "--out", out(), "--scale", "0.001"}),
            kHolds);
}

TEST_F(QueryVerbTest, BadInputGivesOneLineAndLeavesNothing) {
  const std::string box = WriteMesh("box.obj", vps::MakeBox({0.04, 0.04, 0.02}));
  const std::string poses = Write("poses.csv", "0,0,1,1,0,0,0\n");
  const std::string open = Write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(ComplaintOf({"query", box, open, "--poses", poses, "--out", out()}), HasSubstr("3 open edges"));
  const std::string bad = Write("bad.csv", "0,0,1,1,0,0,0\n0,0,1,2,0,0,0\n");
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", bad, "--out", out()}), HasSubstr("bad.csv:2: the quaternion"));
  EXPECT_THAT(ComplaintOf({"query", box, "/no/mesh.obj", "--poses", poses, "--out", out()}), HasSubstr("/no/mesh.obj"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", "/no/p.csv", "--out", out()}), HasSubstr("/no/p.csv"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses}), HasSubstr("--out"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses, "--out", "/no/folder/out.csv"}),
              HasSubstr("/no/folder/out.csv"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses, "--out", out(), "--method", "quick"}),
              HasSubstr("no such method"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses, "--out", out(), "--voxel_m", "-1"}),
              HasSubstr("--voxel_m"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses, "--out", out(), "--voxel_m", "1e-6"}),
              HasSubstr("voxel"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses, "--out", out(), "--accuracy_m", "1"}),
              HasSubstr("--accuracy"));
  EXPECT_THAT(ComplaintOf({"query", box, box, "--poses", poses, "--out", out(), "--sampled", "both"}),
              HasSubstr("--sampled is A or B"));
}

}  // namespace
}  // namespace oos
