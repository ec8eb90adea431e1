#include "vps/asset/cooked_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include "core/hash.hpp"
#include "vps/field/pack_facets.hpp"

namespace vps {
namespace {

constexpr std::array<char, 8> kMagic{'V', 'R', 'O', 'O', 'S', 'V', 'P', 'S'};
constexpr std::uint32_t kHasVoxmap = 1;
constexpr std::uint32_t kHasPoints = 2;
constexpr std::uint32_t kHasField = 4;
constexpr std::uint32_t kHasSamples = 8;

struct FileHead {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kCookedFormatVersion;
  std::uint32_t reserved = 0;
  std::uint64_t key = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t payload_hash = 0;
};
static_assert(sizeof(FileHead) == 40);

class ByteWriter {
 public:
  template <class T>
  void Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Append(&value, sizeof(T));
  }
  template <class T>
  void PutArray(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Put<std::uint64_t>(values.size());
    Append(values.data(), values.size() * sizeof(T));
  }
  [[nodiscard]] const std::vector<char>& bytes() const { return bytes_; }

 private:
  void Append(const void* from, std::size_t size) {
    if (size == 0) return;
    bytes_.resize(bytes_.size() + size);
    std::memcpy(bytes_.data() + bytes_.size() - size, from, size);
  }

  std::vector<char> bytes_;
};

// Every read is checked against what is left; after the first failure all reads return zeros.
class ByteReader {
 public:
  ByteReader(const char* bytes, std::size_t size) : next_(bytes), left_(size) {}

  template <class T>
  T Get() {
    T value{};
    if (!Take(sizeof(T))) return value;
    std::memcpy(&value, next_ - sizeof(T), sizeof(T));
    return value;
  }
  template <class T>
  std::vector<T> GetArray() {
    const auto count = Get<std::uint64_t>();
    if (count > left_ / sizeof(T)) {
      is_ok_ = false;
      return {};
    }
    std::vector<T> values(count);
    if (count != 0) std::memcpy(values.data(), next_, count * sizeof(T));
    Take(count * sizeof(T));
    return values;
  }
  [[nodiscard]] bool is_ok() const { return is_ok_; }
  [[nodiscard]] bool is_at_end() const { return left_ == 0; }

 private:
  bool Take(std::size_t size) {
    if (!is_ok_ || size > left_) {
      is_ok_ = false;
      return false;
    }
    next_ += size;
    left_ -= size;
    return true;
  }

