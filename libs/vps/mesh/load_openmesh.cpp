#include "vps/mesh/load_openmesh.hpp"

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Utils/color_cast.hh>
#include <mutex>

#include "vps/mesh/check_text.hpp"

namespace vps {
namespace {

// Receives what OpenMesh's readers parse. A half-edge mesh would refuse non-manifold files, which voxelise perfectly
// well, so the triangles are taken as a plain list. Attributes other than positions are ignored.
class TriangleImporter final : public OpenMesh::IO::BaseImporter {
 public:
  using Vh = OpenMesh::VertexHandle;
  using Hh = OpenMesh::HalfedgeHandle;
  using Eh = OpenMesh::EdgeHandle;
  using Fh = OpenMesh::FaceHandle;
  using Status = OpenMesh::Attributes::StatusInfo;

  explicit TriangleImporter(double scale) : scale_(scale) {}

  Vh add_vertex(const OpenMesh::Vec3f& p) override { return AddVertex({p[0], p[1], p[2]}); }
  Vh add_vertex(const OpenMesh::Vec3d& p) override { return AddVertex({p[0], p[1], p[2]}); }
  Vh add_vertex() override { return AddVertex({0.0, 0.0, 0.0}); }
  Hh add_edge(Vh, Vh) override { return Hh(); }
  Fh add_face(const VHandles& corners) override {
    for (const Vh v : corners) {
      if (v.idx() < 0 || static_cast<std::size_t>(v.idx()) >= mesh.vertices.size()) {
        has_bad_index = true;
        return Fh();
      }
    }
    for (std::size_t k = 2; k < corners.size(); ++k) {
      mesh.triangles.push_back({static_cast<std::uint32_t>(corners[0].idx()),
                                static_cast<std::uint32_t>(corners[k - 1].idx()),
                                static_cast<std::uint32_t>(corners[k].idx())});
    }
    return Fh(num_faces_++);
  }
  Fh add_face(Hh) override { return Fh(); }
  void set_point(Vh v, const OpenMesh::Vec3f& p) override {
    mesh.vertices[static_cast<std::size_t>(v.idx())] = scale_ * glm::dvec3(p[0], p[1], p[2]);
  }
  std::size_t n_vertices() const override { return mesh.vertices.size(); }
  std::size_t n_faces() const override { return static_cast<std::size_t>(num_faces_); }
  std::size_t n_edges() const override { return 0; }

  void add_face_texcoords(Fh, Vh, const std::vector<OpenMesh::Vec2f>&) override {}
  void add_face_texcoords(Fh, Vh, const std::vector<OpenMesh::Vec3f>&) override {}
  void set_face_texindex(Fh, int) override {}
  void set_halfedge(Vh, Hh) override {}
  void set_normal(Vh, const OpenMesh::Vec3f&) override {}
  void set_normal(Vh, const OpenMesh::Vec3d&) override {}
  void set_color(Vh, const OpenMesh::Vec3uc&) override {}
  void set_color(Vh, const OpenMesh::Vec4uc&) override {}
  void set_color(Vh, const OpenMesh::Vec3f&) override {}
  void set_color(Vh, const OpenMesh::Vec4f&) override {}
  void set_texcoord(Vh, const OpenMesh::Vec2f&) override {}
  void set_status(Vh, const Status&) override {}
  void set_next(Hh, Hh) override {}
  void set_face(Hh, Fh) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(Hh, const OpenMesh::Vec2f&) override {}
  void set_texcoord(Vh, const OpenMesh::Vec3f&) override {}
  void set_texcoord(Hh, const OpenMesh::Vec3f&) override {}
  void set_status(Hh, const Status&) override {}
  void set_color(Eh, const OpenMesh::Vec3uc&) override {}
  void set_color(Eh, const OpenMesh::Vec4uc&) override {}
  void set_color(Eh, const OpenMesh::Vec3f&) override {}
  void set_color(Eh, const OpenMesh::Vec4f&) override {}
  void set_status(Eh, const Status&) override {}
  void set_normal(Fh, const OpenMesh::Vec3f&) override {}
  void set_normal(Fh, const OpenMesh::Vec3d&) override {}
  void set_color(Fh, const OpenMesh::Vec3uc&) override {}
  void set_color(Fh, const OpenMesh::Vec4uc&) override {}
  void set_color(Fh, const OpenMesh::Vec3f&) override {}
  void set_color(Fh, const OpenMesh::Vec4f&) override {}
  void set_status(Fh, const Status&) override {}
  void add_texture_information(int, std::string) override {}

  TriangleMesh mesh;
  bool has_bad_index = false;

 private:
  Vh AddVertex(const glm::dvec3& p) {
    mesh.vertices.push_back(scale_ * p);
    return Vh(static_cast<int>(mesh.vertices.size()) - 1);
  }

  double scale_;
  int num_faces_ = 0;
};

// OpenMesh has one reader for each format, which keeps the file's folder and materials while it reads.
std::mutex open_mesh_readers;

}  // namespace

core::Result<TriangleMesh> LoadOpenMeshTriangles(const std::filesystem::path& file, double scale) {
  if (const auto good = CheckTextNumbers(file); !good) return tl::unexpected(good.error());
  const std::lock_guard only_one(open_mesh_readers);
  omlog().disable();  // OpenMesh reports on the standard streams; here an error is returned instead
  omout().disable();
  omerr().disable();
  TriangleImporter importer(scale);
  OpenMesh::IO::Options options;
  if (!OpenMesh::IO::IOManager().read(file.string(), importer, options)) {
    return core::Fail(core::ErrorCode::kDamaged, file.string() + ": cannot be read as " + file.extension().string() +
                                                     "; export it again, or use glTF");
  }
  if (importer.has_bad_index) {
    return core::Fail(core::ErrorCode::kDamaged, file.string() + ": a face names a vertex that does not exist");
  }
  return std::move(importer.mesh);
}

}  // namespace vps
