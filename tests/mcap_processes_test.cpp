#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "bus/bulk/bulk.hpp"
#include "bus/bulk/bulk_folder.hpp"
#include "bus/log/mcap_reader.hpp"
#include "bus/log/recorder.hpp"
#include "bus/node.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/codec.hpp"
#include "core/clock.hpp"
#include "proto/recording.pb.h"
#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

constexpr const char* kOos = VR_OOS_BINARY_DIR "/bin/oos";
constexpr const char* kSessionArgument = "7";

// Starts `oos registry` with keys of its own, in a folder that is removed with the test. The session is encrypted.
class McapProcesses : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    registry_ = Start({"registry", "--registry", "tcp://127.0.0.1:0", "--session", kSessionArgument, "--keys", keys(),
                       "--make_keys"});
    ASSERT_NE(registry_, nullptr);
    ASSERT_TRUE(bus::testing::Until([&] {
      process::WaitForAny({registry_.get()}, 10);
      registry_->Poll();
      for (const std::string& line : registry_->TakeLines()) {
        const auto report = nlohmann::json::parse(line, nullptr, false);
        if (report.is_object() && report.value("is", "") == "up") endpoint_ = report.value("endpoint", "");
      }
      return !endpoint_.empty() || registry_->has_ended();
    }));
    ASSERT_FALSE(endpoint_.empty()) << registry_->err();
  }
  ~McapProcesses() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::filesystem::path File(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string keys() const { return (folder_ / "keys").string(); }

  static std::unique_ptr<process::PipedChild> Start(std::vector<std::string> words) {
    words.insert(words.begin(), kOos);
    auto child = process::PipedChild::Start(words);
    EXPECT_TRUE(child) << child.error().detail;
    return child ? std::move(*child) : nullptr;
  }
  // Starts `oos` with these words and the options that join the test's session.
  [[nodiscard]] std::unique_ptr<process::PipedChild> StartAttached(std::vector<std::string> words) const {
    words.insert(words.end(), {"--registry", endpoint_, "--session", kSessionArgument, "--keys", keys()});
    return Start(words);
  }
  [[nodiscard]] std::unique_ptr<bus::Node> Join(const std::string& name, bus::NodeOptions* used = nullptr) const {
    bus::NodeOptions options;
    options.name = name;
    options.registry = endpoint_;
    options.session = 7;
    options.keys = keys();
    if (used != nullptr) *used = options;
    auto node = bus::Node::Create(options);
    EXPECT_TRUE(node) << node.error().detail;
    return node ? std::move(*node) : nullptr;
  }
  // Steps 1 to `num_steps` of a procedure, a millisecond apart.
  void RecordSteps(const std::filesystem::path& file, std::uint64_t num_steps) const {
    auto recorder = std::move(*bus::log::Recorder::Create(file, {}));
    for (std::uint64_t i = 1; i <= num_steps; ++i) {
      bus::Observation o;
      o.topic = "logic/status";
      o.topic_class = bus::TopicClass::kState;
      o.type = bus::MessageType::kLogicStatus;
      o.writer = "logic_node";
      o.sequence = i;
      o.received_ns = static_cast<std::int64_t>(1'000'000 * i);
      core::LogicStatus status;
      status.step = "step_" + std::to_string(i);
      bus::EncodeState(status, &o.payload);
      ASSERT_TRUE(recorder->Add(o));
    }
    ASSERT_TRUE(recorder->Close(0, 0));
  }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("mcap_processes" + std::to_string(::getpid()));
  std::unique_ptr<process::PipedChild> registry_;
  std::string endpoint_;
};

// A node that reads the procedure's step from the bus.
class StepObserver {
 public:
  explicit StepObserver(std::unique_ptr<bus::Node> node)
      : node_(std::move(node)), status_(node_->ReadState<core::LogicStatus>("logic/status")) {
    const auto started = node_->Start();
    EXPECT_TRUE(started) << started.error().detail;
  }
  ::testing::AssertionResult Sees(const std::string& step, process::PipedChild* writer) {
    const bool is_seen = bus::testing::Until([&] {
      bus::testing::WaitBriefly(*node_);
      return status_.has_value() && status_.value().step == step;
    });
    writer->Poll();
    if (is_seen) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "it sees "
                                         << (status_.has_value() ? "'" + status_.value().step + "'" : "nothing")
                                         << "; the writer said: " << writer->out() << writer->err();
  }

