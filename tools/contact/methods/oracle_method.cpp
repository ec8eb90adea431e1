#include "tools/contact/methods/method.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/oracle/contact_wrench.hpp"

namespace contact {
namespace {

class OracleMethod : public Method {
 public:
  OracleMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B, double relative_accuracy)
      : A_(A), B_(B), accuracy_{relative_accuracy} {}

  Answer Query(const core::Pose& X_AB) override {
    Answer answer;
    answer.signed_distance_m = vps::oracle::SignedBodyDistance(A_, B_, X_AB).signed_distance_m;
    if (answer.signed_distance_m > 0.0) return answer;
    const vps::oracle::ContactWrench wrench = vps::oracle::IntegrateContactWrench(A_, B_, X_AB, accuracy_);
    answer.force_A = wrench.force_A_m3;
    answer.moment_A = wrench.moment_A_m4;
    answer.contacts = wrench.num_pieces_with_depth;
    answer.points_tested = wrench.num_samples;
    answer.force_error = wrench.error_bound_m3;
    return answer;
  }

 private:
  vps::oracle::MeshDistance A_;
  vps::oracle::MeshDistance B_;
  vps::oracle::WrenchAccuracy accuracy_;
};

}  // namespace

core::Result<std::unique_ptr<Method>> MakeOracleMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                       double relative_accuracy) {
  return std::make_unique<OracleMethod>(A, B, relative_accuracy);
}

}  // namespace contact
