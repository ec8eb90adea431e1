#include "space/atmosphere/table_file.hpp"

#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "core/hash.hpp"
#include "core/read_file.hpp"
#include "core/write_file.hpp"

namespace space {
namespace {

struct Head {
  char magic[8] = {'O', 'O', 'S', 'A', 'I', 'R', '0', '1'};  // another number when other numbers are computed
  std::uint64_t key = 0;
  std::uint64_t checksum = 0;  // of all that follows
};

std::uint64_t KeyOf(const Air& air, const AirTableSizes& sizes) {
  static_assert(sizeof(Air) % sizeof(double) == 0 && sizeof(AirTableSizes) % sizeof(int) == 0);  // no padding
  return core::Hash64(&sizes, sizeof sizes, core::Hash64(&air, sizeof air, core::Hash64(Head{}.magic, 8)));
}

// Calls visit(bytes, number of them) for each table, in the file's order.
template <typename Tables, typename Visit>
void ForEachTable(Tables& tables, const Visit& visit) {
  const auto bytes = [&](auto& values) { visit(values.data(), values.size() * sizeof values[0]); };
  bytes(tables.transmittance);
  bytes(tables.scattering);
  bytes(tables.irradiance);
}

}  // namespace

std::string AirFileName(const Air& air, const AirTableSizes& sizes) {
  char name[40];
  std::snprintf(name, sizeof name, "atmosphere-%016" PRIx64 ".air", KeyOf(air, sizes));
  return name;
}

core::Result<void> WriteAirTables(const std::filesystem::path& file, const AirTables<float>& tables) {
  std::string bytes(sizeof(Head), '\0');
  ForEachTable(tables, [&](const void* from, std::size_t num) { bytes.append(static_cast<const char*>(from), num); });
  Head head;
  head.key = KeyOf(tables.air, tables.sizes);
  head.checksum = core::Hash64(bytes.data() + sizeof head, bytes.size() - sizeof head);
  std::memcpy(bytes.data(), &head, sizeof head);
  return core::WriteFile(file, bytes);
}

core::Result<AirTables<float>> ReadAirTables(const std::filesystem::path& file, const Air& air,
                                             const AirTableSizes& sizes) {
  auto bytes = core::ReadFile(file);
  if (!bytes) return tl::unexpected(bytes.error());
  AirTables<float> tables;
  tables.air = air;
  tables.sizes = sizes;
  tables.transmittance.resize(static_cast<std::size_t>(sizes.transmittance_mu * sizes.transmittance_r));
  tables.scattering.resize(sizes.num_scattering());
  tables.irradiance.resize(static_cast<std::size_t>(sizes.irradiance_mu_s * sizes.irradiance_r));
  std::size_t size = sizeof(Head);
  ForEachTable(tables, [&](void*, std::size_t num) { size += num; });
  const auto damaged = [&](const char* why) {
    return core::Fail(core::ErrorCode::kDamaged, file.string() + ": damaged tables of the air: " + why);
  };
  if (bytes->size() != size) return damaged("wrong length");
  Head head;
  std::memcpy(&head, bytes->data(), sizeof head);
  if (std::memcmp(head.magic, Head{}.magic, sizeof head.magic) != 0) return damaged("wrong magic");
  if (head.key != KeyOf(air, sizes)) return damaged("made from something else");
  const std::uint8_t* next = bytes->data() + sizeof head;
  if (core::Hash64(next, size - sizeof head) != head.checksum) return damaged("the checksum does not match");
  ForEachTable(tables, [&](void* to, std::size_t num) {
    std::memcpy(to, next, num);
    next += num;
  });
  return tables;
}

}  // namespace space
