#include "vps/multibody/pair_query.hpp"

#include "vps/force/force_scale.hpp"

namespace vps {

double QueryPair(const PointTree& sampled, const Voxmap& field, const core::Pose& X_WS, const core::Pose& X_GS,
                 const PairDescription& pair, double rho, double alpha, PairScratch* scratch, PairResult* result) {
  const QueryResult query = QueryTree(sampled, field, X_GS, pair.look_ahead_m, &scratch->query);
  result->counters = {query.spheres_tested, query.points_tested, query.num_colliding};
  result->is_in_contact = query.num_colliding > 0;
  result->planes.clear();
  result->f_So_S = {};
  result->F_So_W = {};
  if (query.num_hits == 0) {
    result->signed_distance_m = pair.look_ahead_m + query.free_distance_m;
    return query.free_distance_m;
  }

  // f_tot = sum V(P_i) n_i and t_tot = sum P_i x V(P_i) n_i over V >= 0 [VR-OOS, Eq. 1], in point order.
  PenetrationSum total;
  std::uint32_t deepest = 0;
  for (std::uint32_t i = 0; i < query.num_hits; ++i) {
    const PointHit& hit = scratch->query.hits[i];
    SampledContact& contact = scratch->contacts[i];
    contact.p_S = {sampled.x[hit.point], sampled.y[hit.point], sampled.z[hit.point]};
    contact.n_S = {sampled.nx[hit.point], sampled.ny[hit.point], sampled.nz[hit.point]};
    contact.penetration_m = hit.penetration_m;
    if (hit.penetration_m > scratch->contacts[deepest].penetration_m) deepest = i;
    if (hit.penetration_m < 0.0f) continue;
    const glm::dvec3 f = static_cast<double>(hit.penetration_m) * glm::dvec3(contact.n_S);
    total.sum_m += f;
    total.moment_m2 += glm::cross(glm::dvec3(contact.p_S), f);
  }
  result->signed_distance_m = -static_cast<double>(query.max_penetration_m);
  result->deepest_p_S = scratch->contacts[deepest].p_S;
  result->deepest_n_S = scratch->contacts[deepest].n_S;
  result->f_So_S = ForceScale(query.num_colliding, sampled.num_points, rho, alpha) * total;
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));
  ReduceContacts({scratch->contacts.data(), query.num_hits}, X_GS, pair.stiffness_N_per_m, pair.look_ahead_m,
                 &result->planes);
  return 0.0;
}

}  // namespace vps
