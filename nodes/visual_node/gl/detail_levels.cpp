#include "nodes/visual_node/gl/detail_levels.hpp"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
// After the mesh, as it does not include what it needs.
#include <OpenMesh/Core/Geometry/QuadricT.hh>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "nodes/visual_node/gl/welded_mesh.hpp"
#include "vps/mesh/box_tree.hpp"
#include "vps/mesh/nearest_on_triangle.hpp"

namespace visual_node {
namespace {

// What one collapse may leave of a level's triangles, at most, for the next level to be worth its memory.
constexpr double kNextLevel = 0.75;
constexpr double kWantedShare = 0.5;  // what the collapses for the next level aim at

// Less than a right angle, so that no triangle becomes a line: a line's normal could turn anywhere with the next
// collapse.
constexpr double kMostTurn_deg = 75.0;

bool IsTrue(const std::atomic<bool>* flag) {
  return flag != nullptr && flag->load(std::memory_order_relaxed);
}

// Normals within 15 degrees look alike.
constexpr float kAlike = 0.966f;

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Quadric = OpenMesh::Geometry::Quadricd;

// A vertex of a primitive, at a corner of a face.
struct Corner {
  std::uint32_t primitive = 0;
  std::uint32_t vertex = 0;
  bool operator==(const Corner&) const = default;
};
// Of a face of the mesh: which corner is at which of its places.
struct Corners {
  std::array<Mesh::VertexHandle, 3> place;
  std::array<Corner, 3> corner;
  Corner& At(Mesh::VertexHandle v) { return corner[place[0] == v ? 0 : place[1] == v ? 1 : 2]; }
};
using CornersOfFaces = OpenMesh::FPropHandleT<Corners>;

// When a place v0 moves to its neighbour v1, its corners move too. A corner that meets one of v1 at the edge between
// them becomes that one, if their normals are alike; any other takes its normal along, so that what was flat still
// looks flat when the bevel beside it is gone. A texture's place cannot be taken along: such a collapse is refused.
template <typename MeshT>
class KeepCorners : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(KeepCorners, MeshT, KeepCorners);
  KeepCorners(MeshT& mesh) : Base(mesh, true) {}
  void Use(CornersOfFaces corners, const vps::VisualMesh* visual) {
    corners_ = corners;
    visual_ = visual;
  }

  float collapse_priority(const CollapseInfo& info) override {
    const MovesOfCorners moves = Moves(info);
    for (const auto face : Base::mesh().vf_range(info.v0)) {
      if (face == info.fl || face == info.fr) continue;
      const Corner& corner = Base::mesh().property(corners_, face).At(info.v0);
      if (!HasMaterial(moves, corner.primitive)) return Base::ILLEGAL_COLLAPSE;
      if (!IsTextured(corner)) continue;
      const int move = Find(moves, corner);
      if (move < 0) return Base::ILLEGAL_COLLAPSE;
      if (moves.num == 2 && moves.from[0] == moves.from[1] && !(moves.to[0] == moves.to[1]))
        return Base::ILLEGAL_COLLAPSE;
    }
    return Base::LEGAL_COLLAPSE;
  }

  void preprocess_collapse(const CollapseInfo& info) override {
    const MovesOfCorners moves = Moves(info);
    for (const auto face : Base::mesh().vf_range(info.v0)) {
      if (face == info.fl || face == info.fr) continue;
      Corners& corners = Base::mesh().property(corners_, face);
      Corner& corner = corners.At(info.v0);
      const int move = Find(moves, corner);
      if (move >= 0 && (IsTextured(corner) || AreAlike(corner, moves.to[move]))) corner = moves.to[move];
      *std::find(corners.place.begin(), corners.place.end(), info.v0) = info.v1;
    }
  }