 private:
  std::unique_ptr<bus::Node> node_;
  bus::StateReader<core::LogicStatus>& status_;
};

int WaitForEnd(process::PipedChild* child) {
  EXPECT_TRUE(bus::testing::Until([&] {
    process::WaitForAny({child}, 10);
    child->Poll();
    return child->has_ended();
  }));
  return child->status();
}

TEST_F(McapProcesses, AReplayJoinsAnEncryptedSessionAndSeekZeroUndoesLaterStates) {
  RecordSteps(File("steps.mcap"), 3);
  const auto replay = StartAttached({"replay", File("steps.mcap").string(), "--pause"});
  ASSERT_NE(replay, nullptr);
  StepObserver early(Join("client-early"));
  replay->Write("step 2\n");
  ASSERT_TRUE(early.Sees("step_2", replay.get()));
  replay->Write("seek 0\n");
  ASSERT_TRUE(early.Sees("", replay.get()));
  StepObserver late(Join("client-late"));
  ASSERT_TRUE(late.Sees("", replay.get())) << "a node that joins after the seek must not see later states";
  replay->Write("step\n");
  ASSERT_TRUE(early.Sees("step_1", replay.get()));
  ASSERT_TRUE(late.Sees("step_1", replay.get()));
  replay->Write("play\n");
  ASSERT_TRUE(early.Sees("step_3", replay.get()));
  EXPECT_EQ(WaitForEnd(replay.get()), 0) << replay->err();
  EXPECT_NE(replay->out().find("ended at 0.002 of 0.002 s"), std::string::npos) << replay->out();
}

TEST_F(McapProcesses, AReplayReadsItsFileBeforeItJoinsTheSession) {
  const auto answer =
      process::RunHere({kOos, "replay", File("missing.mcap").string(), "--registry", "tcp://127.0.0.1:1", "--session",
                        kSessionArgument, "--keys", File("nowhere").string()});
  ASSERT_TRUE(answer) << answer.error().detail;
  EXPECT_EQ(answer->status, 2);
  EXPECT_NE(answer->err.find("missing.mcap: cannot be read"), std::string::npos) << answer->err;
}

// Sequence numbers of one writer's events that the file holds so far.
std::vector<std::uint32_t> SequencesOf(const std::filesystem::path& file, const std::string& writer) {
  std::vector<std::uint32_t> sequences;
  if (!std::filesystem::exists(file)) return sequences;
  (void)bus::log::ReadMcap(file, [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    const auto its = channel.metadata.find("writer");
    if (channel.topic == "event" && its != channel.metadata.end() && its->second == writer) {
      sequences.push_back(message.sequence);
    }
  });
  return sequences;
}

TEST_F(McapProcesses, AKilledOosRecordKeepsWhatItHadFlushedWithoutAHole) {
  const auto recorder = StartAttached({"record", File("run.mcap").string()});
  ASSERT_NE(recorder, nullptr);
  const auto source = Join("client-source");
  ASSERT_TRUE(source->Start());
  // The file is read again only when it has grown: reading it all the time would take the processor from the recorder.
  std::uintmax_t size = 0;
  std::vector<std::uint32_t> flushed;
  std::uint64_t num_emitted = 0;
  const bool has_flushed = bus::testing::Until([&] {
    if (source->Emit({core::MonotonicNow_ns(), "client-source", "tick", std::to_string(num_emitted)})) ++num_emitted;
    bus::testing::WaitBriefly(*source);
    std::error_code error;
    const std::uintmax_t now = std::filesystem::file_size(File("run.mcap"), error);
    if (!error && now != size) {
      size = now;
      flushed = SequencesOf(File("run.mcap"), "client-source");
    }
    return flushed.size() >= 300;
  });
  recorder->Poll();
  ASSERT_TRUE(has_flushed) << flushed.size() << " of " << num_emitted << " are in the file; " << recorder->err();
  ASSERT_EQ(kill(recorder->pid(), SIGKILL), 0);
  EXPECT_NE(WaitForEnd(recorder.get()), 0) << "it was killed";

  const auto recovery = bus::log::RecoverMcap(File("run.mcap"), File("mended.mcap"));
  ASSERT_TRUE(recovery) << recovery.error().detail;
  EXPECT_FALSE(recovery->was_whole);
  EXPECT_EQ(recovery->num_damaged_chunks, 0U);
  const std::vector<std::uint32_t> saved = SequencesOf(File("mended.mcap"), "client-source");
  ASSERT_GE(saved.size(), flushed.size());
  EXPECT_TRUE(std::equal(flushed.begin(), flushed.end(), saved.begin())) << "what was in the file has changed";
  for (std::size_t i = 1; i < saved.size(); ++i) {
    ASSERT_EQ(saved[i], saved[i - 1] + 1) << "a hole behind event " << saved[i - 1];
  }
}

