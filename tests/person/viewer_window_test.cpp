// Keys, clicks and sizes of a viewer's window: real X events under an X server of the test's own.

#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>

#include "core/clock.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/window/fit_target.hpp"
#include "nodes/visual_node/window/interaction.hpp"
#include "nodes/visual_node/window/saved_views.hpp"
#include "scene/load_scenario.hpp"
#include "tests/person/window.hpp"
#include "view/projection.hpp"
#include "view/scene_mirror.hpp"

namespace person_tests {
namespace {

using view::Choices;

constexpr int kWidth = 640, kHeight = 360;
constexpr std::int64_t kPatience_ns = 20 * core::kNanosecondsPerSecond;

// As xdotool calls it.
std::string NameOf(char key) {
  switch (key) {
    case ',':
      return "comma";
    case '.':
      return "period";
    case ';':
      return "semicolon";
    case '=':
      return "equal";
    case '/':
      return "slash";
    default:
      return {static_cast<char>(std::tolower(static_cast<unsigned char>(key)))};
  }
}

class ViewerWindow : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (const std::string missing = Window::MissingProgram(); !missing.empty()) {
      why_ = missing + " is missing; ./dev test installs it (apt-test.txt)";
      return;
    }
    screen_ = std::make_unique<Window>();
    ASSERT_TRUE(screen_->Open());
    setenv("LP_NUM_THREADS", "1", 0);
    auto context = visual_node::GlContext::Create({.width = kWidth, .height = kHeight, .is_placed = true});
    ASSERT_TRUE(context) << context.error().detail;
    context_ = std::move(*context);
    visual_node::KeepDriverLoaded();
    ASSERT_TRUE(screen_->WaitForWindow(20.0));
  }
  static void TearDownTestSuite() {
    context_.reset();
    screen_.reset();
  }

