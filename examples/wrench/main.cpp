// Two meshes, a pose, a wrench: what the body of mesh A feels in the body of mesh B, X_BA being a translation.
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "vps/multibody/collision_world.hpp"

int main(int argc, char** argv) {
  if (argc != 6) return std::fprintf(stderr, "usage: wrench A.obj B.obj X_m Y_m Z_m\n"), 2;

  // A is sampled by points, B is a field of distances; both in cells of a millimetre.
  const auto a = vps::Cook(argv[1], {.num_points = 20000, .method = vps::Method::kFast});
  const auto b = vps::Cook(argv[2], {.voxel_size_m = 0.001, .method = vps::Method::kFast});
  for (const auto* object : {&a, &b}) {
    if (!*object) return std::fprintf(stderr, "wrench: %s\n", object->error().detail.c_str()), 1;
  }

  vps::WorldDescription description;
  description.method = vps::Method::kFast;
  description.objects = {{std::make_shared<vps::CookedObject>(*a), {}}, {std::make_shared<vps::CookedObject>(*b), {}}};
  description.pairs = {{.sampled = 0, .field = 1, .stiffness_N_per_m = 2.0e4}};
  auto world = vps::CollisionWorld::Create(description);
  if (!world) return std::fprintf(stderr, "wrench: %s\n", world.error().detail.c_str()), 1;

  core::SerialFor on_this_thread;
  (*world)->SetPose(0, {.translation = {std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5])}});
  (*world)->Step(&on_this_thread);

  const core::Wrench& F_Ao_B = (*world)->ObjectWrench(0);
  std::printf("force_N %.6g %.6g %.6g\n", F_Ao_B.force_N.x, F_Ao_B.force_N.y, F_Ao_B.force_N.z);
  std::printf("torque_Nm %.6g %.6g %.6g\n", F_Ao_B.torque_Nm.x, F_Ao_B.torque_Nm.y, F_Ao_B.torque_Nm.z);
}
