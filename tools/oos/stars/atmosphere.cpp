#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>

#include "bus/rt/worker_pool.hpp"
#include "space/atmosphere/table_file.hpp"
#include "tools/oos/stars/verbs.hpp"
#include "vps/asset/cooked_object.hpp"

namespace oos {
namespace {

int RunAtmosphere(const Arguments& arguments) {
  const space::Air air;
  const space::AirTableSizes sizes;
  const std::filesystem::path folder = arguments.text("--out", vps::DefaultCacheFolder().string());
  const std::filesystem::path file = folder / space::AirFileName(air, sizes);
  if (space::ReadAirTables(file, air, sizes)) {
    std::printf("%s: is there\n", file.c_str());
    return kHolds;
  }
  bus::WorkerPool workers(std::max(1u, std::thread::hardware_concurrency()), "atmosphere");
  const bool is_watched = isatty(STDERR_FILENO) != 0;
  const auto tables = space::MakeAirTables<float>(air, sizes, &workers, [&](double share) {
    if (is_watched) std::fprintf(stderr, "\r%3.0f %%", 100.0 * share);
    return true;
  });
  if (is_watched) std::fprintf(stderr, "\r     \r");
  if (const auto written = space::WriteAirTables(file, *tables); !written) {
    return Complain("atmosphere", written.error().detail, kDoesNotHold);
  }
  std::printf("%s: %d orders of scattering\n", file.c_str(), sizes.num_orders);
  return kHolds;
}

}  // namespace

Verb AtmosphereVerb() {
  return {"atmosphere",
          "computes the Earth's air for the pictures",
          "",
          0,
          0,
          {{"--out", "DIR", "default: the cache, where visual_node finds it"}},
          RunAtmosphere,
          "Half a minute of processor time, once, on all cores. A viewer computes it, too, in the background; pictures "
          "without a session have no air until it is there."};
}

}  // namespace oos
