#include "space/atmosphere/tables.hpp"

#include <array>

namespace space {
namespace {

constexpr double kPi = 3.14159265358979323846;
// Steps along a ray: of the optical thickness up to the top, of light scattered once, and of all further orders.
constexpr int kThicknessSteps = 500;
constexpr int kSingleSteps = 150;
constexpr int kMultipleSteps = 50;
// Of the time for light scattered once, the time for the transmittance.
constexpr double kTransmittanceWork = 0.1;
// Directions over the whole sphere: rings and their parts.
constexpr int kRings = 16;
constexpr int kParts = 32;

template <typename T>
const T& At(const std::vector<T>& values, int row, int width, int column) {
  return values[static_cast<std::size_t>(row * width + column)];
}

template <typename Real, typename T>
T Mix(const std::vector<T>& values, int width, const Between<Real>& row, const Between<Real>& column) {
  const auto along = [&](int i) {
    return At(values, i, width, column.first) * (Real(1) - column.share) +
           At(values, i, width, column.second) * column.share;
  };
  return along(row.first) * (Real(1) - row.share) + along(row.second) * row.share;
}

// A smooth step from 0 to 1 as `x` goes from -1 to 1: the sun's disc over the horizon.
template <typename Real>
Real DiscShare(Real x) {
  const Real t = std::clamp(Real(0.5) + Real(0.5) * x, Real(0), Real(1));
  return t * t * (Real(3) - Real(2) * t);
}

// The sun's disc above the horizon of the radius r.
template <typename Real>
Real SunAbove(const Shell<Real>& shell, Real r, Real mu_s) {
  const Real sine = shell.bottom / r;
  const Real cosine = -std::sqrt(std::max(Real(1) - sine * sine, Real(0)));
  return DiscShare((mu_s - cosine) / (sine * Real(kSunRadius_rad)));
}

// Rows of the view: the first half of them meet the ground.
template <typename Real>
Real ViewOfRow(const AirMapping<Real>& mapping, int num, int row, Real r) {
  const int half = num / 2;
  return row < half ? mapping.ToDownward(r, Real(row) / Real(half - 1))
                    : mapping.ToUpward(r, Real(row - half) / Real(half - 1));
}

template <typename Real>
Between<Real> RowOfView(const AirMapping<Real>& mapping, int num, Real r, Real mu, bool meets_ground) {
  const int half = num / 2;
  Between<Real> place = PlaceAmong(half, meets_ground ? mapping.FromDownward(r, mu) : mapping.FromUpward(r, mu));
  if (!meets_ground) {
    place.first += half;
    place.second += half;
  }
  return place;
}

// What the angles of a view and of the sun to the zenith leave for the angle between them.
template <typename Real>
Real Possible(Real nu, Real mu, Real mu_s) {
  const Real middle = mu * mu_s;
  const Real reach = std::sqrt(std::max((Real(1) - mu * mu) * (Real(1) - mu_s * mu_s), Real(0)));
  return std::clamp(nu, middle - reach, middle + reach);
}

template <typename Real>
Rgb<Real> ToTop(const AirTables<Real>& tables, const AirMapping<Real>& mapping, Real r, Real mu) {
  return Mix(tables.transmittance, tables.sizes.transmittance_mu,
             PlaceAmong(tables.sizes.transmittance_r, mapping.FromRadius(r)),
             PlaceAmong(tables.sizes.transmittance_mu, mapping.FromUpward(r, mu)));
}

template <typename Real>
Rgb<Real> ToSun(const AirTables<Real>& tables, const AirMapping<Real>& mapping, Real r, Real mu_s) {
  const Real above = SunAbove(mapping.shell(), r, mu_s);
  return above > 0 ? above * ToTop(tables, mapping, r, mu_s) : Rgb<Real>(0);
}

// A ray in steps: where each is, and the weight of what happens there for its beginning.
template <typename Real>
struct Step {
  Real d = 0;
  Real r = 0;
  Densities<Real> densities;
  Rgb<Real> weight{0};  // transmittance times length
};

template <typename Real>
std::vector<Step<Real>> StepsAlong(const Air& air, const Shell<Real>& shell, Real r, Real mu, bool meets_ground,
                                   int num) {
  const Real length = meets_ground ? shell.DistanceToBottom(r, mu) : shell.DistanceToTop(r, mu);
  const Real step = length / Real(num);
  std::vector<Step<Real>> steps(static_cast<std::size_t>(num) + 1);
  Rgb<Real> thickness(0), before(0);
  for (int k = 0; k <= num; ++k) {
    Step<Real>& at = steps[static_cast<std::size_t>(k)];
    at.d = Real(k) * step;
    at.r = shell.RadiusAfter(r, mu, at.d);
    at.densities = DensitiesAt(air, at.r - shell.bottom);
    const Rgb<Real> extinction = ExtinctionOf(air, at.densities);
    if (k > 0) thickness += Real(0.5) * step * (before + extinction);
    before = extinction;
    at.weight = (k == 0 || k == num ? Real(0.5) : Real(1)) * step * glm::exp(-thickness);
  }
  return steps;
}

// All directions around a point, at the middles of parts of rings. z is the zenith; the sun is in the plane of x and z.
template <typename Real>
struct Directions {
  std::vector<Real> x, y, z, solid_angle;
};

template <typename Real>
Directions<Real> MakeDirections() {
  Directions<Real> all;
  for (int ring = 0; ring < kRings; ++ring) {
    const double theta = (ring + 0.5) * kPi / kRings;
    for (int part = 0; part < kParts; ++part) {
      const double phi = (part + 0.5) * 2.0 * kPi / kParts;
      all.x.push_back(Real(std::cos(phi) * std::sin(theta)));
      all.y.push_back(Real(std::sin(phi) * std::sin(theta)));
      all.z.push_back(Real(std::cos(theta)));
      all.solid_angle.push_back(Real(kPi / kRings * 2.0 * kPi / kParts * std::sin(theta)));
    }
  }
  return all;
}

// Sums over directions for many views at once, so that the compiler takes several of them in each instruction.
template <typename Real>
class PhaseSums {
 public:
  explicit PhaseSums(std::size_t num_views) {
    for (auto* values : {&x_, &y_, &z_}) values->resize(num_views);
    for (auto& values : sums_) values.resize(num_views);
  }

