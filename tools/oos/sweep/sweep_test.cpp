#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>

#include "core/clock.hpp"
#include "scene/load_scenario.hpp"
#include "tools/oos/attach/remote.hpp"
#include "tools/oos/sweep/sweep_plan.hpp"
#include "tools/oos/sweep/sweep_results.hpp"
#include "tools/oos/sweep/verbs.hpp"

namespace oos {
namespace {

std::filesystem::path Scenario(const std::string& name) {
  return std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name / "scenario.xml";
}

std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// The first one.
void ReplaceInFile(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  std::string text = ReadText(file);
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  std::ofstream(file) << text.replace(at, from.size(), to);
}

class Sweep : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    // The nodes' and this project's programs, not those of somebody's PATH.
    setenv("VR_OOS_BIN_DIR", (std::filesystem::path(VR_OOS_BINARY_DIR) / "bin").c_str(), 1);
  }
  void TearDown() override {
    for (const char* name : {"VR_OOS_BIN_DIR", "OOS", "PARALLEL_SSH"}) unsetenv(name);
    if (!HasFailure()) std::filesystem::remove_all(folder_);
  }

  int Run(const std::vector<std::string>& words) { return RunScenario(Scenario("free_collision"), words); }
  int RunScenario(const std::filesystem::path& scenario, std::vector<std::string> words) {
    words.insert(words.begin(), {"sweep", scenario.string(), "--out", out_.string()});
    return RunVerbs({SweepVerb()}, words);
  }
  // Like Run; returns the error message.
  std::string Refused(const std::vector<std::string>& words) {
    testing::internal::CaptureStderr();
    EXPECT_NE(Run(words), kHolds);
    return testing::internal::GetCapturedStderr();
  }
  [[nodiscard]] std::string Read(const std::string& name) const { return ReadText(out_ / name); }

  [[nodiscard]] std::string WriteProgram(const std::string& name, const std::string& script) const {
    const std::filesystem::path file = folder_ / name;
    std::ofstream(file) << "#!/bin/sh\n" << script << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file.string();
  }
  // The runs' program from now on, in place of `oos`; its second argument is the scenario, its fifth the seed.
  void SetProgram(const std::string& script) const { setenv("OOS", WriteProgram("program", script).c_str(), 1); }
  // A run that ends well, and is counted.
  [[nodiscard]] std::string GoodRun() const {
    return "[ -f \"$2\" ] || exit 2\necho >> '" + (folder_ / "calls").string() +
           "'\nmkdir -p out\necho '{\"completed\": true, \"seconds\": 1.5, \"peak_force_N\": 2.5}' > out/report.json";
  }
  [[nodiscard]] std::size_t num_calls() const { return ReadText(folder_ / "calls").size(); }
  void WriteReport(const std::string& run, const std::string& text) const {
    std::filesystem::create_directories(out_ / "runs" / run / "out");
    std::ofstream(out_ / "runs" / run / "out" / "report.json") << text;
  }

  // Of this test.
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      ("sweep_" + std::to_string(getpid()) + "_" + testing::UnitTest::GetInstance()->current_test_info()->name());
  std::filesystem::path out_ = folder_ / "out";
};

TEST(SweepPlan, ARangeHasBothEndsAndEqualSteps) {
  const auto axis = ParseAxis("object[block a].mass_kg=1:4:4");
  ASSERT_TRUE(axis.has_value()) << axis.error().detail;
  EXPECT_EQ(axis->element, "object");
  EXPECT_EQ(axis->element_name, "block a");
  EXPECT_EQ(axis->attribute, "mass_kg");
  EXPECT_EQ(axis->values, (std::vector<std::string>{"1", "2", "3", "4"}));
  EXPECT_EQ(ParseAxis("run.method=paper,fast")->values, (std::vector<std::string>{"paper", "fast"}));
}

