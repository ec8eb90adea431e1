#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <unordered_map>

#include "core/read_file.hpp"
#include "space/stars/star_field.hpp"
#include "space/stars/star_file.hpp"
#include "space/stars/tycho2.hpp"

namespace space {
namespace {

constexpr double kArcSecond = 4.84813681e-6;

glm::dvec3 Direction(double ra_deg, double dec_deg) {
  const double ra = glm::radians(ra_deg), dec = glm::radians(dec_deg);
  return {std::cos(dec) * std::cos(ra), std::cos(dec) * std::sin(ra), std::sin(dec)};
}

double Distance_arcsec(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::length(glm::cross(a, b)) / kArcSecond;
}

const std::vector<Star>& Bright() {
  static const std::vector<Star> stars = *DecodeStars(BrightStarBytes());
  return stars;
}

const Star& Nearest(const std::vector<Star>& stars, const glm::dvec3& direction) {
  return *std::max_element(stars.begin(), stars.end(), [&](const Star& a, const Star& b) {
    return glm::dot(a.direction_C, direction) < glm::dot(b.direction_C, direction);
  });
}

std::size_t CountBrighterThan(const std::vector<Star>& stars, double magnitude) {
  return static_cast<std::size_t>(
      std::count_if(stars.begin(), stars.end(), [&](const Star& star) { return star.magnitude <= magnitude + 1e-9; }));
}

TEST(StarFile, NamedStarsStandWhereTheSourceHasThem) {
  // Of the source, which rounds places to 0.36 arc seconds; Polaris and what is brighter than 2 keep them.
  struct Named {
    const char* name;
    double ra_deg, dec_deg, magnitude, color_bv;
  };
  for (const Named& named :
       {Named{"Sirius", 101.2872, -16.7161, -1.44, 0.009}, Named{"Vega", -80.7653, 38.7837, 0.03, -0.001},
        Named{"Polaris", 37.9545, 89.2641, 1.97, 0.636}, Named{"Betelgeuse", 88.7929, 7.4071, 0.45, 1.5}}) {
    const glm::dvec3 direction = Direction(named.ra_deg, named.dec_deg);
    const Star& star = Nearest(Bright(), direction);
    EXPECT_LT(Distance_arcsec(star.direction_C, direction), 0.1) << named.name;
    EXPECT_NEAR(star.magnitude, named.magnitude, 0.001) << named.name;
    EXPECT_NEAR(star.color_bv, named.color_bv, 0.011) << named.name;
  }
}

TEST(StarFile, TheCommittedStarsAreAsManyAsInTheSourceAtEachMagnitude) {
  EXPECT_EQ(Bright().size(), 118216U);
  EXPECT_EQ(CountBrighterThan(Bright(), 2.0), 49U);
  EXPECT_EQ(CountBrighterThan(Bright(), 6.0), 5044U);
  EXPECT_EQ(CountBrighterThan(Bright(), 9.0), 83392U);
  EXPECT_LE(BrightStarBytes().size(), 1'500'000U);
}

TEST(StarFile, WritesTheBytesThatItReads) {
  const std::string again = EncodeStars(Bright());
  const auto bytes = BrightStarBytes();
  ASSERT_EQ(again.size(), bytes.size());
  // Stars of one magnitude may come in another order.
  EXPECT_EQ(EncodeStars(*DecodeStars({reinterpret_cast<const std::uint8_t*>(again.data()), again.size()})), again);
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), reinterpret_cast<const std::uint8_t*>(again.data())));
}