  void SetView(std::size_t i, Real x, Real y, Real z) {
    x_[i] = x;
    y_[i] = y;
    z_[i] = z;
  }

  void Clear() {
    for (auto& values : sums_) std::fill(values.begin(), values.end(), Real(0));
  }

  // Adds 1 + nu^2 and, for aerosols, (1 + nu^2) / q^(3/2) times the light from a direction.
  void Add(Real dx, Real dy, Real dz, const Rgb<Real>& light, Real g) {
    const Real a = Real(1) + g * g, b = Real(2) * g;
    const Real red = light.x, green = light.y, blue = light.z;
    const Real *x = x_.data(), *y = y_.data(), *z = z_.data();
    Real *s0 = sums_[0].data(), *s1 = sums_[1].data(), *s2 = sums_[2].data();
    Real *s3 = sums_[3].data(), *s4 = sums_[4].data(), *s5 = sums_[5].data();
    const std::size_t num = x_.size();
#pragma GCC ivdep
    for (std::size_t i = 0; i < num; ++i) {
      const Real nu = x[i] * dx + y[i] * dy + z[i] * dz;
      const Real molecules = Real(1) + nu * nu;
      const Real q = a - b * nu;
      const Real aerosols = molecules / (q * std::sqrt(q));
      s0[i] += molecules * red;
      s1[i] += molecules * green;
      s2[i] += molecules * blue;
      s3[i] += aerosols * red;
      s4[i] += aerosols * green;
      s5[i] += aerosols * blue;
    }
  }

  [[nodiscard]] Rgb<Real> rayleigh(std::size_t i) const {
    return {sums_[0][i], sums_[1][i], sums_[2][i]};
  }
  [[nodiscard]] Rgb<Real> mie(std::size_t i) const {
    return {sums_[3][i], sums_[4][i], sums_[5][i]};
  }

