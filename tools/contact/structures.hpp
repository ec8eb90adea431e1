#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/sampling/surface_samples.hpp"

namespace contact {

// Two meshes that are held against each other.
struct Parts {
  std::string name;
  vps::TriangleMesh A, B;
  double voxel_size_m = 1e-3;  // of A's field, in the middle of the sweep
};

// What collision needs of two meshes, built when first asked for, then shared by all who ask for the same.
class Structures {
 public:
  struct Key {
    bool is_B = false;
    vps::Method method = vps::Method::kPaper;
    double voxel_size_m = 0.0;     // 0: no field
    std::uint32_t num_points = 0;  // 0: no points
    // Points by EvenSamples instead of the product's blue noise, which takes a minute for a million.
    bool is_even = false;
    auto operator<=>(const Key&) const = default;
  };
  using Cooked = core::Result<std::shared_ptr<const vps::CookedObject>>;

  explicit Structures(const Parts& parts) : parts_(parts) {}
  // Any thread.
  Cooked Get(const Key& key);
  // Builds all of them on two threads; what fails is told by Get.
  void Prepare(const std::vector<Key>& keys);

 private:
  const Parts& parts_;
  std::mutex mutex_;
  std::map<Key, Cooked> built_;
};

// Points at even steps of area through the triangles in file order, at low-discrepancy places in each, of equal areas:
// quick for millions, but without blue noise.
vps::SurfaceSamples EvenSamples(const vps::TriangleMesh& mesh, std::uint32_t num_points);

}  // namespace contact
