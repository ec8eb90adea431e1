#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bus/log/mcap_records.hpp"
#include "bus/log/step_sink.hpp"
#include "bus/node.hpp"
#include "bus/rt/thread_setup.hpp"
#include "cli/arguments.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace run_node {

// What a node's main.cpp declares about its process.
struct Program {
  std::string name;  // of the executable, of its report and, unless --name says otherwise, on the bus
  std::string_view summary;
  std::vector<cli::Option> options;  // beside those of every node
  std::string_view thread = "";      // name of the loop's real-time thread; empty: the loop has no deadline
  int fifo_priority = 0;             // of that thread
  bool can_record_steps = true;      // --steps
  std::string_view ready;            // detail of the event "ready"
};

// What the process was started with.
struct Setting {
  const cli::Arguments& arguments;
  const scene::Scenario& scenario;
  bus::RealTimeMode mode;
  std::filesystem::path out;
};

// How the steps of a node are written down: see replay::OpenStepLog.
struct StepFormat {
  std::string fields;
  bus::log::TextMap about;               // beside what replay::DescribeRun gives
  std::vector<std::uint8_t> checkpoint;  // where the node stands; empty: at its beginning
};

// A node and its loop, called by RunNode in the order below. The setting and the bus node outlive it.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  // Builds the node, without the bus.
  virtual core::Result<void> Build(const Setting& setting) = 0;
  // Makes the loop, which declares its topics: `node` has not started.
  virtual core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& options) = 0;
  // Only with Program::can_record_steps and when steps are wanted.
  virtual core::Result<StepFormat> DescribeSteps() { return StepFormat{}; }
  virtual void RecordSteps(bus::log::StepSink* /*sink*/) {}
  // The node is on the bus and the thread is set up. What it prints stands above "ready" in the log.
  virtual void OnStart() {}
  virtual void Run(const std::atomic<bool>& stop) = 0;
  virtual core::Result<void> WriteReport(bool is_realtime) = 0;
};

// The life of a node's process, from the command line to the report. Returns the exit status: 0 after SIGTERM or
// SIGINT, 1 when something failed, 2 for bad usage or input. For main() alone: it sets signal handlers and prints.
int RunNode(int argc, char** argv, const Program& program, std::unique_ptr<Body> body);

// One of several nodes in a process.
struct Member {
  std::string name;        // on the bus, and of its report
  std::string_view ready;  // as Program::ready
  std::unique_ptr<Body> body;
};

// The same for several nodes in one process, each with its own end of the bus. They are started in their order; the
// last one's Run runs them all. --record and --steps name folders, where each node writes NAME.mcap.
int RunNodes(int argc, char** argv, const Program& program, std::vector<Member> members);

// Progress of Build, a line each.
void PrintLine(const std::string& line);
// An error that names the folder, unless `is_written`.
core::Result<void> CheckWritten(bool is_written, const std::filesystem::path& out);

// Options that several nodes have.
cli::Option WorkersOption();
cli::Option MethodOption();
cli::Option CacheOption();

}  // namespace run_node
