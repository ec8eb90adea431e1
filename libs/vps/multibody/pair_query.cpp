#include "vps/multibody/pair_query.hpp"

#include "vps/force/force_scale.hpp"
#include "vps/query/field_normal.hpp"

namespace vps {

double QueryPair(const PointTree& sampled, const Voxmap& field, const core::Pose& X_WS, const core::Pose& X_GS,
                 const PairDescription& pair, double rho, double alpha, PairScratch* scratch, PairResult* result) {
  const QueryResult query = QueryTree(sampled, field, X_GS, pair.look_ahead_m, &scratch->query);
  result->counters = {query.spheres_tested, query.points_tested, query.num_colliding};
  result->is_in_contact = query.num_colliding > 0;
  result->f_So_S = {};
  result->F_So_W = {};
  if (query.num_hits == 0) {
    result->planes.clear();
    result->signed_distance_m = pair.look_ahead_m + query.free_distance_m;
    return query.free_distance_m;
  }

  // f_tot = sum V(P_i) n_i and t_tot = sum P_i x V(P_i) n_i over V >= 0 [VR-OOS, Eq. 1], in point order.
  const std::vector<PointHit>& hits = scratch->query.hits;
  PenetrationSum total;
  PointHit deepest = hits[0];
  for (std::uint32_t i = 0; i < query.num_hits; ++i) {
    const std::uint32_t k = hits[i].point;
    if (hits[i].penetration_m > deepest.penetration_m) deepest = hits[i];
    if (hits[i].penetration_m < 0.0f) continue;
    const glm::dvec3 f =
        static_cast<double>(hits[i].penetration_m) * glm::dvec3(sampled.nx[k], sampled.ny[k], sampled.nz[k]);
    total.sum_m += f;
    total.moment_m2 += glm::cross(glm::dvec3(sampled.x[k], sampled.y[k], sampled.z[k]), f);
  }
  result->signed_distance_m = -static_cast<double>(query.max_penetration_m);
  result->f_So_S = ForceScale(query.num_colliding, sampled.num_points, rho, alpha) * total;
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));

  // Contacts for the planes: the gap is -V of Eq. 1, its direction that of the field (see FieldNormal).
  std::uint32_t mask = 0;
  while (query.num_hits / (mask + 1) > kMaxReducedContacts / 2) mask = 2 * mask + 1;
  const PairTransform T(X_GS, field);
  const glm::mat3 R_SG(glm::mat3_cast(glm::conjugate(X_GS.rotation)));
  std::uint32_t num_contacts = 0;
  for (std::uint32_t i = 0; i < query.num_hits; ++i) {
    const std::uint32_t k = hits[i].point;
    const bool is_deepest = k == deepest.point;
    if (((k & mask) != 0 || num_contacts == kMaxReducedContacts) && !is_deepest) continue;
    SampledContact& contact = scratch->contacts[num_contacts++];
    contact.p_S = {sampled.x[k], sampled.y[k], sampled.z[k]};
    contact.n_S = {sampled.nx[k], sampled.ny[k], sampled.nz[k]};
    contact.penetration_m = hits[i].penetration_m;
    const glm::vec3 p = T.ToVoxels(contact.p_S);
    glm::vec3 n_G;
    if (FieldNormal(field, &p.x, &n_G)) contact.n_S = R_SG * n_G;
  }
  ReduceContacts({scratch->contacts.data(), num_contacts}, X_GS, pair.stiffness_N_per_m, pair.look_ahead_m,
                 &result->planes, kHysteresis * field.voxel_size_m);
  return 0.0;
}

}  // namespace vps