 private:
  std::vector<Real> x_, y_, z_;
  std::array<std::vector<Real>, 6> sums_;
};

template <typename Real>
class Maker {
 public:
  Maker(const Air& air, const AirTableSizes& sizes, core::ParallelFor* workers, const AirProgress& progress)
      : mapping_(air), shell_(mapping_.shell()), workers_(workers), progress_(progress) {
    tables_.air = air;
    tables_.sizes = sizes;
  }

  std::optional<AirTables<Real>> Make() {
    if (!MakeTransmittance()) return std::nullopt;
    MakeDirectIrradiance();
    if (!MakeSingleScattering()) return std::nullopt;
    for (int order = 2; order <= tables_.sizes.num_orders; ++order) {
      if (!MakeSources(order)) return std::nullopt;
      MakeIndirectIrradiance(order);
      if (!MakeMultipleScattering()) return std::nullopt;
    }
    return std::move(tables_);
  }

 private:
  using Colors = std::vector<Rgb<Real>>;

  // Index of nu = 0 and mu_s = 0.
  [[nodiscard]] std::size_t Base(int r, int mu) const {
    const AirTableSizes& n = tables_.sizes;
    return static_cast<std::size_t>((r * n.mu + mu) * n.nu * n.mu_s);
  }
  [[nodiscard]] Real RadiusOf(int r) const { return mapping_.ToRadius(Real(r) / Real(tables_.sizes.r - 1)); }
  [[nodiscard]] Real SunOf(int mu_s) const { return mapping_.ToSun(Real(mu_s) / Real(tables_.sizes.mu_s - 1)); }
  [[nodiscard]] Real NuOf(int nu) const { return Real(2) * Real(nu) / Real(tables_.sizes.nu - 1) - Real(1); }

  // All rows of a radius at once when there are workers. Alone row by row, about a millisecond each, so that work in
  // the background ends soon when nobody wants it any more.
  template <typename Body>
  bool ForEachRow(double work, int num_radii, int num_rows, const Body& body) {
    const int num_at_once = workers_ != nullptr ? num_rows : 1;
    const double all = kTransmittanceWork + 1.0 + 2.0 * (tables_.sizes.num_orders - 1);
    for (int r = 0; r < num_radii; ++r) {
      for (int first = 0; first < num_rows; first += num_at_once) {
        core::ForEach(workers_, static_cast<std::size_t>(num_at_once),
                      [&](std::size_t row) { body(r, first + static_cast<int>(row)); });
        done_ += work * num_at_once / (num_rows * num_radii);
        if (progress_ && !progress_(std::min(done_ / all, 1.0))) return false;
      }
    }
    return true;
  }

  bool MakeTransmittance() {
    const AirTableSizes& n = tables_.sizes;
    tables_.transmittance.resize(static_cast<std::size_t>(n.transmittance_mu * n.transmittance_r));
    return ForEachRow(kTransmittanceWork, n.transmittance_r, n.transmittance_mu, [&](int row, int column) {
      const Real r = mapping_.ToRadius(Real(row) / Real(n.transmittance_r - 1));
      const Real mu = mapping_.ToUpward(r, Real(column) / Real(n.transmittance_mu - 1));
      tables_.transmittance[static_cast<std::size_t>(row * n.transmittance_mu + column)] =
          TransmittanceThrough(tables_.air, r, mu, false);
    });
  }

  // Of the sun, on level ground. It is kept apart from the sky's, which is what `irradiance` has.
  void MakeDirectIrradiance() {
    const AirTableSizes& n = tables_.sizes;
    const auto num = static_cast<std::size_t>(n.irradiance_mu_s * n.irradiance_r);
    tables_.irradiance.assign(num, Rgb<Real>(0));
    newest_irradiance_.resize(num);
    for (int row = 0; row < n.irradiance_r; ++row) {
      for (int column = 0; column < n.irradiance_mu_s; ++column) {
        const Real r = IrradianceRadius(row), mu_s = IrradianceSun(column);
        newest_irradiance_[static_cast<std::size_t>(row * n.irradiance_mu_s + column)] =
            std::max(mu_s, Real(0)) * ToSun(tables_, mapping_, r, mu_s);
      }
    }
  }
  [[nodiscard]] Real IrradianceRadius(int row) const {
    return shell_.bottom + (shell_.top - shell_.bottom) * Real(row) / Real(tables_.sizes.irradiance_r - 1);
  }
  [[nodiscard]] Real IrradianceSun(int column) const {
    return Real(2) * Real(column) / Real(tables_.sizes.irradiance_mu_s - 1) - Real(1);
  }