TEST_F(McapProcesses, AnObserversRecordingHoldsScenarioPlatformHostsAndClocks) {
  bus::NodeOptions options;
  const auto logic = Join("logic_node", &options);
  auto bulk = bus::BulkServer::Create(logic.get(), options);
  ASSERT_TRUE(bulk) << bulk.error().detail;
  ASSERT_TRUE(logic->Start());
  const auto folder = std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "touch";
  const auto offered = bus::OfferFolder(folder, "scenario", bulk->get());
  ASSERT_TRUE(offered) << offered.error().detail;
  std::set<std::string> of_scenario;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension == ".xml" || extension == ".scxml") of_scenario.insert(entry.path().filename().string());
  }
  const auto recorder = StartAttached({"record", File("run.mcap").string(), "--split_s", "1000"});
  ASSERT_NE(recorder, nullptr);
  // Reads the file while it is being written, until it holds everything expected.
  std::set<std::string> texts;
  std::map<std::string, bus::log::TextMap> said;
  std::uint64_t num_samples = 0;
  bool is_sample_of_logic = false;
  std::uintmax_t size = 0;
  const bool has_all = bus::testing::Until([&] {
    logic->Emit({core::MonotonicNow_ns(), "logic_node", "tick", ""});
    bus::testing::WaitBriefly(*logic);
    std::error_code error;
    const std::uintmax_t now = std::filesystem::file_size(File("run.mcap"), error);
    if (error || now == size) return false;
    size = now;
    num_samples = 0;
    const auto contents =
        bus::log::ReadMcap(File("run.mcap"), [&](const bus::log::Channel& channel, const bus::log::Message& message) {
          oos::ClockSample sample;
          if (!channel.topic.starts_with("clock/oos-record-")) return;
          if (!sample.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) return;
          is_sample_of_logic |= sample.peer() == "logic_node" && sample.bound_ns() == 0;
          ++num_samples;
        });
    if (!contents) return false;
    for (const auto& attachment : contents->attachments) texts.insert(attachment.name);
    for (const auto& metadata : contents->metadata) {
      if (metadata.name == "hosts") said["hosts of " + metadata.entries.at("peer")] = metadata.entries;
      said[metadata.name] = metadata.entries;
    }
    return texts == of_scenario && num_samples >= 2 && is_sample_of_logic && said.count("hosts of logic_node") == 1;
  });
  recorder->Poll();
  ASSERT_TRUE(has_all) << texts.size() << " texts, " << num_samples << " clock samples; " << recorder->err();
  EXPECT_EQ(texts.count("procedure.scxml"), 1U);
  EXPECT_EQ(said.at("scenario").at("from"), "logic_node");
  EXPECT_EQ(said.at("platform").count("simd"), 1U);
  EXPECT_EQ(said.at("host").count("clock_id"), 1U);
  EXPECT_EQ(said.at("hosts of logic_node").at("process_id"), std::to_string(getpid()));
  ASSERT_EQ(kill(recorder->pid(), SIGINT), 0);
  EXPECT_EQ(WaitForEnd(recorder.get()), 0) << recorder->err();
}

}  // namespace
}  // namespace system_tests