TEST(SweepPlan, AMalformedAxisIsRefusedWithTheRightForm) {
  for (const char* text : {"", "mass_kg", "=1:2:3", "mass_kg=1:2", "mass_kg=1:2:1", "mass_kg=a:2:3",
                           "object[a.mass=1:2:3", "mass_kg=", "object.=1:2:3"}) {
    const auto axis = ParseAxis(text);
    ASSERT_FALSE(axis.has_value()) << text;
    EXPECT_NE(axis.error().detail.find("NAME=LOW:HIGH:N"), std::string::npos) << text;
  }
}

TEST(SweepPlan, RunsEveryPointOfTheGridWithEverySeedOnce) {
  const std::vector<SweepRun> runs = PlanRuns({*ParseAxis("a=1:3:3"), *ParseAxis("b=x,y")}, 5);
  ASSERT_EQ(runs.size(), 30u);
  std::set<std::string> different;
  for (const SweepRun& run : runs) {
    different.insert(run.values[0] + " " + run.values[1] + " " + std::to_string(run.seed));
  }
  EXPECT_EQ(different.size(), 30u);
}

TEST_F(Sweep, ACopyNeedsNothingOutsideItsFolderAndHasTheValues) {
  const auto axis = ParseAxis("run.seed=7,8");
  ASSERT_TRUE(WriteScenarioCopy(Scenario("free_collision"), {*axis}, {"8"}, out_ / "copy").has_value());
  const auto scenario = scene::LoadScenario(out_ / "copy" / "scenario.xml");
  ASSERT_TRUE(scenario.has_value());
  EXPECT_EQ(scenario->seed, 8u);
  for (const scene::Object& object : scenario->objects) {
    const std::string mesh = object.visual_mesh.lexically_normal().string();
    EXPECT_EQ(mesh.find((out_ / "copy").string()), 0u) << mesh;
  }
}

// A scenario's folder with two meshes of the same name beside it.
TEST_F(Sweep, FilesOfOneNameFromSeveralFoldersStaySeveral) {
  for (const bool is_absolute : {false, true}) {
    SCOPED_TRACE(is_absolute ? "absolute" : "relative");
    const std::filesystem::path source = folder_ / (is_absolute ? "absolute" : "relative");
    std::filesystem::create_directories(source);
    std::filesystem::copy(Scenario("free_collision").parent_path(), source / "mine",
                          std::filesystem::copy_options::recursive);
    for (const auto& [folder, mesh] : {std::pair{"x", "block.obj"}, {"y", "ball.obj"}}) {
      std::filesystem::create_directories(source / folder);
      std::filesystem::copy_file(Scenario("touch").parent_path() / "meshes" / mesh, source / folder / "part.obj");
      ReplaceInFile(source / "mine" / "scenario.xml", "../touch/meshes/block.obj",
                    (is_absolute ? source : "..") / folder / "part.obj");
    }
    // A copy of a copy already has files from elsewhere, and further ones are added.
    const auto axis = ParseAxis("run.seed=7");
    const std::filesystem::path copy = source / "copy", second = source / "second";
    auto written = WriteScenarioCopy(source / "mine" / "scenario.xml", {*axis}, {"7"}, copy);
    ASSERT_TRUE(written.has_value()) << written.error().detail;
    ReplaceInFile(copy / "scenario.xml", "from_elsewhere/2/part.obj", "../y/part.obj");
    written = WriteScenarioCopy(copy / "scenario.xml", {*axis}, {"7"}, second);
    ASSERT_TRUE(written.has_value()) << written.error().detail;

    const auto scenario = scene::LoadScenario(second / "scenario.xml");
    ASSERT_TRUE(scenario.has_value());
    const std::string x = ReadText(source / "x" / "part.obj"), y = ReadText(source / "y" / "part.obj");
    ASSERT_NE(x, y);
    EXPECT_EQ(ReadText(scenario->objects[0].visual_mesh), x);
    EXPECT_EQ(ReadText(scenario->objects[1].visual_mesh), y);
    for (const scene::Object& object : scenario->objects) {
      EXPECT_EQ(object.visual_mesh.string().find(second.string()), 0u) << object.visual_mesh;
    }
  }
}