 private:
  struct MovesOfCorners {
    int num = 0;
    std::array<Corner, 2> from, to;
  };
  // Where two materials meet, a place moves along the line between them.
  static bool HasMaterial(const MovesOfCorners& moves, std::uint32_t primitive) {
    return std::any_of(moves.from.begin(), moves.from.begin() + moves.num,
                       [&](const Corner& corner) { return corner.primitive == primitive; });
  }
  static int Find(const MovesOfCorners& moves, const Corner& corner) {
    for (int i = 0; i < moves.num; ++i) {
      if (moves.from[i] == corner && moves.to[i].primitive == corner.primitive) return i;
    }
    return -1;
  }
  MovesOfCorners Moves(const CollapseInfo& info) {
    MovesOfCorners moves;
    for (const auto face : {info.fl, info.fr}) {
      if (!face.is_valid()) continue;
      Corners& corners = Base::mesh().property(corners_, face);
      moves.from[moves.num] = corners.At(info.v0);
      moves.to[moves.num++] = corners.At(info.v1);
    }
    return moves;
  }
  [[nodiscard]] bool IsTextured(const Corner& corner) const {
    const vps::VisualPrimitive& primitive = visual_->primitives[corner.primitive];
    return primitive.base_texture >= 0 || primitive.surface_texture >= 0 || primitive.normal_texture >= 0 ||
           primitive.emissive_texture >= 0 || !primitive.variants.empty();
  }
  [[nodiscard]] bool AreAlike(const Corner& a, const Corner& b) const {
    return glm::dot(visual_->primitives[a.primitive].normals[a.vertex],
                    visual_->primitives[b.primitive].normals[b.vertex]) > kAlike;
  }

  CornersOfFaces corners_;
  const vps::VisualMesh* visual_ = nullptr;
};

// The mean square of a place's distance from the planes of the faces that it stands for, and from planes through the
// edges at which a surface or one of its materials ends, at right angles to it.
template <typename MeshT>
class SurfaceError : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(SurfaceError, MeshT, SurfaceError);
  SurfaceError(MeshT& mesh) : Base(mesh, false) {
    mesh.add_property(quadrics_);
    mesh.add_property(lines_);
  }
  ~SurfaceError() override {
    Base::mesh().remove_property(quadrics_);
    Base::mesh().remove_property(lines_);
  }
  void Use(CornersOfFaces corners) { corners_ = corners; }

  void initialize() override {
    MeshT& mesh = Base::mesh();
    for (const auto v : mesh.vertices()) {
      mesh.property(quadrics_, v).clear();
      mesh.property(lines_, v).clear();
    }
    for (const auto face : mesh.faces()) {
      for (const auto v : mesh.fv_range(face)) Add(v, mesh.calc_face_normal(face), mesh.point(v));
      for (const auto edge : mesh.fh_range(face)) {
        if (!IsKept(edge)) continue;
        const auto a = mesh.from_vertex_handle(edge), b = mesh.to_vertex_handle(edge);
        const auto along = mesh.point(b) - mesh.point(a);
        const auto across = OpenMesh::cross(along, mesh.calc_face_normal(face));
        if (across.norm() <= 0.0) continue;
        for (const auto v : {a, b}) {
          Add(v, across.normalized(), mesh.point(a));
          mesh.property(lines_, v) += Quadric(across.normalized(), mesh.point(a));
        }
      }
    }
  }
  float collapse_priority(const CollapseInfo& info) override {
    Quadric sum = Base::mesh().property(quadrics_, info.v0);
    sum += Base::mesh().property(quadrics_, info.v1);
    return static_cast<float>(std::max(0.0, sum(info.p1)));
  }
  void postprocess_collapse(const CollapseInfo& info) override {
    Base::mesh().property(quadrics_, info.v1) += Base::mesh().property(quadrics_, info.v0);
    Quadric& lines = Base::mesh().property(lines_, info.v1);
    lines += Base::mesh().property(lines_, info.v0);
    line_error2_ = std::max(line_error2_, lines(info.p1));
  }
  // At most so far, a line at which a surface or a material ends is off its place.
  [[nodiscard]] double line_error_m() const { return std::sqrt(line_error2_); }

 private:
  void Add(Mesh::VertexHandle v, const OpenMesh::Vec3d& normal, const OpenMesh::Vec3d& p) {
    Base::mesh().property(quadrics_, v) += Quadric(normal, p);
  }
  bool IsKept(Mesh::HalfedgeHandle edge) {
    MeshT& mesh = Base::mesh();
    const auto other = mesh.opposite_face_handle(edge);
    if (!other.is_valid()) return true;
    Corners& here = mesh.property(corners_, mesh.face_handle(edge));
    Corners& there = mesh.property(corners_, other);
    for (const auto v : {mesh.from_vertex_handle(edge), mesh.to_vertex_handle(edge)}) {
      if (here.At(v).primitive != there.At(v).primitive) return true;
    }
    return false;
  }

  CornersOfFaces corners_;
  OpenMesh::VPropHandleT<Quadric> quadrics_;
  OpenMesh::VPropHandleT<Quadric> lines_;
  double line_error2_ = 0.0;
};

// The triangles of one connected part.
struct Part {
  std::vector<std::array<std::uint32_t, 3>> triangles;  // of places
  std::vector<std::array<Corner, 3>> corners;
};