  // For each kind of scatterer: integral along the ray of T(to there) density T(from there to the sun).
  bool MakeSingleScattering() {
    const AirTableSizes& n = tables_.sizes;
    tables_.scattering.resize(n.num_scattering());
    for (Colors* colors : {&rayleigh_, &mie_, &sources_, &newest_}) colors->resize(n.num_scattering());
    return ForEachRow(1.0, n.r, n.mu, [&](int i, int j) { MakeSingleRow(i, j); });
  }

  void MakeSingleRow(int i, int j) {
    const AirTableSizes& n = tables_.sizes;
    const Real r = RadiusOf(i), mu = ViewOfRow(mapping_, n.mu, j, r);
    const auto steps = StepsAlong(tables_.air, shell_, r, mu, j < n.mu / 2, kSingleSteps);
    const Rgb<Real> beta_rayleigh(tables_.air.rayleigh_per_m), beta_mie(tables_.air.mie_per_m());
    for (int k = 0; k < n.nu; ++k) {
      for (int l = 0; l < n.mu_s; ++l) {
        const Real mu_s = SunOf(l), nu = Possible(NuOf(k), mu, mu_s);
        Rgb<Real> rayleigh(0), mie(0);
        for (const Step<Real>& at : steps) {
          const Real mu_s_there = std::clamp((r * mu_s + at.d * nu) / at.r, Real(-1), Real(1));
          const Rgb<Real> light = at.weight * ToSun(tables_, mapping_, at.r, mu_s_there);
          rayleigh += at.densities.rayleigh * light;
          mie += at.densities.mie * light;
        }
        const std::size_t index = Base(i, j) + static_cast<std::size_t>(k * n.mu_s + l);
        rayleigh_[index] = rayleigh * beta_rayleigh;
        mie_[index] = mie * beta_mie;
        tables_.scattering[index] = {rayleigh_[index], mie_[index].x};
      }
    }
  }

  // J = sum over the kinds of density beta times the integral over all directions of phase times radiance, where the
  // radiance of light that was scattered once less is that of the ground or of the air. It depends on the height and
  // the sun, but not on the view, and is computed once for all views.
  bool MakeSources(int order) {
    return ForEachRow(1.0, tables_.sizes.r, tables_.sizes.mu_s, [&](int i, int l) { MakeSourcesUnder(i, l, order); });
  }

