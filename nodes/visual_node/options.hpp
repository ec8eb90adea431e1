#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "core/result.hpp"

namespace visual_node {

struct Options {
  std::filesystem::path scenario;
  std::string name = "visual_node";  // on the bus; a second viewer of the session: "visual_node-2"
  std::string registry;
  std::uint64_t session = 0;
  std::string bind_address = "127.0.0.1";
  std::string keys;  // key directory of the run, bus/keys.hpp
  bool is_encrypted = true;
  std::filesystem::path out = ".";
  std::map<std::string, std::string> recording;  // --record FILE, --split_MB N, --split_s N: bus/log/node_recording.hpp
  int width = 640;
  int height = 360;
  std::string view;  // camera to stay with; empty: the camera named after the step, else the first
  bool is_headless = false;
  double max_frames_per_s = 30.0;
  bool is_still = false;  // --still: each named camera once, without any bus
};

constexpr const char* kUsage =
    "visual_node --scenario FILE --registry ENDPOINT --session N --out DIR --keys DIR | --no_encryption\n"
    "            [--size 640x360] [--view NAME] [--headless] [--fps 30] [--bind ADDRESS] [--name NAME]\n"
    "visual_node --still SCENARIO --out DIR [--size 640x360]   each named camera once, without a bus\n";

core::Result<Options> ParseOptions(int argc, char** argv);

}  // namespace visual_node
