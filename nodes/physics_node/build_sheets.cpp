#include <string>

#include "nodes/physics_node/location_text.hpp"
#include "nodes/physics_node/sheet_keeper.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/field/distance_field.hpp"

namespace physics_node {
namespace {

constexpr double kFinestVoxel_m = 0.001;  // nodes are many millimetres apart; finer voxels only cost memory

// The distance field of a part, as for method `fast`.
class FieldShape final : public physics::ClothShape {
 public:
  explicit FieldShape(vps::CookedObject&& data)
      : ClothShape(data.bounding_centre_m, data.bounding_radius_m), field_(std::move(*data.field)) {}

  double Distance(const glm::dvec3& p_O, glm::dvec3* gradient_O) const override {
    const vps::FieldSample sample = vps::SampleField(field_, glm::vec3((p_O - field_.origin_m) / field_.voxel_size_m));
    const glm::dvec3 gradient(sample.gradient);
    *gradient_O = gradient / glm::length(gradient);
    return field_.voxel_size_m * static_cast<double>(sample.distance);
  }

 private:
  vps::DistanceField field_;
};

}  // namespace

class SheetKeeper::Builder {
 public:
  Builder(SheetKeeper* keeper, const std::vector<physics::MassProperties>& masses, const collision::Options& options,
          core::ParallelFor* workers)
      : keeper_(*keeper), scenario_(keeper->scenario_), masses_(masses), options_(options), workers_(workers) {
    shapes_.resize(scenario_.objects.size());
  }

  core::Result<void> Build() {
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
      if (!scenario_.objects[i].sheet) continue;
      if (auto added = AddSheet(i); !added) return added;
    }
    return {};
  }