  void MakeSourcesUnder(int i, int l, int order) {
    static const Directions<Real> kDirections = MakeDirections<Real>();
    const AirTableSizes& n = tables_.sizes;
    const Air& air = tables_.air;
    const Real r = RadiusOf(i), mu_s = SunOf(l);
    const Real sun_x = std::sqrt(std::max(Real(1) - mu_s * mu_s, Real(0)));
    PhaseSums<Real> sums(static_cast<std::size_t>(n.mu * n.nu));
    for (int j = 0; j < n.mu; ++j) {
      const Real mu = ViewOfRow(mapping_, n.mu, j, r);
      const Real sine = std::sqrt(std::max(Real(1) - mu * mu, Real(0)));
      for (int k = 0; k < n.nu; ++k) {
        const Real nu = Possible(NuOf(k), mu, mu_s);
        const Real x = sun_x > 0 ? (nu - mu * mu_s) / sun_x : Real(0);
        const Real y = std::sqrt(std::max(sine * sine - x * x, Real(0)));
        sums.SetView(static_cast<std::size_t>(j * n.nu + k), x, y, mu);
      }
    }
    sums.Clear();
    const Real g = Real(air.mie_g);
    for (int ring = 0; ring < kRings; ++ring) {
      const auto first = static_cast<std::size_t>(ring * kParts);
      const Real mu = kDirections.z[first];
      const bool meets_ground = shell_.MeetsGround(r, mu);
      Real d = 0;
      Rgb<Real> ground(0);  // what is left of the light of a white ground, times the real one's albedo
      if (meets_ground) {
        d = shell_.DistanceToBottom(r, mu);
        ground = TransmittanceAlong(tables_, r, mu, d, true) * Real(air.ground_albedo / kPi);
      }
      for (int part = 0; part < kParts / 2; ++part) {  // the other half mirrors it
        const std::size_t at = first + static_cast<std::size_t>(part);
        const Real dx = kDirections.x[at], dy = kDirections.y[at], dz = kDirections.z[at];
        const Real nu = dx * sun_x + dz * mu_s;
        Rgb<Real> light = NewestRadiance(order - 1, i, r, mu, l, nu, meets_ground);
        if (meets_ground) {
          const Real mu_s_there = (r * mu_s + d * nu) / shell_.bottom;
          light += ground * IrradianceFrom(newest_irradiance_, shell_.bottom, mu_s_there);
        }
        light *= kDirections.solid_angle[at];
        sums.Add(dx, dy, dz, light, g);
        sums.Add(dx, -dy, dz, light, g);
      }
    }
    const Densities<Real> densities = DensitiesAt(air, r - shell_.bottom);
    const Rgb<Real> rayleigh = RayleighPhase(Real(0)) * densities.rayleigh * Rgb<Real>(air.rayleigh_per_m);
    const Real q = Real(1) + g * g;
    const Rgb<Real> mie = MiePhase(g, Real(0)) * q * std::sqrt(q) * densities.mie * Rgb<Real>(air.mie_per_m());
    for (int j = 0; j < n.mu; ++j) {
      for (int k = 0; k < n.nu; ++k) {
        const auto view = static_cast<std::size_t>(j * n.nu + k);
        sources_[Base(i, j) + static_cast<std::size_t>(k * n.mu_s + l)] =
            rayleigh * sums.rayleigh(view) + mie * sums.mie(view);
      }
    }
  }

  // At the radius and the sun of samples i and l.
  [[nodiscard]] Rgb<Real> NewestRadiance(int order, int i, Real r, Real mu, int l, Real nu, bool meets_ground) const {
    const AirTableSizes& n = tables_.sizes;
    const Between<Real> row = RowOfView(mapping_, n.mu, r, mu, meets_ground);
    const Between<Real> turn = PlaceAmong(n.nu, Real(0.5) * (nu + Real(1)));
    const auto from = [&](const Colors& colors) {
      const auto along = [&](int j) {
        const std::size_t base = Base(i, j) + static_cast<std::size_t>(l);
        return colors[base + static_cast<std::size_t>(turn.first * n.mu_s)] * (Real(1) - turn.share) +
               colors[base + static_cast<std::size_t>(turn.second * n.mu_s)] * turn.share;
      };
      return along(row.first) * (Real(1) - row.share) + along(row.second) * row.share;
    };
    if (order > 1) return from(newest_);
    return from(rayleigh_) * RayleighPhase(nu) + from(mie_) * MiePhase(Real(tables_.air.mie_g), nu);
  }

  [[nodiscard]] Rgb<Real> IrradianceFrom(const Colors& colors, Real r, Real mu_s) const {
    const AirTableSizes& n = tables_.sizes;
    const Real height = (r - shell_.bottom) / (shell_.top - shell_.bottom);
    return Mix(colors, n.irradiance_mu_s, PlaceAmong(n.irradiance_r, height),
               PlaceAmong(n.irradiance_mu_s, Real(0.5) * (mu_s + Real(1))));
  }

