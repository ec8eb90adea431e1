#include "nodes/visual_node/sky/earth_air.hpp"

#include <sched.h>
#include <sys/resource.h>

#include <utility>

#include "space/atmosphere/table_file.hpp"
#include "vps/asset/cooked_object.hpp"

namespace visual_node {
namespace {

std::filesystem::path AirFile(const space::AirTableSizes& sizes) {
  return vps::DefaultCacheFolder() / space::AirFileName(space::Air{}, sizes);
}

}  // namespace

core::Result<space::AirFromSpace> CachedAir(const space::AirTableSizes& sizes) {
  const auto tables = space::ReadAirTables(AirFile(sizes), space::Air{}, sizes);
  if (tables) return space::AirFromSpace::From(*tables);
  return core::Fail(tables.error().code, "the Earth has no air in this picture: " + AirFile(sizes).string() +
                                             " is missing or damaged; `oos atmosphere` computes it");
}

AirInWork::AirInWork(const space::AirTableSizes& sizes) : sizes_(sizes), thread_([this] { Work(); }) {}

AirInWork::~AirInWork() {
  is_stop_wanted_ = true;
  thread_.join();
}

// A cache that cannot be written costs the next session's time, and nothing else.
void AirInWork::Work() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_IDLE, &none);
  setpriority(PRIO_PROCESS, 0, 19);
  const auto tables =
      space::MakeAirTables<float>(space::Air{}, sizes_, nullptr, [this](double /*share*/) { return !is_stop_wanted_; });
  if (!tables) return;
  static_cast<void>(space::WriteAirTables(AirFile(sizes_), *tables));
  air_ = space::AirFromSpace::From(*tables);
  is_done_ = true;
}

std::optional<space::AirFromSpace> AirInWork::Take() {
  if (!is_done_) return std::nullopt;
  return std::exchange(air_, std::nullopt);
}

}  // namespace visual_node