// Gives each pair of a corner and a place a vertex: the corner's own, or a new one at that place.
class Vertices {
 public:
  explicit Vertices(vps::VisualMesh* mesh) : mesh_(mesh) {}

  std::uint32_t At(const Corner& corner, const glm::vec3& place) {
    vps::VisualPrimitive& primitive = mesh_->primitives[corner.primitive];
    if (primitive.positions[corner.vertex] == place) return corner.vertex;
    const auto [it, is_new] = moved_.try_emplace({corner.primitive, corner.vertex, place.x, place.y, place.z},
                                                 static_cast<std::uint32_t>(primitive.positions.size()));
    if (is_new) {
      primitive.positions.push_back(place);
      primitive.normals.push_back(glm::vec3(primitive.normals[corner.vertex]));
      if (!primitive.uvs.empty()) primitive.uvs.push_back(glm::vec2(primitive.uvs[corner.vertex]));
    }
    return it->second;
  }
  [[nodiscard]] const vps::VisualMesh* mesh() const { return mesh_; }

 private:
  vps::VisualMesh* mesh_;
  std::map<std::tuple<std::uint32_t, std::uint32_t, float, float, float>, std::uint32_t> moved_;
};

double DistanceTo(const vps::TriangleMesh& mesh, const vps::BoxTree& tree, const glm::dvec3& p, double first_reach_m,
                  double most_m) {
  double nearest = most_m;
  for (double reach_m = std::min(first_reach_m, most_m);; reach_m = std::min(2.0 * reach_m, most_m)) {
    vps::ForOverlapping(tree, {p - reach_m, p + reach_m}, [&](std::uint32_t triangle) {
      const auto& [a, b, c] = mesh.triangles[triangle];
      const glm::dvec3 pa = mesh.vertices[a] - p, pb = mesh.vertices[b] - p, pc = mesh.vertices[c] - p;
      nearest = std::min(nearest, glm::length(vps::NearestOnTriangle(pa, pb, pc, glm::cross(pb - pa, pc - pa)).place));
    });
    if (nearest <= reach_m || reach_m >= most_m) return nearest;
  }
}

class Decimation {
 public:
  // `is_good`: false for a part whose triangles are no surface: three at an edge, or two that only share a corner.
  Decimation(const WeldedMesh& welded, const Part& part) : part_(part) {
    mesh_.request_vertex_status();
    mesh_.request_edge_status();
    mesh_.request_face_status();
    mesh_.request_face_normals();
    mesh_.add_property(corners_);
    std::map<std::uint32_t, Mesh::VertexHandle> handles;
    for (std::size_t i = 0; i < part.triangles.size() && is_good_; ++i) {
      Corners corners;
      corners.corner = part.corners[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [it, is_new] = handles.try_emplace(part.triangles[i][k]);
        const glm::dvec3& p = welded.places[part.triangles[i][k]];
        if (is_new) it->second = mesh_.add_vertex({p.x, p.y, p.z});
        corners.place[k] = it->second;
      }
      const auto& [a, b, c] = corners.place;
      if (a == b || b == c || c == a) continue;  // without area
      const auto face = mesh_.add_face(a, b, c);
      is_good_ = face.is_valid();
      if (is_good_) mesh_.property(corners_, face) = corners;
    }
  }