  // The integral over the upper half of all directions of radiance times its cosine.
  void MakeIndirectIrradiance(int order) {
    static const Directions<Real> kDirections = MakeDirections<Real>();
    const AirTableSizes& n = tables_.sizes;
    core::ForEach(workers_, static_cast<std::size_t>(n.irradiance_r), [&](std::size_t row) {
      const Real r = IrradianceRadius(static_cast<int>(row));
      for (int column = 0; column < n.irradiance_mu_s; ++column) {
        const Real mu_s = IrradianceSun(column);
        const Real sun_x = std::sqrt(std::max(Real(1) - mu_s * mu_s, Real(0)));
        Rgb<Real> sum(0);
        for (std::size_t k = 0; k < kDirections.z.size() / 2; ++k) {
          const Real dz = kDirections.z[k];
          const Real nu = kDirections.x[k] * sun_x + dz * mu_s;
          sum += dz * kDirections.solid_angle[k] * NewestRadianceAt(order - 1, r, dz, mu_s, nu);
        }
        const auto index = row * static_cast<std::size_t>(n.irradiance_mu_s) + static_cast<std::size_t>(column);
        newest_irradiance_[index] = sum;
        tables_.irradiance[index] += sum;
      }
    });
  }

  [[nodiscard]] Rgb<Real> NewestRadianceAt(int order, Real r, Real mu, Real mu_s, Real nu) const {
    const AirTableSizes& n = tables_.sizes;
    const Between<Real> height = PlaceAmong(n.r, mapping_.FromRadius(r));
    const Between<Real> sun = PlaceAmong(n.mu_s, mapping_.FromSun(mu_s));
    const auto at = [&](int i, int l) { return NewestRadiance(order, i, r, mu, l, nu, false); };
    const auto along = [&](int i) { return at(i, sun.first) * (Real(1) - sun.share) + at(i, sun.second) * sun.share; };
    return along(height.first) * (Real(1) - height.share) + along(height.second) * height.share;
  }

  // The integral along the ray of T J.
  bool MakeMultipleScattering() {
    const AirTableSizes& n = tables_.sizes;
    return ForEachRow(1.0, n.r, n.mu, [&](int i, int j) { MakeMultipleRow(i, j); });
  }

  // Where a step of a ray is in the tables, whatever the sun.
  struct Corner {
    std::array<std::size_t, 4> base{};
    std::array<Real, 4> share{};
    Rgb<Real> weight{0};
    Real d = 0;
    Real r = 0;
  };

  [[nodiscard]] std::vector<Corner> CornersAlong(Real r, Real mu, bool meets_ground) const {
    const AirTableSizes& n = tables_.sizes;
    std::vector<Corner> corners;
    for (const Step<Real>& at : StepsAlong(tables_.air, shell_, r, mu, meets_ground, kMultipleSteps)) {
      const Real mu_there = std::clamp((r * mu + at.d) / at.r, Real(-1), Real(1));
      const Between<Real> height = PlaceAmong(n.r, mapping_.FromRadius(at.r));
      const Between<Real> row = RowOfView(mapping_, n.mu, at.r, mu_there, meets_ground);
      Corner& corner = corners.emplace_back();
      corner.base = {Base(height.first, row.first), Base(height.first, row.second), Base(height.second, row.first),
                     Base(height.second, row.second)};
      corner.share = {(Real(1) - height.share) * (Real(1) - row.share), (Real(1) - height.share) * row.share,
                      height.share * (Real(1) - row.share), height.share * row.share};
      corner.weight = at.weight;
      corner.d = at.d;
      corner.r = at.r;
    }
    return corners;
  }

