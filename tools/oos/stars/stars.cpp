#include <cstdio>
#include <filesystem>
#include <string>

#include "core/read_file.hpp"
#include "core/write_file.hpp"
#include "space/stars/star_file.hpp"
#include "space/stars/tycho2.hpp"
#include "tools/oos/stars/verbs.hpp"
#include "vps/asset/cooked_object.hpp"

namespace oos {
namespace {

namespace fs = std::filesystem;

int RunStars(const Arguments& arguments) {
  const std::string index = arguments.text("--index", space::kTycho2File);
  const fs::path out = arguments.text("--out", (vps::DefaultCacheFolder() / space::kFullCatalogueName).string());
  auto bright = space::DecodeStars(space::BrightStarBytes());
  if (!bright) return Complain("stars", bright.error().detail, kDoesNotHold);
  const auto fits = core::ReadFile(index);
  if (!fits) {
    return Complain("stars",
                    index + ": " + fits.error().detail + "; it is of the package " + space::kTycho2Package +
                        ": sudo apt-get install " + space::kTycho2Package + ". Until then pictures have the " +
                        std::to_string(bright->size()) + " brightest stars",
                    kBadUsage);
  }
  auto tycho2 = space::ReadTycho2(*fits);
  if (!tycho2) return Complain("stars", index + ": " + tycho2.error().detail, kBadUsage);
  const std::size_t num_tycho2 = tycho2->size();
  space::MergedStars merged = space::MergeStars(std::move(*tycho2), *bright);
  const std::size_t num_stars = merged.stars.size();
  if (const auto written = core::WriteFile(out, space::EncodeStars(std::move(merged.stars))); !written) {
    return Complain("stars", written.error().detail, kDoesNotHold);
  }
  std::printf("%s: %zu stars, %zu of Tycho-2 and %zu of the bright list that it lacks\n", out.c_str(), num_stars,
              num_tycho2, num_stars - num_tycho2);
  return kHolds;
}

}  // namespace

Verb StarsVerb() {
  return {"stars",
          "builds the full star catalogue of the pictures",
          "",
          0,
          0,
          {{"--index", "FILE", "Tycho-2 as FITS; default: that of its Debian package"},
           {"--out", "FILE", "default: tycho2.stars in the cache, where visual_node finds it"}},
          RunStars,
          "1.87 million stars of Tycho-2, merged with the 118 216 bright ones that every viewer has."};
}

}  // namespace oos
