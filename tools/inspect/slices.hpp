#pragma once

#include <functional>
#include <string>

#include "core/result.hpp"
#include "picture/image.hpp"
#include "vps/asset/cooked_object.hpp"

namespace inspect {

// What a field says of a place in the mesh frame.
struct FieldPlace {
  double distance_m = 0.0;  // negative inside
  bool is_crease = false;   // the cell holds several tangent planes
  bool is_fine = true;      // a voxel answers, not the coarse grid
  glm::ivec3 voxel{0};
};

// Either field behind one face.
struct FieldView {
  std::string title;
  double voxel_size_m = 0.0;
  vps::Box box;  // of the grid
  std::function<FieldPlace(const glm::dvec3& p_m)> at;
};
FieldView ViewOf(const vps::DistanceField& field);
FieldView ViewOf(const vps::Voxmap& map);  // distance: V with its sign turned, in steps of a voxel

// A place to look at closely, and the direction across the surface there.
struct CloseUp {
  glm::dvec3 centre_m{0.0};
  glm::dvec3 across{0.0, 0.0, 1.0};
};

// Three slices through the middle of the box along the axes, and a close-up in the plane that cuts the surface there
// most squarely: distance in colour with iso-lines, the surface bold, crease cells and brick borders.
core::Result<picture::Image> DrawSlices(const FieldView& field, const vps::Box& box, const CloseUp& close_up);

}  // namespace inspect