  void MakeMultipleRow(int i, int j) {
    const AirTableSizes& n = tables_.sizes;
    const Real r = RadiusOf(i), mu = ViewOfRow(mapping_, n.mu, j, r);
    const std::vector<Corner> corners = CornersAlong(r, mu, j < n.mu / 2);
    for (int k = 0; k < n.nu; ++k) {
      for (int l = 0; l < n.mu_s; ++l) {
        const Real mu_s = SunOf(l), nu = Possible(NuOf(k), mu, mu_s);
        const Between<Real> turn = PlaceAmong(n.nu, Real(0.5) * (nu + Real(1)));  // the same all along the ray
        Rgb<Real> sum(0);
        for (const Corner& at : corners) {
          const Real mu_s_there = std::clamp((r * mu_s + at.d * nu) / at.r, Real(-1), Real(1));
          const Between<Real> sun = PlaceAmong(n.mu_s, mapping_.FromSun(mu_s_there));
          Rgb<Real> source(0);
          for (std::size_t c = 0; c < 4; ++c) {
            const Rgb<Real>* first = &sources_[at.base[c] + static_cast<std::size_t>(turn.first * n.mu_s)];
            const Rgb<Real>* second = &sources_[at.base[c] + static_cast<std::size_t>(turn.second * n.mu_s)];
            const Real a = at.share[c] * (Real(1) - turn.share), b = at.share[c] * turn.share;
            source += (first[sun.first] * a + second[sun.first] * b) * (Real(1) - sun.share) +
                      (first[sun.second] * a + second[sun.second] * b) * sun.share;
          }
          sum += at.weight * source;
        }
        const std::size_t index = Base(i, j) + static_cast<std::size_t>(k * n.mu_s + l);
        newest_[index] = sum;
        tables_.scattering[index] += typename AirTables<Real>::Rgba(sum / RayleighPhase(nu), Real(0));
      }
    }
  }