TEST(StarFile, AnyDirectionComesBackWithin0_1ArcSeconds) {
  std::vector<Star> stars;
  for (int i = 0; i < 20000; ++i) {  // a spiral over the sphere
    const double z = 1.0 - (2.0 * i + 1.0) / 20000.0, angle = 2.39996323 * i, ring = std::sqrt(1.0 - z * z);
    stars.push_back({{ring * std::cos(angle), ring * std::sin(angle), z}, 1e-3 * (i % 15000), 0.7});
  }
  std::stable_sort(stars.begin(), stars.end(), [](const Star& a, const Star& b) { return a.magnitude < b.magnitude; });
  const std::string bytes = EncodeStars(stars);
  const auto again = DecodeStars({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  ASSERT_TRUE(again);
  double largest = 0.0;
  for (std::size_t i = 0; i < stars.size(); ++i) {
    largest = std::max(largest, Distance_arcsec(stars[i].direction_C, (*again)[i].direction_C));
  }
  RecordProperty("largest_arcsec", std::to_string(largest));
  EXPECT_LT(largest, 0.1);
}

TEST(StarFile, WithoutTheFullCatalogueItSaysWhatIsMissing) {
  const Catalogue catalogue = LoadStars("/nowhere/tycho2.stars");
  EXPECT_EQ(catalogue.stars.size(), 118216U);
  EXPECT_NE(catalogue.note.find("`oos stars` builds it"), std::string::npos);
  const std::filesystem::path damaged = std::filesystem::path(testing::TempDir()) / "damaged.stars";
  std::ofstream(damaged) << "OOSSTAR1";
  EXPECT_NE(LoadStars(damaged).note.find("it does not begin"), std::string::npos);
  std::filesystem::remove(damaged);
}

TEST(Star, MagnitudesAreLuminances) {
  // CosmoScout VR: S = m + 2.5 log10(solid angle 4.25e10), L = 10.8e4 10^(-0.4 S) cd/m2.
  const double solid_angle_sr = 1e-6;
  for (const double magnitude : {-1.44, 0.0, 6.5, 12.0}) {
    const double S = magnitude + 2.5 * std::log10(solid_angle_sr * 4.25e10);
    EXPECT_NEAR(Illuminance_lx(magnitude) / solid_angle_sr / (10.8e4 * std::pow(10.0, -0.4 * S)), 1.0, 2e-3);
  }
  for (const double bv : {-0.3, 0.0, 0.65, 1.5}) {
    EXPECT_NEAR(glm::dot(ColorOf(bv), glm::dvec3(0.2126729, 0.7151522, 0.0721750)), 1.0, 1e-9) << bv;
  }
  EXPECT_GT(ColorOf(-0.3).b, ColorOf(-0.3).r);
  EXPECT_GT(ColorOf(1.5).r, 2.0 * ColorOf(1.5).b);
}

// FITS as the package has it, with two stars.
std::vector<std::uint8_t> SmallIndex() {
  std::vector<std::uint8_t> fits;
  const auto add = [&](const std::string& column, std::size_t row_bytes, std::size_t rows, const void* data) {
    std::string header;
    const auto card = [&](std::string text) { header += text + std::string(80 - text.size(), ' '); };
    card("XTENSION= 'BINTABLE'");
    card("NAXIS   =                    2");
    card("NAXIS1  = " + std::to_string(row_bytes) + " / bytes");
    card("NAXIS2  = " + std::to_string(rows));
    card("TTYPE1  = '" + column + "'");
    card("ENDIAN  = '04:03:02:01'");
    card("END");
    header.resize(2880, ' ');
    fits.insert(fits.end(), header.begin(), header.end());
    const auto* from = static_cast<const std::uint8_t*>(data);
    fits.insert(fits.end(), from, from + row_bytes * rows);
    fits.resize((fits.size() + 2879) / 2880 * 2880);
  };
  const double range[7] = {-1, -1, -1, 1, 1, 1, 2147483647.5};
  const std::uint32_t data[6] = {4294967295U, 2147483647U, 2147483647U, 2147483647U, 2147483647U, 0U};
  const std::uint8_t magnitudes[8] = {0x40, 0xa0, 0, 0, 0x41, 0x20, 0, 0};  // 5 and 10
  add("kdtree_range_stars", 8, 7, range);
  add("kdtree_data_stars", 12, 2, data);
  add("MAG_VT", 4, 2, magnitudes);
  return fits;
}

TEST(Tycho2, ReadsPlacesAndMagnitudesOfTheIndex) {
  const auto stars = ReadTycho2(SmallIndex());
  ASSERT_TRUE(stars) << stars.error().detail;
  ASSERT_EQ(stars->size(), 2U);
  EXPECT_LT(Distance_arcsec((*stars)[0].direction_C, {1, 0, 0}), 1e-3);
  EXPECT_LT(Distance_arcsec((*stars)[1].direction_C, {0, 0, -1}), 1e-3);
  EXPECT_NEAR((*stars)[0].magnitude, 5.0 - 0.0742, 1e-6);
  EXPECT_NEAR((*stars)[1].magnitude, 10.0 - 0.0742, 1e-6);
}

TEST(Tycho2, RefusesADamagedIndex) {
  std::vector<std::uint8_t> fits = SmallIndex();
  for (const std::size_t size : {0UL, 100UL, 2880UL, 5760UL, fits.size() - 2880UL}) {
    EXPECT_FALSE(ReadTycho2(std::span(fits).first(size))) << size;
  }
}

TEST(Tycho2, AStarOfBothListsIsOneAndAMissingOneIsAdded) {
  const std::vector<Star> tycho2 = {{Direction(10, 20), 8.0, 0.7}, {Direction(50, -30), 11.0, 0.7}};
  const std::vector<Star> bright = {{Direction(10, 20 + 20 / 3600.0), 7.9, 1.2},   // the first, 20" off
                                    {Direction(50, -30 + 20 / 3600.0), 2.0, 0.1},  // a bright one beside a faint one
                                    {Direction(10, 20 + 40 / 3600.0), 8.0, 0.3}};  // 40" off: another
  const MergedStars merged = MergeStars(tycho2, bright);
  EXPECT_EQ(merged.num_same, 1U);
  ASSERT_EQ(merged.stars.size(), 4U);
  EXPECT_EQ(merged.stars[0].direction_C, tycho2[0].direction_C);
  EXPECT_EQ(merged.stars[0].magnitude, 7.9);
  const MergedStars brightest =
      MergeStars({{tycho2[0].direction_C, 1.5, 0.7}}, std::vector<Star>{{bright[0].direction_C, 1.0, 0.0}});
  EXPECT_EQ(brightest.stars[0].direction_C, bright[0].direction_C) << "too bright for Tycho-2";
  EXPECT_EQ(merged.stars[0].color_bv, 1.2);
}

// Places in cells of 0.1 arc seconds.
class StarPlaces {
 public:
  explicit StarPlaces(const std::vector<Star>& stars) {
    for (const Star& star : stars) cells_.emplace(Key(Cell(star.direction_C)), star.direction_C);
  }
  [[nodiscard]] bool HasWithin0_1ArcSeconds(const glm::dvec3& direction) const {
    const glm::i64vec3 middle = Cell(direction);
    for (int k = 0; k < 27; ++k) {
      const auto [first, last] = cells_.equal_range(Key(middle + glm::i64vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
      for (auto it = first; it != last; ++it) {
        if (Distance_arcsec(it->second, direction) < 0.1) return true;
      }
    }
    return false;
  }

 private:
  static glm::i64vec3 Cell(const glm::dvec3& d) { return glm::i64vec3(glm::floor(d / (0.1 * kArcSecond))); }
  static std::int64_t Key(const glm::i64vec3& cell) {
    return cell.x * 73856093 ^ cell.y * 19349663 ^ cell.z * 83492791;
  }

  std::unordered_multimap<std::int64_t, glm::dvec3> cells_;
};

// The whole way, where the package's file is at hand.
TEST(Tycho2, TheFullCatalogueHas1_87MillionStars) {
  const char* const given = std::getenv("VR_OOS_TYCHO2");
  const auto fits = core::ReadFile(given != nullptr ? given : kTycho2File);
  if (!fits) GTEST_SKIP() << "needs the package " << kTycho2Package;
  const auto tycho2 = ReadTycho2(*fits);
  ASSERT_TRUE(tycho2) << tycho2.error().detail;
  EXPECT_EQ(tycho2->size(), 1871011U);
  // What the committed stars have of it.
  const StarPlaces places(*tycho2);
  const auto num_there = std::count_if(Bright().begin(), Bright().end(), [&](const Star& star) {
    return places.HasWithin0_1ArcSeconds(star.direction_C);
  });
  EXPECT_GE(num_there, 113'900);
  const MergedStars merged = MergeStars(*tycho2, Bright());
  EXPECT_EQ(merged.stars.size(), 1871011U + 118216U - merged.num_same);
  std::printf("%zu stars, %zu in both lists\n", merged.stars.size(), merged.num_same);
  for (const auto& [direction, magnitude] :
       {std::pair{Direction(101.2872, -16.7161), -1.44}, std::pair{Direction(279.2347, 38.7837), 0.03}}) {
    EXPECT_NEAR(Nearest(merged.stars, direction).magnitude, magnitude, 0.01);
  }
}

StarCamera Camera(int width, int height, double fov_rad) {
  // Looks at the galactic centre's side of the sky, tilted.
  const glm::dvec3 back = -Direction(250, -20);
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0.2, 0.1, 1.0), back));
  const glm::dmat3 R_CV(right, glm::cross(back, right), back);
  return {glm::transpose(R_CV), 0.5 * height / std::tan(0.5 * fov_rad), width, height};
}

double SolidAngle_sr(const StarCamera& camera, int column, int row) {
  const double u = column + 0.5 - 0.5 * camera.width, v = row + 0.5 - 0.5 * camera.height;
  return camera.focal_px / std::pow(camera.focal_px * camera.focal_px + u * u + v * v, 1.5);
}

double Luminance(const glm::vec4& pixel) {
  return glm::dot(glm::dvec3(pixel), glm::dvec3(0.2126729, 0.7151522, 0.0721750));
}

TEST(StarField, TheFluxOfAPictureIsThatOfItsStarsWithin0_5Percent) {
  const StarField field(Bright());
  for (const double fov_rad : {0.3, 0.8, 1.6}) {
    const StarCamera camera = Camera(640, 360, fov_rad);
    std::vector<glm::vec4> image(640 * 360, glm::vec4(0.0f));
    field.AddTo(camera, image);
    double drawn_lx = 0.0, expected_lx = 0.0;
    for (int row = 0; row < camera.height; ++row) {
      for (int column = 0; column < camera.width; ++column) {
        drawn_lx += Luminance(image[static_cast<std::size_t>(row * 640 + column)]) * SolidAngle_sr(camera, column, row);
      }
    }
    for (const Star& star : Bright()) {
      const glm::dvec3 d = camera.R_VC * star.direction_C;
      if (d.z >= 0.0) continue;
      if (std::abs(d.x / d.z) * camera.focal_px > 320.0 || std::abs(d.y / d.z) * camera.focal_px > 180.0) continue;
      expected_lx += Illuminance_lx(star.magnitude);
    }
    EXPECT_NEAR(drawn_lx / expected_lx, 1.0, 0.005) << fov_rad;
  }
}

TEST(StarField, ACentroidIsOffByLessThan0_05Pixels) {
  const StarCamera camera = Camera(640, 360, 0.8);
  double largest_px = 0.0, largest_flux = 0.0;
  for (int k = 0; k < 500; ++k) {
    const double px = 3.0 + std::fmod(k * 0.61803398875, 1.0) * 633.0,
                 py = 3.0 + std::fmod(k * 0.7548776662, 1.0) * 353.0;
    const glm::dvec3 d = glm::normalize(glm::dvec3(px - 320.0, py - 180.0, -camera.focal_px));
    const StarField field(std::vector<Star>{{glm::transpose(camera.R_VC) * d, 3.0, 0.7}});
    std::vector<glm::vec4> image(640 * 360, glm::vec4(0.0f));
    EXPECT_EQ(field.AddTo(camera, image), 1U);
    glm::dvec2 moment(0.0);
    double sum = 0.0, flux_lx = 0.0;
    for (int row = 0; row < 360; ++row) {
      for (int column = 0; column < 640; ++column) {
        const double value = Luminance(image[static_cast<std::size_t>(row * 640 + column)]);
        if (value == 0.0) continue;
        moment += value * glm::dvec2(column + 0.5, row + 0.5);
        sum += value;
        flux_lx += value * SolidAngle_sr(camera, column, row);
      }
    }
    largest_px = std::max(largest_px, glm::length(moment / sum - glm::dvec2(px, py)));
    largest_flux = std::max(largest_flux, std::abs(flux_lx / Illuminance_lx(3.0) - 1.0));
  }
  RecordProperty("largest_px", std::to_string(largest_px));
  RecordProperty("largest_flux", std::to_string(largest_flux));
  EXPECT_LT(largest_px, 0.05);
  EXPECT_LT(largest_flux, 0.005);
}

}  // namespace
}  // namespace space