  // The next levels behind `levels`, which has the whole part.
  void AddLevels(double radius_m, const std::atomic<bool>* is_stop_wanted, Vertices* vertices,
                 std::vector<Piece::Level>* levels) {
    if (!is_good_) return;
    mesh_.update_face_normals();
    OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh_);
    OpenMesh::Decimater::ModHandleT<KeepCorners<Mesh>> keep_corners;
    OpenMesh::Decimater::ModHandleT<SurfaceError<Mesh>> error;
    OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle no_flips;
    decimater.add(keep_corners);
    decimater.add(no_flips);
    decimater.add(error);
    decimater.module(keep_corners).Use(corners_, vertices->mesh());
    decimater.module(no_flips).set_max_normal_deviation(kMostTurn_deg);
    decimater.module(error).Use(corners_);
    if (!decimater.initialize()) return;
    std::size_t num_faces = mesh_.n_faces(), last = num_faces;
    while (num_faces > 1 && !IsTrue(is_stop_wanted)) {
      // OpenMesh counts from the faces that there were before any collapse.
      const auto fewer = static_cast<std::size_t>((1.0 - kWantedShare) * static_cast<double>(last));
      decimater.decimate_to_faces(0, mesh_.n_faces() - fewer);
      const auto left = mesh_.faces();
      num_faces = static_cast<std::size_t>(std::distance(left.begin(), left.end()));
      if (static_cast<double>(num_faces) > kNextLevel * static_cast<double>(last)) return;
      last = num_faces;
      levels->push_back(LevelNow(
          radius_m, std::max<double>(levels->back().error_m, decimater.module(error).line_error_m()), vertices));
    }
  }

 private:
  Piece::Level LevelNow(double radius_m, double least_error_m, Vertices* vertices) {
    Piece::Level level;
    level.indices.resize(vertices->mesh()->primitives.size());
    vps::TriangleMesh surface;
    for (const auto v : mesh_.all_vertices()) {
      const auto& p = mesh_.point(v);
      surface.vertices.emplace_back(p[0], p[1], p[2]);
    }
    for (const auto face : mesh_.faces()) {
      const Corners& its = mesh_.property(corners_, face);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = mesh_.point(its.place[k]);
        const Corner& corner = its.corner[k];
        level.indices[corner.primitive].push_back(vertices->At(corner, glm::vec3(glm::dvec3(p[0], p[1], p[2]))));
      }
      surface.triangles.push_back({static_cast<std::uint32_t>(its.place[0].idx()),
                                   static_cast<std::uint32_t>(its.place[1].idx()),
                                   static_cast<std::uint32_t>(its.place[2].idx())});
    }
    const vps::BoxTree tree = vps::BuildBoxTree(surface);
    double error_m = least_error_m;
    for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
      if (!mesh_.status(Mesh::VertexHandle(static_cast<int>(i))).deleted()) continue;
      error_m =
          std::max(error_m, DistanceTo(surface, tree, surface.vertices[i], error_m + 0.02 * radius_m, 2.0 * radius_m));
    }
    level.error_m = static_cast<float>(error_m);
    return level;
  }

  const Part& part_;
  Mesh mesh_;
  CornersOfFaces corners_;
  bool is_good_ = true;
};

}  // namespace

std::vector<Piece> MakePieces(vps::VisualMesh* mesh_to_extend, const std::atomic<bool>* is_stop_wanted) {
  vps::VisualMesh& mesh = *mesh_to_extend;
  omerr().disable();  // what is no surface stays whole, and needs no message on the terminal
  const WeldedMesh welded = Weld(mesh);
  const std::vector<std::uint32_t> part_of = ConnectedParts(welded);
  std::map<std::uint32_t, Part> parts;
  std::size_t triangle = 0;
  for (std::uint32_t k = 0; k < mesh.primitives.size(); ++k) {
    const std::vector<std::uint32_t>& indices = mesh.primitives[k].indices;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3, ++triangle) {
      Part& part = parts[part_of[welded.triangles[triangle][0]]];
      part.triangles.push_back(welded.triangles[triangle]);
      part.corners.push_back({Corner{k, indices[i]}, Corner{k, indices[i + 1]}, Corner{k, indices[i + 2]}});
    }
  }
  std::vector<Piece> pieces;
  Vertices vertices(&mesh);
  for (const auto& [place, part] : parts) {
    if (IsTrue(is_stop_wanted)) break;
    Piece& piece = pieces.emplace_back();
    glm::dvec3 low = welded.places[place], high = low;
    for (const auto& corners : part.triangles) {
      for (const std::uint32_t corner : corners) {
        low = glm::min(low, welded.places[corner]);
        high = glm::max(high, welded.places[corner]);
      }
    }
    const glm::dvec3 centre = 0.5 * (low + high);
    double radius_m = 0.0;
    for (const auto& corners : part.triangles) {
      for (const std::uint32_t corner : corners)
        radius_m = std::max(radius_m, glm::distance(centre, welded.places[corner]));
    }
    piece.centre_M = glm::vec3(centre);
    piece.radius_m = static_cast<float>(radius_m);
    std::vector<std::vector<std::uint32_t>> whole(mesh.primitives.size());
    for (const auto& corners : part.corners) {
      for (const Corner& corner : corners) whole[corner.primitive].push_back(corner.vertex);
    }
    piece.levels.push_back({0.0f, std::move(whole)});
    Decimation(welded, part).AddLevels(radius_m, is_stop_wanted, &vertices, &piece.levels);
    piece.levels.push_back({std::max(piece.levels.back().error_m, 2.0f * piece.radius_m),
                            std::vector<std::vector<std::uint32_t>>(mesh.primitives.size())});
  }
  return pieces;
}

}  // namespace visual_node