  AirMapping<Real> mapping_;
  Shell<Real> shell_;
  core::ParallelFor* workers_;
  const AirProgress& progress_;
  double done_ = 0.0;
  AirTables<Real> tables_;
  Colors rayleigh_, mie_;     // scattered once, without phase functions
  Colors sources_;            // J of the order in work
  Colors newest_;             // radiance of that order
  Colors newest_irradiance_;  // of the order before: of the sun, then of the sky
};

}  // namespace

template <typename Real>
std::optional<AirTables<Real>> MakeAirTables(const Air& air, const AirTableSizes& sizes, core::ParallelFor* workers,
                                             const AirProgress& progress) {
  return Maker<Real>(air, sizes, workers, progress).Make();
}

// T = exp(-integral of the extinction along the ray).
template <typename Real>
Rgb<Real> TransmittanceThrough(const Air& air, Real r, Real mu, bool meets_ground) {
  const Shell<Real> shell{Real(air.bottom_m), Real(air.top_m)};
  const Real length = meets_ground ? shell.DistanceToBottom(r, mu) : shell.DistanceToTop(r, mu);
  const Real step = length / kThicknessSteps;
  Rgb<Real> thickness(0);
  for (int k = 0; k <= kThicknessSteps; ++k) {
    const Real height = shell.RadiusAfter(r, mu, Real(k) * step) - shell.bottom;
    thickness += (k == 0 || k == kThicknessSteps ? Real(0.5) : Real(1)) * ExtinctionOf(air, DensitiesAt(air, height));
  }
  return glm::exp(-step * thickness);
}

template <typename Real>
Rgb<Real> TransmittanceToTop(const AirTables<Real>& tables, Real r, Real mu) {
  return ToTop(tables, AirMapping<Real>(tables.air), r, mu);
}

template <typename Real>
Rgb<Real> TransmittanceToSun(const AirTables<Real>& tables, Real r, Real mu_s) {
  return ToSun(tables, AirMapping<Real>(tables.air), r, mu_s);
}

// The quotient of the ways to the top from both ends; backwards when the ray goes down to the ground.
template <typename Real>
Rgb<Real> TransmittanceAlong(const AirTables<Real>& tables, Real r, Real mu, Real d, bool meets_ground) {
  const Shell<Real> shell{Real(tables.air.bottom_m), Real(tables.air.top_m)};
  const Real r_there = shell.RadiusAfter(r, mu, d);
  const Real mu_there = std::clamp((r * mu + d) / r_there, Real(-1), Real(1));
  const Rgb<Real> whole =
      meets_ground ? TransmittanceToTop(tables, r_there, -mu_there) : TransmittanceToTop(tables, r, mu);
  const Rgb<Real> rest =
      meets_ground ? TransmittanceToTop(tables, r, -mu) : TransmittanceToTop(tables, r_there, mu_there);
  return glm::min(whole / glm::max(rest, Rgb<Real>(Real(1e-30))), Rgb<Real>(1));
}

template <typename Real>
Rgb<Real> SkyRadiance(const AirTables<Real>& tables, Real r, Real mu, Real mu_s, Real nu, bool meets_ground) {
  using Rgba = typename AirTables<Real>::Rgba;
  const AirMapping<Real> mapping(tables.air);
  const AirTableSizes& n = tables.sizes;
  const Between<Real> height = PlaceAmong(n.r, mapping.FromRadius(r));
  const Between<Real> row = RowOfView(mapping, n.mu, r, mu, meets_ground);
  const Between<Real> turn = PlaceAmong(n.nu, Real(0.5) * (nu + Real(1)));
  const Between<Real> sun = PlaceAmong(n.mu_s, mapping.FromSun(mu_s));
  Rgba sum(0);
  for (int corner = 0; corner < 16; ++corner) {
    const auto pick = [&](const Between<Real>& place, int bit, Real* share) {
      const bool is_second = (corner >> bit & 1) != 0;
      *share *= is_second ? place.share : Real(1) - place.share;
      return is_second ? place.second : place.first;
    };
    Real share = 1;
    const int i = pick(height, 0, &share), j = pick(row, 1, &share), k = pick(turn, 2, &share),
              l = pick(sun, 3, &share);
    sum += share * tables.scattering[static_cast<std::size_t>(((i * n.mu + j) * n.nu + k) * n.mu_s + l)];
  }
  // Green and blue of what aerosols scatter once, from its red: in the proportions of what molecules scatter.
  const Rgb<Real> rayleigh(sum);
  const Rgb<Real> mie = rayleigh.x > 0 ? rayleigh * (sum.w / rayleigh.x) * MieRatio<Real>(tables.air) : Rgb<Real>(0);
  return rayleigh * RayleighPhase(nu) + mie * MiePhase(Real(tables.air.mie_g), nu);
}

template <typename Real>
Rgb<Real> SkyIrradiance(const AirTables<Real>& tables, Real r, Real mu_s) {
  const AirTableSizes& n = tables.sizes;
  const Real height = (r - Real(tables.air.bottom_m)) / Real(tables.air.top_m - tables.air.bottom_m);
  return Mix(tables.irradiance, n.irradiance_mu_s, PlaceAmong(n.irradiance_r, height),
             PlaceAmong(n.irradiance_mu_s, Real(0.5) * (mu_s + Real(1))));
}

template <typename Real>
Rgb<Real> GroundIrradiance(const AirTables<Real>& tables, Real mu_s) {
  const Real r = Real(tables.air.bottom_m);
  return std::max(mu_s, Real(0)) * TransmittanceToSun(tables, r, mu_s) + SkyIrradiance(tables, r, mu_s);
}

// Float for pictures, double as the reference.
template std::optional<AirTables<float>> MakeAirTables(const Air&, const AirTableSizes&, core::ParallelFor*,
                                                       const AirProgress&);
template std::optional<AirTables<double>> MakeAirTables(const Air&, const AirTableSizes&, core::ParallelFor*,
                                                        const AirProgress&);
template Rgb<float> TransmittanceThrough(const Air&, float, float, bool);
template Rgb<double> TransmittanceThrough(const Air&, double, double, bool);
template Rgb<float> TransmittanceToTop(const AirTables<float>&, float, float);
template Rgb<double> TransmittanceToTop(const AirTables<double>&, double, double);
template Rgb<float> TransmittanceToSun(const AirTables<float>&, float, float);
template Rgb<double> TransmittanceToSun(const AirTables<double>&, double, double);
template Rgb<float> TransmittanceAlong(const AirTables<float>&, float, float, float, bool);
template Rgb<double> TransmittanceAlong(const AirTables<double>&, double, double, double, bool);
template Rgb<float> SkyRadiance(const AirTables<float>&, float, float, float, float, bool);
template Rgb<double> SkyRadiance(const AirTables<double>&, double, double, double, double, bool);
template Rgb<float> SkyIrradiance(const AirTables<float>&, float, float);
template Rgb<double> SkyIrradiance(const AirTables<double>&, double, double);
template Rgb<float> GroundIrradiance(const AirTables<float>&, float);
template Rgb<double> GroundIrradiance(const AirTables<double>&, double);

}  // namespace space
