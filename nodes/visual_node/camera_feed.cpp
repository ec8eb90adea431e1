#include "nodes/visual_node/camera_feed.hpp"

#include <algorithm>

#include "core/clock.hpp"

namespace visual_node {
namespace {

constexpr int kInsetShare = 4;  // of the window's width and height

Look WithoutTexts(const Look& look) {
  Look plain = look;
  plain.scale = 1.0;
  plain.with_texts = false;
  plain.with_penumbra = false;
  return plain;
}

// A camera on a part sees parts, not what is drawn to explain them.
view::Scene WithoutOverlays(const view::Scene& scene) {
  view::Scene plain = scene;
  plain.arrows.clear();
  plain.rings.clear();
  plain.lines.clear();
  plain.points.clear();
  plain.axes.clear();
  plain.phantoms.clear();
  for (view::Instance& instance : plain.instances) instance.highlight = 0.0f;
  return plain;
}

std::int64_t Period_ns(double rate_hz) {
  const double rate = std::min(rate_hz, CameraFeed::kMostPerSecond);
  return static_cast<std::int64_t>(static_cast<double>(core::kNanosecondsPerSecond) / rate);
}

}  // namespace

int CameraFeed::MountedCamera(const view::Assets& assets) {
  for (std::size_t i = 0; i < assets.cameras.size(); ++i) {
    if (assets.cameras[i].is_mounted) return static_cast<int>(i);
  }
  return -1;
}

core::Result<std::vector<CameraFeed::Seen>> CameraFeed::Take(const view::Scene& scene,
                                                             const std::vector<double>& rates_hz, const Look& look,
                                                             std::int64_t now_ns) {
  std::vector<Seen> seen;
  next_ns_.resize(rates_hz.size());
  for (std::size_t i = 0; i < rates_hz.size(); ++i) {
    if (rates_hz[i] <= 0.0 || now_ns < next_ns_[i]) continue;
    next_ns_[i] = now_ns + Period_ns(rates_hz[i]);
    if (small_ == nullptr) small_ = std::make_unique<RenderTarget>(kTopicWidth, kTopicHeight);
    const auto drawn = renderer_->Draw(WithoutOverlays(scene), scene.assets->cameras[i], *small_, WithoutTexts(look));
    if (!drawn) return tl::unexpected(drawn.error());
    const Image picture = small_->Read();
    Seen one{i, {}};
    one.image.time_ns = scene.time_ns;
    one.image.width = kTopicWidth;
    one.image.height = kTopicHeight;
    for (std::size_t k = 0; k < picture.rgba.size(); k += 4) {
      one.image.rgb.append({static_cast<char>(picture.rgba[k]), static_cast<char>(picture.rgba[k + 1]),
                            static_cast<char>(picture.rgba[k + 2])});
    }
    seen.push_back(std::move(one));
  }
  return seen;
}

core::Result<void> CameraFeed::DrawInset(const view::Scene& scene, const Look& look, std::int64_t now_ns, double aspect,
                                         const RenderTarget& target) {
  const int camera = MountedCamera(*scene.assets);
  if (camera < 0) return {};
  const int width = target.width() / kInsetShare, height = target.height() / kInsetShare;
  const bool has_size = inset_ != nullptr && inset_->width() == width && inset_->height() == height;
  if (!has_size || now_ns >= next_inset_ns_) {
    next_inset_ns_ = now_ns + Period_ns(kMostPerSecond);
    if (!has_size) inset_ = std::make_unique<RenderTarget>(width, height);
    const scene::Camera placed = view::PlaceCamera(scene.assets->cameras[static_cast<std::size_t>(camera)], scene);
    const auto drawn =
        renderer_->Draw(WithoutOverlays(scene), view::FrustumOf(placed, aspect), *inset_, WithoutTexts(look));
    if (!drawn) return drawn;
  }
  const int margin = target.height() / 36, bottom = target.height() / 5;  // above the caption
  const int frame = std::max(1, target.height() / 360);
  const float grey[4] = {0.55f, 0.62f, 0.70f, 1.0f};
  glEnable(GL_SCISSOR_TEST);
  glScissor(target.width() - margin - width - frame, bottom - frame, width + 2 * frame, height + 2 * frame);
  glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, grey);
  glDisable(GL_SCISSOR_TEST);
  glBlitNamedFramebuffer(inset_->framebuffer(), target.framebuffer(), 0, 0, width, height,
                         target.width() - margin - width, bottom, target.width() - margin, bottom + height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return {};
}

core::Result<void> AddInset(Renderer& renderer, const view::Scene& scene, const view::Choices& choices,
                            view::Stereo stereo, const RenderTarget& target) {
  if (!choices.has(view::Overlay::kCamera) || stereo != view::Stereo::kNone) return {};
  const double aspect = static_cast<double>(target.width()) / target.height();
  return CameraFeed(&renderer).DrawInset(scene, {}, 0, aspect, target);
}

}  // namespace visual_node