  const char* next_;
  std::size_t left_;
  bool is_ok_ = true;
};

void Encode(const SphereTree& tree, ByteWriter* out) {
  out->PutArray(tree.spheres);
  out->Put(tree.level_begin);
  out->Put(tree.num_levels);
}

void Encode(const SampleTree& tree, ByteWriter* out) {
  out->Put(tree.num_points);
  out->Put(tree.area_m2);
  out->Put(tree.centre_m);
  out->Put(tree.radius_m);
  out->PutArray(tree.points);
  Encode(static_cast<const SphereTree&>(tree), out);
  out->Put(tree.usual_m);
  out->Put(tree.reach_m);
}

void Encode(const SurfaceTree& tree, ByteWriter* out) {
  out->PutArray(tree.nodes);
  out->PutArray(tree.families);
  out->PutArray(tree.triangles);
  out->Put(tree.num_roots);
  out->Put(tree.area_m2);
}

std::vector<char> Encode(const CookedObject& object) {
  ByteWriter out;
  out.Put<std::uint32_t>((object.voxmap ? kHasVoxmap : 0) | (object.points ? kHasPoints : 0) |
                         (object.field ? kHasField : 0) | (object.samples ? kHasSamples : 0));
  out.Put(object.bounding_centre_m);
  out.Put(object.bounding_radius_m);
  if (object.voxmap) {
    const Voxmap& map = *object.voxmap;
    out.Put(map.origin_m);
    out.Put(map.voxel_size_m);
    out.Put(map.nx);
    out.Put(map.ny);
    out.Put(map.nz);
    out.Put(map.border_layers);
    out.PutArray(map.layers);
  }
  if (object.points) {
    const PointTree& tree = *object.points;
    out.Put(tree.num_points);
    for (const auto* array : {&tree.x, &tree.y, &tree.z, &tree.nx, &tree.ny, &tree.nz}) out.PutArray(*array);
    out.PutArray(tree.clusters);
  }
  if (object.field) {
    const DistanceField& field = *object.field;
    out.Put(field.origin_m);
    out.Put(field.voxel_size_m);
    for (const std::int32_t n : {field.nx, field.ny, field.nz, field.coarse_shift}) out.Put(n);
    out.PutArray(field.bricks);
    out.PutArray(field.words);
    out.PutArray(field.creases);
    out.PutArray(field.coarse);
    out.PutArray(field.curvatures);
    out.PutArray(field.errors);
    for (const Facets* facets : {&field.facets, &field.surface}) {
      out.PutArray(facets->blocks);
      out.PutArray(facets->spheres);
      out.Put(facets->level_begin);
      out.Put(facets->num_levels);
    }
  }
  if (object.field) {
    const FieldBends& bends = *object.bends;
    for (const auto* array : {&bends.numbers, &bends.begin, &bends.words}) out.PutArray(*array);
    out.PutArray(bends.brick_errors);
    out.PutArray(bends.inner_errors);
  }
  if (object.samples) {
    Encode(*object.samples, &out);
    out.Put(static_cast<std::uint32_t>(object.coarser.size()));
    for (const SampleTree& tree : object.coarser) Encode(tree, &out);
    Encode(*object.surface, &out);
  }
  return out.bytes();
}

bool IsConsistent(const Voxmap& map) {
  if (map.nx <= 0 || map.ny <= 0 || map.nz <= 0 || !(map.voxel_size_m > 0.0)) return false;
  if (map.border_layers < 0 || 2 * map.border_layers >= std::min({map.nx, map.ny, map.nz})) return false;
  return static_cast<std::uint64_t>(map.nx) * static_cast<std::uint64_t>(map.ny) * static_cast<std::uint64_t>(map.nz) ==
         map.layers.size();
}

bool IsConsistent(const PointTree& tree) {
  const std::size_t padded = tree.num_points + PointTree::kPadding;
  for (const auto* array : {&tree.x, &tree.y, &tree.z, &tree.nx, &tree.ny, &tree.nz}) {
    if (array->size() < padded) return false;
  }
  if (tree.num_points == 0 || tree.clusters.empty()) return false;
  for (std::size_t i = 0; i < tree.clusters.size(); ++i) {
    const Cluster& cluster = tree.clusters[i];
    const std::uint64_t end = static_cast<std::uint64_t>(cluster.first_child) + cluster.num_children;
    if (end > (cluster.is_leaf ? tree.num_points : tree.clusters.size())) return false;
    if (!cluster.is_leaf && cluster.first_child <= i) return false;  // breadth-first order: a walk must end
    if (cluster.parent_point >= tree.num_points) return false;
  }
  return true;
}

bool IsConsistent(const Facets& facets) {
  if (facets.num_levels > Facets::kMaxLevels) return false;
  if (facets.num_levels == 0) return facets.blocks.empty() && facets.spheres.empty();
  std::size_t below = facets.blocks.size();
  std::size_t begin = 0;
  for (std::uint32_t level = 0; level < facets.num_levels; ++level) {
    const std::size_t blocks = (below + kFacetLanes - 1) / kFacetLanes;
    if (facets.level_begin[level] != begin || blocks == 0 || begin + blocks > facets.spheres.size()) return false;
    // Unused spheres must be the fillers that no search enters.
    const FacetSpheres& last = facets.spheres[begin + blocks - 1];
    for (std::size_t lane = (below - 1) % kFacetLanes + 1; lane < kFacetLanes; ++lane) {
      if (last.x[lane] != Facets::kFarAway || last.r[lane] != 0.0f) return false;
    }
    begin += blocks;
    below = blocks;
  }
  return below == 1 && begin == facets.spheres.size();
}

// Every index that a kernel follows must be in range.
bool IsConsistent(const DistanceField& field) {
  if (!IsConsistent(field.facets) || !IsConsistent(field.surface)) return false;
  if (field.coarse_shift < 2 || field.coarse_shift > 6 || !(field.voxel_size_m > 0.0)) return false;
  const int step = std::max(DistanceField::kBrick, 1 << field.coarse_shift);
  for (const std::int32_t n : {field.nx, field.ny, field.nz}) {
    if (n <= 0 || n > 4'000'000 || n % step != 0) return false;
  }
  const auto cells = [&](int shift) {
    return static_cast<std::uint64_t>(field.nx >> shift) * static_cast<std::uint64_t>(field.ny >> shift) *
           static_cast<std::uint64_t>(field.nz >> shift);
  };
  if (field.bricks.size() != cells(3) || field.coarse.size() != cells(field.coarse_shift)) return false;
  if (field.curvatures.size() != (cells(3) + 1) / 2 * 2 || field.errors.size() != cells(3)) return false;
  if (field.words.empty() || field.words.size() % DistanceField::kBrickWords != 0) return false;
  for (const std::uint32_t first : field.bricks) {
    if (first % DistanceField::kBrickWords != 0 || first >= field.words.size()) return false;
  }
  const std::size_t num_creases = field.creases.size() / kPlanesPerCrease;
  if (num_creases == 0 || field.creases.size() % kPlanesPerCrease != 0) return false;
  for (const std::uint32_t word : field.words) {
    if (KindOf(word) == CellKind::kCrease && RecordOf(word) >= num_creases) return false;
  }
  return true;
}

bool IsConsistent(const FieldBends& bends, const DistanceField& field) {
  std::size_t num_cells = 0;
  for (std::size_t level = 0; level < bends.begin.size(); ++level) {
    const int edge = 2 << level;
    if (level >= kMostBendLevels || bends.begin[level] != num_cells) return false;
    const glm::ivec3 n = (glm::ivec3(field.nx, field.ny, field.nz) + (edge - 1)) / edge;
    num_cells += static_cast<std::size_t>(n.x) * n.y * n.z;
  }
  if (bends.begin.empty() || bends.numbers.size() != num_cells || bends.words.size() % 4 != 0) return false;
  for (const std::uint32_t number : bends.numbers) {
    if (number > bends.words.size() / 4) return false;
  }
  return bends.brick_errors.size() == field.bricks.size() && bends.inner_errors.size() == field.bricks.size();
}

// Breadth first, so that a walk ends.
bool IsConsistent(const SurfaceTree& tree) {
  if (tree.families.empty() || tree.num_roots == 0 || tree.num_roots > kFamilySize) return false;
  if (tree.num_roots > tree.nodes.size()) return false;
  for (std::size_t i = 0; i < tree.families.size(); ++i) {
    const SurfaceFamily& family = tree.families[i];
    for (std::size_t k = 0; k < kFamilySize; ++k) {
      const bool is_flat = family.of[kIsFlatRow][k] > 0.5f;
      if (family.below[k] >= (is_flat ? tree.triangles.size() : tree.families.size())) return false;
      if (!is_flat && family.below[k] <= i) return false;
    }
  }
  for (const SurfaceNode& node : tree.nodes) {
    const std::uint64_t end = std::uint64_t{node.first} + std::max(node.num_children, 1U);
    if (end > (node.num_children == 0 ? tree.triangles.size() : tree.nodes.size())) return false;
  }
  return true;
}

bool IsConsistent(const SampleTree& tree) {
  if (tree.num_points == 0 || tree.points.size() != (std::size_t{tree.num_points} + kBlock - 1) / kBlock) return false;
  return IsConsistent(tree, tree.points.size());
}

SphereTree DecodeSpheres(ByteReader* in) {
  SphereTree tree;
  tree.spheres = in->GetArray<SphereBlock>();
  tree.level_begin = in->Get<decltype(tree.level_begin)>();
  tree.num_levels = in->Get<std::uint32_t>();
  return tree;
}

SampleTree DecodeSamples(ByteReader* in) {
  SampleTree tree;
  tree.num_points = in->Get<std::uint32_t>();
  tree.area_m2 = in->Get<double>();
  tree.centre_m = in->Get<glm::dvec3>();
  tree.radius_m = in->Get<double>();
  tree.points = in->GetArray<PointBlock>();
  static_cast<SphereTree&>(tree) = DecodeSpheres(in);
  tree.usual_m = in->Get<double>();
  tree.reach_m = in->Get<double>();
  return tree;
}

core::Result<CookedObject> Decode(const std::vector<char>& payload) {
  ByteReader in(payload.data(), payload.size());
  CookedObject object;
  const auto flags = in.Get<std::uint32_t>();
  object.bounding_centre_m = in.Get<glm::dvec3>();
  object.bounding_radius_m = in.Get<double>();
  bool is_consistent = true;
  if (flags & kHasVoxmap) {
    Voxmap map;
    map.origin_m = in.Get<glm::dvec3>();
    map.voxel_size_m = in.Get<double>();
    map.nx = in.Get<std::int32_t>();
    map.ny = in.Get<std::int32_t>();
    map.nz = in.Get<std::int32_t>();
    map.border_layers = in.Get<std::int32_t>();
    map.layers = in.GetArray<std::int8_t>();
    is_consistent = is_consistent && IsConsistent(map);
    object.voxmap = std::move(map);
  }
  if (flags & kHasPoints) {
    PointTree tree;
    tree.num_points = in.Get<std::uint32_t>();
    for (auto* array : {&tree.x, &tree.y, &tree.z, &tree.nx, &tree.ny, &tree.nz}) *array = in.GetArray<float>();
    tree.clusters = in.GetArray<Cluster>();
    is_consistent = is_consistent && IsConsistent(tree);
    object.points = std::move(tree);
  }
  if (flags & kHasField) {
    DistanceField field;
    field.origin_m = in.Get<glm::dvec3>();
    field.voxel_size_m = in.Get<double>();
    for (auto* n : {&field.nx, &field.ny, &field.nz, &field.coarse_shift}) *n = in.Get<std::int32_t>();
    field.bricks = in.GetArray<std::uint32_t>();
    field.words = in.GetArray<std::uint32_t>();
    field.creases = in.GetArray<std::uint32_t>();
    field.coarse = in.GetArray<CoarseCell>();
    field.curvatures = in.GetArray<std::int16_t>();
    field.errors = in.GetArray<std::uint8_t>();
    for (Facets* facets : {&field.facets, &field.surface}) {
      facets->blocks = in.GetArray<FacetBlock>();
      facets->spheres = in.GetArray<FacetSpheres>();
      facets->level_begin = in.Get<decltype(facets->level_begin)>();
      facets->num_levels = in.Get<std::uint32_t>();
    }
    is_consistent = is_consistent && IsConsistent(field);
    if (is_consistent) {
      MakeBoxes(&field.facets);
      MakeBoxes(&field.surface);
    }
    FieldBends bends;
    for (auto* array : {&bends.numbers, &bends.begin, &bends.words}) *array = in.GetArray<std::uint32_t>();
    bends.brick_errors = in.GetArray<float>();
    bends.inner_errors = in.GetArray<float>();
    is_consistent = is_consistent && IsConsistent(bends, field);
    object.field = std::move(field);
    object.bends = std::move(bends);
  }
  if (flags & kHasSamples) {
    object.samples = DecodeSamples(&in);
    const auto num_coarser = in.Get<std::uint32_t>();
    for (std::uint32_t i = 0; i < num_coarser && in.is_ok(); ++i) {
      object.coarser.push_back(DecodeSamples(&in));
      is_consistent = is_consistent && IsConsistent(object.coarser.back());
    }
    SurfaceTree surface;
    surface.nodes = in.GetArray<SurfaceNode>();
    surface.families = in.GetArray<SurfaceFamily>();
    surface.triangles = in.GetArray<SurfacePiece>();
    surface.num_roots = in.Get<std::uint32_t>();
    surface.area_m2 = in.Get<double>();
    is_consistent = is_consistent && IsConsistent(surface);
    object.surface = std::move(surface);
    is_consistent = is_consistent && IsConsistent(*object.samples);
  }
  if (!in.is_ok() || !in.is_at_end() || !is_consistent) {
    return core::Fail(core::ErrorCode::kDamaged, "contents do not fit together");
  }
  object.is_from_cache = true;
  return object;
}

}  // namespace

