#include "tools/oos/run/report/report_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "bus/log/recorder.hpp"
#include "bus/wire/codec.hpp"
#include "picture/image.hpp"
#include "tools/oos/run/report/run_history.hpp"

namespace oos {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::int64_t kBegin_ns = 4'000'000'000;

class ReportPageTest : public testing::Test {
 protected:
  ReportPageTest() { std::filesystem::create_directories(folder_); }
  ~ReportPageTest() override { std::filesystem::remove_all(folder_); }

  // Forces of one hand for 3 s, and a viewer's recording with two steps, at 1 and 2 s, and late cycles.
  void LeaveFiles() const {
    std::ofstream force(folder_ / "device_bridge_force.csv");
    force << "time_ns,role,force_N,torque_Nm\n";
    for (int i = 0; i < 3000; ++i) force << kBegin_ns + i * 1'000'000LL << ",0," << (i == 1500 ? 17 : 2) << ",0\n";
    ASSERT_TRUE(picture::WritePng(picture::Image(8, 8), folder_ / "contact_sheet.png"));
    auto recorder = std::move(*bus::log::Recorder::Create(SceneRecording(folder_), {}));
    bus::Observation seen;
    seen.topic_class = bus::TopicClass::kState;
    const auto add = [&](const std::string& topic, const auto& value, std::int64_t time_ns) {
      seen.topic = topic;
      seen.type = bus::kMessageTypeOf<std::decay_t<decltype(value)>>;
      seen.received_ns = kBegin_ns + time_ns;
      ++seen.sequence;
      bus::EncodeState(value, &seen.payload);
      EXPECT_TRUE(recorder->Add(seen));
    };
    core::LogicStatus status;
    core::Figures late;
    late.items = {{"misses", 4.0}};
    add(bus::kLogicStatusTopic, status, 0);
    status.step = "approach";
    status.time_ns = 0;
    add(bus::kLogicStatusTopic, status, 1'000'000'000);
    add(bus::FiguresTopic("haptic_node"), late, 1'500'000'000);
    status.step = "insert";
    status.time_ns = 1'000'000'000;
    add(bus::kLogicStatusTopic, status, 2'000'000'000);
    ASSERT_TRUE(recorder->Close(0, 0));
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("report_page_" + std::to_string(getpid()));
  const nlohmann::json report_ = {
      {"scenario", "a <test>"},
      {"completed", true},
      {"seconds", 3.0},
      {"steps",
       {{{"name", "approach"}, {"completed", true}, {"seconds", 1.0}},
        {{"name", "insert"}, {"completed", false}, {"seconds", 0.5}, {"why", "too slow & late"}}}},
      {"t1_ms", {{"mean", 1.25}, {"n", 9}}}};
};

TEST_F(ReportPageTest, HasNoExternalLink) {
  LeaveFiles();
  const std::string page = ReportPage(report_, folder_);
  const std::regex reference(R"((src|href|action|data|poster|srcset)\s*=\s*["'](?!data:)|url\(|@import|<script|<link)");
  EXPECT_FALSE(std::regex_search(page, reference));
  const std::regex address(R"((https?:)?//[a-z0-9.]+)");
  for (std::sregex_iterator it(page.begin(), page.end(), address), end; it != end; ++it) {
    EXPECT_EQ(it->str(), "http://www.w3.org") << "only the name of SVG";
  }
  EXPECT_THAT(page, HasSubstr("src=\"data:image/png;base64,iVBORw0KGgo"));
}

TEST_F(ReportPageTest, StepsHaveTheirTimesAndReasons) {
  LeaveFiles();
  const std::string page = ReportPage(report_, folder_);
  EXPECT_THAT(page, HasSubstr("<td>approach</td><td class=\"number\">0.0</td>"));
  EXPECT_THAT(page, HasSubstr("<td>insert</td><td class=\"number\">1.0</td>"));
  EXPECT_THAT(page, HasSubstr("missed: too slow &amp; late"));
  EXPECT_THAT(page, HasSubstr("a &lt;test&gt;"));
}

TEST_F(ReportPageTest, ChartsShowWhatTheNodesLeft) {
  LeaveFiles();
  const RunHistory history = RunHistory::Read(folder_);
  ASSERT_EQ(history.force_N.size(), 1U);
  EXPECT_LE(history.force_N[0].points.size(), 400U);
  const auto peak = std::max_element(history.force_N[0].points.begin(), history.force_N[0].points.end(),
                                     [](const auto& a, const auto& b) { return a.value < b.value; });
  EXPECT_EQ(peak->value, 17.0);  // one sample of 3000 is not lost
  EXPECT_NEAR(peak->t_s, 0.5, 1e-9);
  ASSERT_EQ(history.late_cycles.points.size(), 1U);
  EXPECT_NEAR(history.late_cycles.points[0].t_s, 0.5, 1e-9);
  EXPECT_EQ(history.late_cycles.points[0].value, 4.0);
  const std::string page = ReportPage(report_, folder_);
  EXPECT_THAT(page, HasSubstr("Force on the hand"));
  EXPECT_THAT(page, HasSubstr("Late haptic cycles"));
  EXPECT_THAT(page, Not(HasSubstr("Latency (t1")));
}

// A thousand traces to the hand and a hundred to the picture, one of which took 80 ms.
TEST_F(ReportPageTest, ARunWithLatenciesHasTheirChart) {
  LeaveFiles();
  std::ofstream latency(folder_ / "latency.csv");
  latency << "chain,trace_id,origin_ns,echo_ns,stage,offset_ns,...\n";
  const auto add = [&](const char* chain, int id, std::int64_t offset_ns) {
    latency << chain << ',' << id << ',' << kBegin_ns + 1'000'000'000 + id * 1'000'000LL << ",-1,1,0,2," << offset_ns
            << '\n';
  };
  for (int i = 0; i < 1000; ++i) add("t1", i, 1'500'000);
  for (int i = 0; i < 1000; i += 10) add("t2_image", i, i == 500 ? 80'000'000 : 30'000'000);
  add("t2", 3, 900'000'000);  // to the scene, not to its picture: no curve
  latency.close();
  const RunHistory history = RunHistory::Read(folder_);
  ASSERT_EQ(history.latency_ms.size(), 2U);
  EXPECT_EQ(history.latency_ms[0].name, "t1");
  EXPECT_EQ(history.latency_ms[1].name, "t2_image");
  for (const Course::Point& point : history.latency_ms[0].points) EXPECT_NEAR(point.value, 1.5, 1e-9);
  const auto& images = history.latency_ms[1].points;
  const auto slowest =
      std::max_element(images.begin(), images.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  EXPECT_NEAR(slowest->value, 80.0, 1e-9);
  EXPECT_NEAR(slowest->t_s, 0.5, 1e-9);
  const std::string page = ReportPage(report_, folder_);
  EXPECT_THAT(page, HasSubstr("Latency (t1"));
  EXPECT_THAT(page, HasSubstr("t2_image</text>"));
  EXPECT_THAT(page, Not(HasSubstr("Latency over time: no trace")));
}

TEST_F(ReportPageTest, SaysWhatIsMissingAndHowToGetIt) {
  const std::string bare = ReportPage(report_, folder_);
  for (const char* what : {"The film: no viewer ran",
                           "The contact sheet:", "Force over time:", "Latency over time:", "Late cycles over time:"}) {
    EXPECT_THAT(bare, HasSubstr(what));
  }
  LeaveFiles();
  const std::string page = ReportPage(report_, folder_);
  EXPECT_THAT(page, HasSubstr("The film: oos report " + folder_.string()));
  EXPECT_THAT(page, Not(HasSubstr("The contact sheet:")));
  std::ofstream(FilmFile(folder_)) << "film";
  EXPECT_THAT(ReportPage(report_, folder_), HasSubstr("src=\"data:video/mp4;base64,ZmlsbQ==\""));
}

TEST_F(ReportPageTest, AFilmThatIsOlderThanTheRecordingIsOfAnotherRun) {
  LeaveFiles();
  std::ofstream(FilmFile(folder_)) << "film";
  const auto recorded = std::filesystem::last_write_time(SceneRecording(folder_));
  std::filesystem::last_write_time(FilmFile(folder_), recorded - std::chrono::hours(1));
  EXPECT_THAT(ReportPage(report_, folder_), Not(HasSubstr("<video")));
  std::filesystem::last_write_time(FilmFile(folder_), recorded + std::chrono::hours(1));
  EXPECT_THAT(ReportPage(report_, folder_), HasSubstr("<video"));
}

}  // namespace
}  // namespace oos