  void SetUp() override {
    if (!why_.empty()) GTEST_SKIP() << why_;
    auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/touch");
    ASSERT_TRUE(scenario);
    scenario_ = std::move(*scenario);
    scene_ = view::SceneMirror(scenario_).scene();
    auto renderer = visual_node::Renderer::Create(
        scene_, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
    ASSERT_TRUE(renderer) << renderer.error().detail;
    renderer_ = std::move(*renderer);
    target_ = std::make_unique<visual_node::RenderTarget>(kWidth, kHeight);
    receiver_ = std::make_unique<visual_node::Receiver>(scenario_, &log_);
    interaction_.emplace(receiver_.get(), renderer_.get());
    control_.emplace(*scene_.assets, "");
    control_->Attach(context_->window());
    composition_.layout.rows = {{""}};
    screen_->MoveTo(kWidth - 20, 20);  // keys go to the window below the mouse; there is nothing of the scene
  }

  // Frames of the viewer's loop, until what a person did is seen.
  bool Until(const std::function<bool()>& is_seen) {
    for (const std::int64_t begin_ns = core::MonotonicNow_ns(); core::MonotonicNow_ns() - begin_ns < kPatience_ns;) {
      glfwWaitEventsTimeout(0.02);
      visual_node::FitTo(context_->window(), &target_);
      camera_ = control_->Update(*scene_.assets, "", 0.0);
      const auto wishes = interaction_->Take({scene_, camera_, composition_}, *target_, &*control_);
      EXPECT_TRUE(wishes) << wishes.error().detail;
      if (!wishes) return false;
      if (wishes->is_full_screen_wanted) context_->ToggleFullScreen();
      num_pictures_wanted_ += wishes->is_screenshot_wanted ? 1 : 0;
      num_views_saved_ += wishes->is_view_saved ? 1 : 0;
      if (is_seen()) return true;
    }
    return false;
  }
  bool Press(const std::string& key, const std::function<bool()>& is_seen) {
    screen_->Press(key);
    return Until(is_seen);
  }
  bool HasSize(int width, int height) const { return target_->width() == width && target_->height() == height; }
  Choices::Object Selected() const {
    const Choices choices = receiver_->choices();
    return choices.objects.at(static_cast<std::size_t>(choices.selected));
  }
  int IndexOf(const std::string& name) const {
    const std::vector<std::string>& names = scene_.assets->instance_names;
    return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
  }
  void ClickAt(const glm::dvec2& px) {
    screen_->MoveTo(static_cast<int>(px.x), static_cast<int>(px.y));
    screen_->HoldButton(1, true);
    screen_->HoldButton(1, false);
  }
  glm::dvec2 PlaceOf(int object) const {
    const core::Pose& X_WM = scene_.instances[static_cast<std::size_t>(object)].X_WM;
    return glm::dvec2(view::ProjectToPixel(camera_, target_->width(), target_->height(), X_WM.translation));
  }

  static inline std::string why_;
  static inline std::unique_ptr<Window> screen_;
  static inline std::unique_ptr<visual_node::GlContext> context_;
  scene::Scenario scenario_;
  view::Scene scene_;
  visual_node::LatencyLog log_;
  std::unique_ptr<visual_node::Renderer> renderer_;
  std::unique_ptr<visual_node::RenderTarget> target_;
  std::unique_ptr<visual_node::Receiver> receiver_;
  std::optional<visual_node::Interaction> interaction_;
  std::optional<visual_node::CameraControl> control_;
  visual_node::Composition composition_;
  scene::Camera camera_;
  int num_pictures_wanted_ = 0, num_views_saved_ = 0;
};

TEST_F(ViewerWindow, TheKeyOfEachOverlayTogglesIt) {
  for (const view::OverlayInfo& info : view::kOverlays) {
    EXPECT_TRUE(Press(NameOf(info.key), [&] { return receiver_->choices().has(info.overlay) != info.is_on_at_start; }))
        << info.name;
  }
  EXPECT_TRUE(Press("c", [&] { return receiver_->choices().has(view::Overlay::kContacts); })) << "back";
}

TEST_F(ViewerWindow, AClickSelectsWhatIsUnderItAndASecondOneLetsItGo) {
  ASSERT_TRUE(Until([] { return true; }));
  for (const char* name : {"block", "ball"}) {
    const int object = IndexOf(name);
    ClickAt(PlaceOf(object));
    EXPECT_TRUE(Until([&] { return receiver_->choices().selected == object; })) << name;
  }
  ClickAt(PlaceOf(IndexOf("ball")));
  EXPECT_TRUE(Until([&] { return receiver_->choices().selected == -1; }));
}

TEST_F(ViewerWindow, KeysOfAPartActOnTheSelectedOne) {
  ASSERT_TRUE(Until([] { return true; }));
  const int block = IndexOf("block");
  ClickAt(PlaceOf(block));
  ASSERT_TRUE(Until([&] { return receiver_->choices().selected == block; }));
  for (const view::PartChoice& choice : view::kPartChoices) {
    EXPECT_TRUE(Press(NameOf(choice.key), [&] { return Selected().*choice.flag; })) << choice.name;
    EXPECT_TRUE(Press(NameOf(choice.key), [&] { return !(Selected().*choice.flag); })) << choice.name;
  }
  ASSERT_TRUE(Press("x", [&] { return Selected().is_hidden; }));
  EXPECT_TRUE(Press("BackSpace", [&] {
    return receiver_->choices().selected == -1 && receiver_->choices().objects.empty();
  })) << "all as it was";
}

TEST_F(ViewerWindow, TabOpensTheMenuAndPTakesAPicture) {
  EXPECT_TRUE(Press("Tab", [&] { return interaction_->is_menu_open(); }));
  EXPECT_TRUE(Press("Tab", [&] { return !interaction_->is_menu_open(); }));
  EXPECT_TRUE(Press("p", [&] { return num_pictures_wanted_ == 1; }));
}

TEST_F(ViewerWindow, JFollowsTheSelectedPartAndLeavesIt) {
  const int block = IndexOf("block");
  receiver_->Choose([&](Choices& choices) { choices.selected = block; });
  EXPECT_TRUE(Press("j", [&] { return camera_.object == block; }));
  EXPECT_TRUE(Press("j", [&] { return camera_.object == -1; }));
}

TEST_F(ViewerWindow, AViewThatIsKeptHasANumberAlsoInTheNextWindow) {
  const std::vector<scene::Camera>& named = scene_.assets->cameras;
  ASSERT_EQ(named.size(), 2u);
  EXPECT_TRUE(Press("2", [&] { return camera_.eye_m == named[1].eye_m; }));
  screen_->Wheel(3);
  ASSERT_TRUE(Until([&] { return camera_.eye_m != named[1].eye_m; }));
  ASSERT_TRUE(Press("y", [&] { return num_views_saved_ == 1; }));
  const scene::Camera kept = control_->saved_views().back();
  EXPECT_NE(kept.eye_m, named[1].eye_m);
  EXPECT_TRUE(Press("1", [&] { return camera_.eye_m == named[0].eye_m; }));
  EXPECT_TRUE(Press("3", [&] { return camera_.eye_m == kept.eye_m; }));

  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "viewer_window_views.xml";
  ASSERT_TRUE(visual_node::WriteViews(file, control_->saved_views(), *scene_.assets));
  auto views = visual_node::ReadViews(file, *scene_.assets);
  std::filesystem::remove(file);
  ASSERT_TRUE(views) << views.error().detail;
  control_.emplace(*scene_.assets, "");
  control_->Attach(context_->window());
  control_->SetSavedViews(std::move(*views));
  EXPECT_TRUE(Press("3", [&] { return glm::distance(camera_.eye_m, kept.eye_m) < 1e-3; }));
}

TEST_F(ViewerWindow, F11FillsTheScreenAndGivesItBack) {
  ASSERT_TRUE(Until([&] { return HasSize(kWidth, kHeight); }));
  EXPECT_TRUE(Press("F11", [&] { return HasSize(Window::kWidth, Window::kHeight); }));
  EXPECT_TRUE(Press("F11", [&] { return HasSize(kWidth, kHeight); }));
}

TEST_F(ViewerWindow, APictureIsAsLargeAsTheWindowAndClicksMeetWhatItShows) {
  for (const glm::ivec2 size : {glm::ivec2(800, 300), glm::ivec2(400, 500), glm::ivec2(kWidth, kHeight)}) {
    screen_->Resize(size.x, size.y);
    ASSERT_TRUE(Until([&] { return HasSize(size.x, size.y); })) << size.x << " x " << size.y;
    ASSERT_TRUE(renderer_->Draw(scene_, camera_, *target_));
    EXPECT_EQ(target_->Read().width, size.x);
    const int block = IndexOf("block");
    receiver_->Choose([](Choices& choices) { choices.selected = -1; });
    ClickAt(PlaceOf(block));
    EXPECT_TRUE(Until([&] { return receiver_->choices().selected == block; })) << size.x << " x " << size.y;
  }
}

}  // namespace
}  // namespace person_tests
