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

// Two meshes whose contact is measured. A is the field's side, B the sampled one.
struct Parts {
  std::string name;
  vps::TriangleMesh A, B;
  double voxel_size_m = 1e-3;  // of A's field at the middle resolution
};

// Cooked objects of two meshes, built at the first request and then shared by all requests of the same key.
class Structures {
 public:
  struct Key {
    bool is_B = false;
    vps::Method method = vps::Method::kPaper;
    double voxel_size_m = 0.0;     // 0: no field
    std::uint32_t num_points = 0;  // 0: no points
    // Points by EvenSamples instead of SampleSurface's blue noise, which takes a minute for a million points.
    bool is_even = false;
    auto operator<=>(const Key&) const = default;
  };
  using Cooked = core::Result<std::shared_ptr<const vps::CookedObject>>;

  explicit Structures(const Parts& parts) : parts_(parts) {}
  // Thread-safe. Errors: those of vps::Cook.
  Cooked Get(const Key& key);
  // Builds all keys on two threads. Get returns the errors.
  void Prepare(const std::vector<Key>& keys);

 private:
  const Parts& parts_;
  std::mutex mutex_;
  std::map<Key, Cooked> built_;
};

// Quasi-random points of equal areas: point k lies in the triangle in which the area summed in file order reaches
// (k + 1/2) A / n, at the k-th place of Roberts' R2 sequence. Fast for millions of points, but not blue noise.
vps::SurfaceSamples EvenSamples(const vps::TriangleMesh& mesh, std::uint32_t num_points);

}  // namespace contact