TEST_F(Sweep, AnArmsLinksAreCopiedWithTheirMeshes) {
  const std::filesystem::path source = folder_ / "source", mine = source / "mine";
  std::filesystem::create_directories(source);
  std::filesystem::copy(Scenario("service_robot").parent_path(), mine, std::filesystem::copy_options::recursive);
  std::filesystem::rename(mine / "arm.xml", source / "arm.xml");
  std::filesystem::rename(mine / "meshes" / "wrist.obj", source / "wrist.obj");
  for (int arm = 0; arm < 2; ++arm) ReplaceInFile(mine / "scenario.xml", "\"arm.xml\"", "\"../arm.xml\"");
  ReplaceInFile(source / "arm.xml", "meshes/wrist.obj", "../wrist.obj");
  const auto written =
      WriteScenarioCopy(mine / "scenario.xml", {*ParseAxis("run.seed=7")}, {"7"}, folder_ / "copy" / "scenario");
  ASSERT_TRUE(written.has_value()) << written.error().detail;
  std::filesystem::remove_all(source);
  const auto scenario = scene::LoadScenario(folder_ / "copy" / "scenario");
  EXPECT_TRUE(scenario.has_value()) << scene::Format(scenario.error().front());
}

TEST_F(Sweep, AFileThatCannotBeCopiedIsNamedWithItsPlace) {
  const auto written =
      WriteScenarioCopy(Scenario("free_collision"),
                        {*ParseAxis("object[mover].position=1 0 0"), *ParseAxis("visual.mesh=../nowhere/part.obj")},
                        {"1 0 0", "../nowhere/part.obj"}, out_ / "copy");
  ASSERT_FALSE(written.has_value());
  for (const char* text : {"scenario.xml:9: mesh=\"../nowhere/part.obj\"", "scenarios/nowhere/part.obj", "correct"}) {
    EXPECT_NE(written.error().detail.find(text), std::string::npos) << written.error().detail;
  }
}

// Blanks and quotes: the shell gets the name as one word.
TEST_F(Sweep, AScenarioFileMayHaveAnyName) {
  const std::filesystem::path mine = folder_ / "touch";
  std::filesystem::copy(Scenario("touch").parent_path(), mine, std::filesystem::copy_options::recursive);
  std::filesystem::rename(mine / "scenario.xml", mine / "anna's $HOME scene.xml");
  SetProgram(GoodRun());
  EXPECT_EQ(RunScenario(mine / "anna's $HOME scene.xml", {"--grid", "run.method=fast"}), kHolds) << Read("results.csv");
}

TEST_F(Sweep, AnOutInsideTheScenariosFolderIsRefused) {
  const std::filesystem::path mine = folder_ / "mine";
  std::filesystem::copy(Scenario("touch").parent_path(), mine, std::filesystem::copy_options::recursive);
  std::filesystem::create_directory_symlink(mine, folder_ / "link");
  for (const auto& out : {mine, mine / "out" / "study", folder_ / "link" / "study"}) {
    out_ = out;
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunScenario(mine / "scenario.xml", {"--grid", "run.method=fast", "--dry-run"}), kBadUsage) << out;
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("inside the scenario's own folder"), std::string::npos) << said;
    EXPECT_NE(said.find("--out elsewhere"), std::string::npos) << said;
  }
  EXPECT_FALSE(std::filesystem::exists(mine / "out"));
}

TEST_F(Sweep, OfSeedsAloneNeedsNoGrid) {
  EXPECT_NE(Refused({"--dry-run"}).find("--grid or --seeds"), std::string::npos);
  ASSERT_EQ(Run({"--seeds", "3", "--dry-run"}), kHolds);
  EXPECT_TRUE(std::filesystem::exists(out_ / "runs" / "00003"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "runs" / "00004"));
}