std::uint64_t CookedKey(const void* mesh_bytes, std::size_t num_bytes, const CookParameters& parameters) {
  std::uint64_t key = core::Hash64(mesh_bytes, num_bytes, kCookedFormatVersion);
  key = core::Hash64(&parameters.voxel_size_m, sizeof parameters.voxel_size_m, key);
  key = core::Hash64(&parameters.num_points, sizeof parameters.num_points, key);
  key = core::Hash64(&parameters.sheet_half_thickness_m, sizeof parameters.sheet_half_thickness_m, key);
  return core::Hash64(&parameters.method, sizeof parameters.method, key);
}

core::Result<void> WriteCookedFile(const std::filesystem::path& file, std::uint64_t key, const CookedObject& object) {
  const std::vector<char> payload = Encode(object);
  FileHead head;
  head.key = key;
  head.payload_bytes = payload.size();
  head.payload_hash = core::Hash64(payload.data(), payload.size());

  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  std::filesystem::path partial = file;
  // Of this write alone: threads and processes may cook the same mesh at the same time.
  static std::atomic<std::uint64_t> num_writes{0};
  partial += "." + std::to_string(getpid()) + "." + std::to_string(num_writes.fetch_add(1)) + ".partial";
  {
    std::ofstream out(partial, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(&head), sizeof head);
    out.write(payload.data(), static_cast<std::streamsize>(payload.size()));
    if (!out.flush()) {
      out.close();
      std::filesystem::remove(partial, error);
      return core::Fail(core::ErrorCode::kIo, partial.string() +
                                                  ": cannot write the cache file. Fix: make the folder writable and "
                                                  "free disk space, or set VR_OOS_CACHE to another folder.");
    }
  }
  std::filesystem::rename(partial, file, error);
  if (!error) return {};
  const std::string why = error.message();
  std::filesystem::remove(partial, error);
  return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot put the cache file in place: " + why);
}

core::Result<CookedObject> ReadCookedFile(const std::filesystem::path& file, std::uint64_t key) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return core::Fail(core::ErrorCode::kNotFound, file.string() + ": no cache file");
  const auto damaged = [&](const char* why) {
    return core::Fail(core::ErrorCode::kDamaged, file.string() + ": damaged cache file: " + why);
  };
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  FileHead head;
  if (error || !in.read(reinterpret_cast<char*>(&head), sizeof head)) return damaged("shorter than its head");
  if (head.magic != kMagic) return damaged("wrong magic");
  if (head.version != kCookedFormatVersion) return damaged("another format version");
  if (head.key != key) return damaged("built from something else");
  if (head.payload_bytes != size - sizeof head) return damaged("wrong length");
  std::vector<char> payload(head.payload_bytes);
  if (!in.read(payload.data(), static_cast<std::streamsize>(payload.size()))) return damaged("cannot be read");
  if (core::Hash64(payload.data(), payload.size()) != head.payload_hash) return damaged("checksum does not match");
  auto object = Decode(payload);
  if (!object) return damaged(object.error().detail.c_str());
  return object;
}

}  // namespace vps