 private:
  core::Result<void> AddSheet(std::size_t index) {
    const scene::Object& object = scenario_.objects[index];
    const scene::Sheet& given = *object.sheet;
    const auto fail = [&](const core::Error& error) {
      return core::Fail(error.code, LocationPrefix(given.location) + "sheet of '" + object.name + "': " + error.detail);
    };
    physics::ClothParams params;
    params.size_x_m = given.size_x_m;
    params.size_y_m = given.size_y_m;
    params.cells_x = given.cells_x;
    params.cells_y = given.cells_y;
    params.X_WS = object.X_WO * given.X_OS;
    params.density_kg_per_m2 = given.density_kg_per_m2;
    params.stretch_stiffness_N_per_m = given.stretch_stiffness_N_per_m;
    params.bending_stiffness_Nm = given.bending_stiffness_Nm;
    params.damping_per_s = given.damping_per_s;
    params.thickness_m = given.thickness_m;
    params.friction = given.friction;
    params.acceleration_W = scenario_.gravity_m_per_s2;
    auto cloth = physics::Cloth::Create(params);
    if (!cloth) return fail(cloth.error());

    Sheet sheet;
    sheet.object = static_cast<int>(index);
    sheet.params = &given;
    sheet.cloth = std::move(*cloth);
    sheet.is_active = given.is_active;
    for (const glm::dvec3& p : sheet.cloth->positions_W()) sheet.p_W.emplace_back(p);
    sheet.ground = *sheet.cloth->AddBody({});
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
      const auto body = AddBody(i, index, sheet.cloth.get());
      if (!body) return fail(body.error());
      sheet.body_of_object.push_back(*body);
    }
    if (auto sewn = Sew(object, given, &sheet); !sewn) return fail(sewn.error());
    if (auto hooked = AddHooks(index, &sheet); !hooked) return hooked;
    keeper_.sheets_.push_back(std::move(sheet));
    return {};
  }

  // Adds every object that the sheet can touch, and the one that it is sewn to. Members of the object's group do not
  // touch the sheet.
  core::Result<int> AddBody(std::size_t index, std::size_t sheet_object, physics::Cloth* cloth) {
    const scene::Object& object = scenario_.objects[index];
    const bool touches = object.group != scenario_.objects[sheet_object].group && !object.collision_mesh.empty();
    if (!touches && index != sheet_object && object.owner != scene::Owner::kHand) return kNone;
    physics::ClothBodyParams params;
    params.X_WO = object.X_WO;
    if (object.owner == scene::Owner::kPhysics) {
      params.kind = physics::BodyKind::kDynamic;
      params.mass = masses_[index];
    } else if (object.owner == scene::Owner::kHand) {
      params.kind = physics::BodyKind::kKinematic;
    }
    if (touches) {
      auto shape = ShapeOf(index);
      if (!shape) return core::Fail(shape.error().code, shape.error().detail);
      params.shape = *shape;
    }
    return cloth->AddBody(params);
  }

  core::Result<std::shared_ptr<const physics::ClothShape>> ShapeOf(std::size_t index) {
    if (shapes_[index] != nullptr) return shapes_[index];
    const scene::Object& object = scenario_.objects[index];
    vps::CookParameters parameters;
    parameters.method = vps::Method::kFast;
    parameters.voxel_size_m = std::max(object.voxel_size_m, kFinestVoxel_m);
    parameters.sheet_half_thickness_m = 0.5 * object.sheet_thickness_m;
    auto cooked = vps::Cook(object.collision_mesh, parameters, options_.cache, {}, workers_);
    if (!cooked) return core::Fail(cooked.error().code, "field of '" + object.name + "': " + cooked.error().detail);
    if (options_.progress) options_.progress("field of " + object.name + " for sheets");
    shapes_[index] = std::make_shared<FieldShape>(std::move(*cooked));
    return shapes_[index];
  }

  // Bonds the nodes inside the seam to the object.
  core::Result<void> Sew(const scene::Object& object, const scene::Sheet& given, Sheet* sheet) {
    const core::Pose X_SW = (object.X_WO * given.X_OS).inverse();
    const glm::dvec3 middle_S = X_SW * object.X_WO.translation;
    std::vector<glm::dvec3> points_W;
    for (const glm::dvec3& p_W : sheet->cloth->positions_W()) {
      const glm::dvec3 d = glm::abs(X_SW * p_W - middle_S);
      if (d.x <= 0.5 * given.seam_x_m && d.y <= 0.5 * given.seam_y_m) points_W.push_back(p_W);
    }
    if (points_W.size() < 3) {
      return core::Fail(
          core::ErrorCode::kInvalidInput,
          std::to_string(points_W.size()) +
              " nodes are inside its seam, which needs three; move the sheet under the object's origin or "
              "give a larger seam_size_m");
    }
    const auto count = static_cast<double>(points_W.size());
    const int body = sheet->body_of_object[static_cast<std::size_t>(sheet->object)];
    const auto bond = sheet->cloth->AddBond(
        {body, given.seam_stiffness_N_per_m / count, given.seam_damping_N_s_per_m / count}, points_W);
    if (!bond) return core::Fail(bond.error().code, bond.error().detail);
    return {};
  }

  core::Result<void> AddHooks(std::size_t object, Sheet* sheet) {
    for (std::size_t i = 0; i < scenario_.mechanisms.size(); ++i) {
      const scene::Mechanism& m = scenario_.mechanisms[i];
      if (m.kind != scene::MechanismKind::kHookAndLoop || m.child != static_cast<int>(object)) continue;
      const core::Pose X_WP = m.parent < 0 ? core::Pose{} : scenario_.objects[static_cast<std::size_t>(m.parent)].X_WO;
      std::vector<glm::dvec3> points_W;
      for (const glm::dvec3& p_P : m.patches_m) points_W.push_back(X_WP * p_P);
      int body = m.parent < 0 ? kNone : sheet->body_of_object[static_cast<std::size_t>(m.parent)];
      if (body == kNone) body = sheet->ground;
      const auto bond = sheet->cloth->AddBond({body, m.stiffness_N_per_m, m.damping, m.release_force_N}, points_W);
      if (!bond) {
        return core::Fail(bond.error().code,
                          LocationPrefix(m.location) + "mechanism '" + m.name + "': " + bond.error().detail);
      }
      sheet->hooks.push_back({i, *bond, keeper_.built_->sheet_hooks[i], m.release_force_N});
    }
    return {};
  }

  SheetKeeper& keeper_;
  const scene::Scenario& scenario_;
  const std::vector<physics::MassProperties>& masses_;
  const collision::Options& options_;
  core::ParallelFor* workers_;
  std::vector<std::shared_ptr<const physics::ClothShape>> shapes_;
};

core::Result<std::unique_ptr<SheetKeeper>> SheetKeeper::Create(
    const scene::Scenario& scenario, const std::vector<physics::MassProperties>& mass_of_object, BuiltWorld* built,
    const collision::Options& options, core::ParallelFor* workers) {
  std::unique_ptr<SheetKeeper> keeper(new SheetKeeper(scenario, built));
  if (auto made = Builder(keeper.get(), mass_of_object, options, workers).Build(); !made) {
    return core::Fail(made.error().code, made.error().detail);
  }
  return keeper;
}

}  // namespace physics_node