// One point per seed.
TEST(SweepChart, OfSeedsAloneHasThemOnItsAxis) {
  const std::vector<SweepRun> runs = PlanRuns({}, 2);
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[1].seed, 2U);
  SweepOutcome outcome;
  outcome.has_report = outcome.is_completed = true;
  outcome.seconds = 3.0;
  const std::string chart = ResultChart("touch", {}, runs, {outcome, outcome});
  EXPECT_NE(chart.find("each seed"), std::string::npos);
  EXPECT_NE(chart.find(">seed<"), std::string::npos);
}

TEST_F(Sweep, AnUnknownAttributeAndAnInvalidValueAreRefused) {
  EXPECT_EQ(Run({"--grid", "object.colour_of_the_sky=1:2:2", "--dry-run"}), kBadUsage);
  EXPECT_EQ(Run({"--grid", "nothing_has_this=1:2:2", "--dry-run"}), kBadUsage);
  EXPECT_EQ(Run({"--grid", "run.method=magic", "--dry-run"}), kBadUsage);
  EXPECT_FALSE(std::filesystem::exists(out_ / "runs")) << "nothing half-built";
}

// Folders that were written before a point of the grid was refused are of no plan: another grid does not inherit them.
TEST_F(Sweep, ARefusedGridLeavesNoFoldersForTheNext) {
  ASSERT_EQ(Run({"--grid", "run.method=paper,magic", "--dry-run"}), kBadUsage);
  ASSERT_EQ(Run({"--grid", "run.method=fast,paper", "--dry-run"}), kHolds);
  const auto scenario = scene::LoadScenario(out_ / "runs" / "00001" / "scenario");
  ASSERT_TRUE(scenario.has_value());
  EXPECT_EQ(scenario->method, "fast");
}

TEST_F(Sweep, AFolderOfAnotherSweepIsRefused) {
  ASSERT_EQ(Run({"--grid", "run.method=fast", "--dry-run"}), kHolds);
  EXPECT_NE(Refused({"--grid", "run.method=paper", "--dry-run"}).find("holds another sweep"), std::string::npos);
  EXPECT_EQ(RunScenario(Scenario("touch"), {"--grid", "run.method=fast", "--dry-run"}), kBadUsage);
  std::filesystem::remove(out_ / "plan.csv");
  EXPECT_NE(Refused({"--grid", "run.method=fast", "--dry-run"}).find("plan.csv is missing"), std::string::npos);
}

