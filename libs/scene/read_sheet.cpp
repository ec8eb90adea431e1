#include <algorithm>
#include <glm/gtc/constants.hpp>

#include "core/messages/physics.hpp"
#include "scene/read_scenario.hpp"
#include "scene/schema.hpp"

namespace scene {
namespace {

class SheetReader {
 public:
  SheetReader(const XmlElement& element, const Object& object, const std::filesystem::path& file,
              std::vector<Diagnostic>* diagnostics)
      : element_(element), object_(object), file_(file), diagnostics_(diagnostics) {}

  Sheet Read() {
    Sheet sheet;
    sheet.location = {file_, element_.line};
    glm::dvec3 rpy_deg(0.0);
    Vector("position", &sheet.X_OS.translation);
    Vector("rpy_deg", &rpy_deg);
    sheet.X_OS.rotation = core::QuaternionFromRollPitchYaw(rpy_deg * (glm::pi<double>() / 180.0));
    double cells_x = 0.0;
    double cells_y = 0.0;
    ReadTwoPositive("size_m", &sheet.size_x_m, &sheet.size_y_m);
    ReadTwoPositive("cells", &cells_x, &cells_y);
    ReadTwoPositive("seam_size_m", &sheet.seam_x_m, &sheet.seam_y_m);
    sheet.cells_x = static_cast<int>(std::clamp(cells_x, 0.0, 1e4));
    sheet.cells_y = static_cast<int>(std::clamp(cells_y, 0.0, 1e4));
    Number("density_kg_per_m2", &sheet.density_kg_per_m2);
    Number("stretch_stiffness_N_per_m", &sheet.stretch_stiffness_N_per_m);
    Number("bending_stiffness_Nm", &sheet.bending_stiffness_Nm);
    Number("thickness_m", &sheet.thickness_m);
    Number("friction", &sheet.friction);
    Number("damping_per_s", &sheet.damping_per_s);
    Number("seam_stiffness_N_per_m", &sheet.seam_stiffness_N_per_m);
    Number("seam_damping_N_s_per_m", &sheet.seam_damping_N_s_per_m);
    Number("grip_stiffness_N_per_m", &sheet.grip_stiffness_N_per_m);
    Number("grip_damping_N_s_per_m", &sheet.grip_damping_N_s_per_m);
    sheet.material.is_given = true;
    double metallic = sheet.material.metallic;
    double roughness = sheet.material.roughness;
    Vector("base_color", &sheet.material.base_color);
    Number("metallic", &metallic);
    Number("roughness", &roughness);
    sheet.material.metallic = static_cast<float>(metallic);
    sheet.material.roughness = static_cast<float>(roughness);
    ParseBoolean(element_.Get("active"), &sheet.is_active);
    Check(sheet);
    return sheet;
  }

 private:
  void Report(const char* attribute, const std::string& what, std::string why, std::string fix) {
    diagnostics_->push_back({{file_, element_.LineOf(attribute)},
                             "sheet of '" + object_.name + "': " + what,
                             std::move(why),
                             std::move(fix)});
  }
  void Number(const char* name, double* value) const { ParseNumber(element_.Get(name), value); }
  template <typename Vec>
  void Vector(const char* name, Vec* value) const {
    std::vector<double> numbers;
    if (ParseNumbers(element_.Get(name), &numbers) && numbers.size() == 3) {
      *value = Vec(numbers[0], numbers[1], numbers[2]);
    }
  }
  void ReadTwoPositive(const char* name, double* x, double* y) {
    std::vector<double> numbers;
    if (!ParseNumbers(element_.Get(name), &numbers)) return;  // reported by the check against schema.hpp
    if (numbers.size() != 2 || numbers[0] <= 0.0 || numbers[1] <= 0.0) {
      Report(name, std::string(name) + " is not two numbers above zero", "it holds a value along x and one along y",
             "write two positive numbers");
      return;
    }
    *x = numbers[0];
    *y = numbers[1];
  }

  void Check(const Sheet& sheet) {
    if (object_.owner != Owner::kPhysics) {
      Report("size_m", "the object is not moved by physics", "a sheet is attached to a body that reacts to it",
             "write owner=\"physics\" on the object");
    }
    if (sheet.size_x_m <= 0.0 || sheet.cells_x <= 0) return;  // reported above
    const int nodes = (sheet.cells_x + 1) * (sheet.cells_y + 1);
    if (sheet.cells_x < 2 || sheet.cells_y < 2 || nodes > static_cast<int>(core::kMaxSheetNodes)) {
      Report("cells", std::to_string(nodes) + " nodes",
             "a sheet has at least 2 cells along each side and messages have room for " +
                 std::to_string(core::kMaxSheetNodes) + " nodes",
             "20 cells along the longer side are usual");
    }
    // The lattice's edge springs are positive for ratios from 1/sqrt(3) to sqrt(3) (physics/cloth/cloth_grid.hpp).
    const double ratio = sheet.size_x_m / sheet.cells_x * sheet.cells_y / sheet.size_y_m;
    if (ratio > 1.7 || ratio < 1.0 / 1.7) {
      Report("cells", "a cell is " + std::to_string(ratio) + " times as long as wide",
             "the springs of the lattice need a ratio from 0.6 to 1.7", "change the number of cells along a side");
    }
  }

  const XmlElement& element_;
  const Object& object_;
  const std::filesystem::path& file_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

Sheet ReadSheet(const XmlElement& element, const Object& object, const std::filesystem::path& file,
                std::vector<Diagnostic>* diagnostics) {
  return SheetReader(element, object, file, diagnostics).Read();
}

}  // namespace scene
