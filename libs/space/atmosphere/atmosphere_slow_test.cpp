#include <gtest/gtest.h>

#include "space/atmosphere/tables.hpp"
#include "space/testing/air_oracle.hpp"
#include "space/testing/air_picture.hpp"

namespace space {
namespace {

// Tables of the full size, as pictures have them. The reference is in double precision; light that was scattered once
// is integrated along each pixel's ray, without tables, the rest is of the same tables in double precision.
TEST(AtmospherePicture, IsThatOfTheDoubleReferenceWithin46dB) {
  AirTableSizes sizes;
  sizes.num_orders = 4;
  const AirTables<float> tables = *MakeAirTables<float>(Air{}, sizes);
  const std::vector<double> picture =
      AirPicture(Air{}, [&](double r, double mu, double mu_s, double nu, bool meets_ground) {
        return glm::dvec3(SkyRadiance(tables, static_cast<float>(r), static_cast<float>(mu), static_cast<float>(mu_s),
                                      static_cast<float>(nu), meets_ground));
      });
  const AirTables<double> all = *MakeAirTables<double>(Air{}, sizes);
  sizes.num_orders = 1;
  const AirTables<double> once = *MakeAirTables<double>(Air{}, sizes);
  const AirOracle oracle{Air{}};
  const std::vector<double> same_tables =
      AirPicture(Air{}, [&](double r, double mu, double mu_s, double nu, bool meets_ground) {
        return SkyRadiance(all, r, mu, mu_s, nu, meets_ground);
      });
  const std::vector<double> reference =
      AirPicture(Air{}, [&](double r, double mu, double mu_s, double nu, bool meets_ground) {
        return SkyRadiance(all, r, mu, mu_s, nu, meets_ground) - SkyRadiance(once, r, mu, mu_s, nu, meets_ground) +
               oracle.SingleScattering(r, mu, mu_s, nu, meets_ground);
      });
  RecordProperty("psnr_of_floats_db", std::to_string(Psnr(picture, same_tables)));
  RecordProperty("psnr_db", std::to_string(Psnr(picture, reference)));
  EXPECT_GT(Psnr(picture, same_tables), 46.0);
  EXPECT_GT(Psnr(picture, reference), 46.0);
}

}  // namespace
}  // namespace space