TEST_F(Sweep, EndsWithATableAndAChart) {
  const std::vector<std::string> words = {"--grid", "run.method=paper,fast", "--seeds", "2", "--jobs", "2"};
  ASSERT_EQ(Run(words), kHolds);
  const std::string table = Read("results.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5) << table;
  EXPECT_NE(Read("results.svg").find("<svg"), std::string::npos);
}

// Whatever ended the run: its host was lost, a signal stopped it, it was killed while it wrote.
TEST_F(Sweep, RepeatsOnlyRunsWithoutAReport) {
  const std::vector<std::string> words = {"--grid", "run.method=paper,fast", "--seeds", "3"};
  SetProgram("[ \"$5\" != 1 ] || exit 255\n" + GoodRun());
  EXPECT_EQ(Run(words), kDoesNotHold);
  EXPECT_NE(Read("results.csv").find("no report"), std::string::npos);
  EXPECT_EQ(num_calls(), 4u);

  WriteReport("00002", R"({"completed": false, "why": "interrupted", "seconds": 1.0, "peak_force_N": 1.0})");
  WriteReport("00003", R"({"completed": tr)");
  WriteReport("00005", R"({"completed": false, "why": "too slow", "seconds": 9.0, "peak_force_N": null})");
  SetProgram(GoodRun());
  EXPECT_EQ(Run(words), kHolds);
  EXPECT_EQ(num_calls(), 8u) << "1 and 4 had none, 2 and 3 no good one; 5 has failed, but it has ended";
  EXPECT_NE(Read("results.csv").find(",0,9,,too slow"), std::string::npos) << Read("results.csv");
  EXPECT_EQ(Read("results.svg").find("nan"), std::string::npos);

  EXPECT_EQ(Run(words), kHolds);
  EXPECT_EQ(num_calls(), 8u);
}

// As a cluster's scheduler does it.
TEST_F(Sweep, RunsThatWereDoneElsewhereAreOnlyCollected) {
  const std::vector<std::string> words = {"--grid", "run.method=paper,fast", "--seeds", "2"};
  std::vector<std::string> dry = words;
  dry.emplace_back("--dry-run");
  SetProgram(GoodRun());
  ASSERT_EQ(Run(dry), kHolds);
  EXPECT_EQ(Read("jobs.txt"), "runs/00001\nruns/00002\nruns/00003\nruns/00004\n");
  for (const char* run : {"00001", "00002", "00004"}) {
    EXPECT_EQ(std::system(("'" + (out_ / "runs" / run / "run.sh").string() + "'").c_str()), 0);
  }
  EXPECT_EQ(Run(dry), kHolds);
  EXPECT_EQ(Read("jobs.txt"), "runs/00003\n");
  EXPECT_EQ(num_calls(), 3u);
  EXPECT_EQ(Run(words), kHolds);
  EXPECT_EQ(num_calls(), 4u);
  const std::string table = Read("results.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5) << table;
}

// Somebody else's child. Not left alive by a test that fails.
class Process {
 public:
  explicit Process(pid_t pid) : pid_(pid), fd_(static_cast<int>(syscall(SYS_pidfd_open, pid, 0))) {}
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (IsThere()) kill(pid_, SIGKILL);
    if (fd_ >= 0) close(fd_);
  }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool IsThere() const { return !EndsWithin(0); }
  [[nodiscard]] bool EndsWithin(int timeout_ms) const {
    pollfd p{fd_, POLLIN, 0};
    return fd_ < 0 || poll(&p, 1, timeout_ms) == 1;
  }

 private:
  pid_t pid_;
  int fd_;
};

// A sweep in a process of its own, whose processes announce themselves through one pipe and stay until the test lets go
// of another.
class KilledSweep : public Sweep {
 protected:
  void SetUp() override {
    Sweep::SetUp();
    for (const auto& [fd, file] : {std::pair{&announced_fd_, announced_}, {&stay_fd_, stay_}}) {
      ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
      *fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
      ASSERT_GE(*fd, 0);
    }
  }
  void TearDown() override {
    sweep_.reset();
    // In this order no process begins to wait any more.
    std::filesystem::remove(announced_);
    std::filesystem::remove(stay_);
    close(announced_fd_);
    close(stay_fd_);
    Sweep::TearDown();
  }

  [[nodiscard]] std::string Stays() const {
    // What is ignored stays so across exec.
    return "trap '' TERM INT HUP\necho $$ > '" + announced_.string() + "'\nexec cat '" + stay_.string() + "'";
  }
  void Start(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {std::string(VR_OOS_BINARY_DIR) + "/bin/oos", "sweep",
                                      Scenario("free_collision").string(), "--out", out_.string()};
    words.insert(words.end(), words_.begin(), words_.end());
    words.insert(words.end(), more.begin(), more.end());
    auto child = PipedChild::Start(words);
    ASSERT_TRUE(child) << child.error().detail;
    sweep_ = std::move(*child);
  }
  // The next process that announces itself.
  std::unique_ptr<Process> Next() {
    std::string line;
    for (char c = 0; IsAnnounced(30'000) && read(announced_fd_, &c, 1) == 1 && c != '\n';) line += c;
    EXPECT_NE(line, "") << "nothing was started";
    return line.empty() ? nullptr : std::make_unique<Process>(std::stoi(line));
  }
  [[nodiscard]] bool IsAnnounced(int timeout_ms) const {
    pollfd p{announced_fd_, POLLIN, 0};
    return poll(&p, 1, timeout_ms) == 1;
  }
  [[nodiscard]] std::unique_ptr<Process> Child() const {
    const std::string pid = std::to_string(sweep_->pid());
    const std::string children = ReadText("/proc/" + pid + "/task/" + pid + "/children");
    EXPECT_NE(children, "") << "no GNU parallel";
    return children.empty() ? nullptr : std::make_unique<Process>(std::stoi(children));
  }

  static constexpr int kPatience_ms = 20'000;
  const std::vector<std::string> words_ = {"--grid", "run.method=paper,fast", "--seeds", "2"};
  const std::filesystem::path announced_ = folder_ / "announced", stay_ = folder_ / "stay";
  int announced_fd_ = -1, stay_fd_ = -1;
  std::unique_ptr<PipedChild> sweep_;
};

TEST_F(KilledSweep, LeavesNoProcessAndTheSameCommandGoesOn) {
  SetProgram(Stays());
  Start({"--jobs", "2"});
  const auto first = Next(), second = Next(), parallel = Child();
  ASSERT_TRUE(first && second && parallel);

  // Another one beside it is refused by name, and starts nothing.
  SetProgram(GoodRun());
  const std::string said = Refused(words_);
  EXPECT_NE(said.find("is in use by another sweep (process " + std::to_string(sweep_->pid())), std::string::npos)
      << said;
  EXPECT_EQ(num_calls(), 0u);
  EXPECT_TRUE(first->IsThere() && second->IsThere() && parallel->IsThere());

  kill(sweep_->pid(), SIGKILL);
  EXPECT_TRUE(parallel->EndsWithin(kPatience_ms));
  EXPECT_TRUE(first->EndsWithin(kPatience_ms));
  EXPECT_TRUE(second->EndsWithin(kPatience_ms));
  EXPECT_EQ(num_calls(), 0u) << "a run was started after the kill";

  EXPECT_EQ(Run(words_), kHolds);
  EXPECT_EQ(num_calls(), 4u);
}

// Before its first run, while it determines a host's number of cores, GNU parallel ignores SIGTERM.
TEST_F(KilledSweep, LeavesNoGnuParallelThatHasNotBegun) {
  setenv("PARALLEL_SSH", WriteProgram("ssh", Stays()).c_str(), 1);
  Start({"--hosts", "far"});
  const auto ssh = Next(), parallel = Child();
  ASSERT_TRUE(ssh && parallel);
  kill(sweep_->pid(), SIGKILL);
  EXPECT_TRUE(parallel->EndsWithin(kPatience_ms));
}

// GNU parallel itself may be what is killed: the runs that it leaves still have the folder.
TEST_F(KilledSweep, RunsThatAreLeftKeepTheFolder) {
  SetProgram(Stays());
  Start({"--jobs", "2"});
  const auto first = Next(), second = Next(), parallel = Child();
  ASSERT_TRUE(first && second && parallel);
  kill(parallel->pid(), SIGKILL);
  const auto deadline_ns = core::MonotonicNow_ns() + 20 * core::kNanosecondsPerSecond;
  for (; !sweep_->has_ended() && core::MonotonicNow_ns() < deadline_ns; sweep_->Poll()) {
    WaitForAny({sweep_.get()}, 50);
  }
  EXPECT_EQ(sweep_->status(), kDoesNotHold);
  EXPECT_NE(sweep_->err().find("stopped before the end; the same command goes on"), std::string::npos);
  SetProgram(GoodRun());
  EXPECT_NE(Refused(words_).find("is in use"), std::string::npos);
  EXPECT_EQ(num_calls(), 0u);
}

}  // namespace
}  // namespace oos
