#include "nodes/visual_node/window/menu.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace visual_node {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";  // else ImGui's own
constexpr float kLetter_px = 15.0f;

// Positions in pixels from the top left corner. Colours are for the screen, as the picture beneath is.
constexpr const char* kMenuVertex = R"(#version 450 core
layout(location = 0) in vec2 a_px;
layout(location = 1) in vec2 a_uv;
layout(location = 2) in vec4 a_color;
layout(location = 0) uniform vec2 u_size_px;
out vec2 v_uv;
out vec4 v_color;
void main() {
  v_uv = a_uv;
  v_color = a_color;
  vec2 p = 2.0 * a_px / u_size_px - 1.0;
  gl_Position = vec4(p.x, -p.y, 0.0, 1.0);
}
)";
constexpr const char* kMenuFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_coverage;
in vec2 v_uv;
in vec4 v_color;
out vec4 o_color;
void main() { o_color = vec4(v_color.rgb, v_color.a * texture(u_coverage, v_uv).r); }
)";

void AddOverlayEntries(view::Choices* choices) {
  for (const view::OverlayInfo& info : view::kOverlays) {
    bool is_on = choices->has(info.overlay);
    const std::string entry = std::string(1, info.key) + "   " + info.what;
    if (ImGui::Checkbox(entry.c_str(), &is_on)) choices->overlays[view::IndexOf(info.overlay)] = is_on;
  }
}

void AddStereoEntries(view::Choices* choices) {
  if (!ImGui::CollapsingHeader("Two eyes (shown when the menu is closed)")) return;
  const auto entry = [&](view::Stereo mode, const char* what) {
    if (ImGui::RadioButton(what, choices->stereo == mode)) choices->stereo = mode;
  };
  entry(view::Stereo::kNone, "one picture for both");
  for (const view::StereoInfo& info : view::kStereoModes) entry(info.mode, info.what);
  float eyes_mm = 1e3f * static_cast<float>(choices->eye_distance_m);
  if (ImGui::SliderFloat("mm between the eyes", &eyes_mm, 0.0f, 1e3f * static_cast<float>(view::kMostEyeDistance_m))) {
    choices->eye_distance_m = 1e-3 * static_cast<double>(eyes_mm);
  }
}

void AddObjectEntries(const std::vector<std::string>& objects, view::Choices* choices) {
  choices->objects.resize(std::max(choices->objects.size(), objects.size()));
  std::string title = "Parts:";
  for (const view::PartChoice& choice : view::kPartChoices) {
    title += std::string(" ") + choice.what + " (" + choice.key + ")";
  }
  if (!ImGui::CollapsingHeader(title.c_str())) return;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    view::Choices::Object& object = choices->objects[i];
    ImGui::PushID(static_cast<int>(i));
    for (const view::PartChoice& choice : view::kPartChoices) {
      ImGui::Checkbox((std::string("##") + choice.name).c_str(), &(object.*choice.flag));
      ImGui::SameLine();
    }
    const bool is_selected = choices->selected == static_cast<int>(i);
    if (ImGui::Selectable(objects[i].c_str(), is_selected)) choices->selected = is_selected ? -1 : static_cast<int>(i);
    ImGui::PopID();
  }
}

}  // namespace

core::Result<std::unique_ptr<Menu>> Menu::Create() {
  std::unique_ptr<Menu> menu(new Menu);
  auto program = MakeProgram("menu", kMenuVertex, kMenuFragment);
  if (!program) return tl::unexpected(program.error());
  menu->program_ = std::move(*program);
  menu->layout_ = MakeVertexArray();
  const GLuint layout = menu->layout_.id();
  for (const GLuint attribute : {0u, 1u, 2u}) {
    glEnableVertexArrayAttrib(layout, attribute);
    glVertexArrayAttribBinding(layout, attribute, 0);
  }
  glVertexArrayAttribFormat(layout, 0, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, pos));
  glVertexArrayAttribFormat(layout, 1, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, uv));
  glVertexArrayAttribFormat(layout, 2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(ImDrawVert, col));
  menu->imgui_ = ImGui::CreateContext();
  ImGui::SetCurrentContext(menu->imgui_);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // leaves no file behind
  if (std::filesystem::exists(kFont)) io.Fonts->AddFontFromFileTTF(kFont, kLetter_px);
  std::uint8_t* coverage = nullptr;
  int width = 0, height = 0;
  io.Fonts->GetTexDataAsAlpha8(&coverage, &width, &height);
  menu->font_ = MakeTexture(GL_R8, width, height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(menu->font_.id(), 0, 0, 0, width, height, GL_RED, GL_UNSIGNED_BYTE, coverage);
  return menu;
}

Menu::~Menu() {
  if (imgui_ != nullptr) ImGui::DestroyContext(imgui_);
}

void Menu::Draw(const MenuInput& input, const std::vector<std::string>& objects, const RenderTarget& target,
                view::Choices* choices) {
  ImGui::SetCurrentContext(imgui_);
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(static_cast<float>(target.width()), static_cast<float>(target.height()));
  io.DeltaTime = static_cast<float>(std::max(1e-4, input.dt_s));
  io.MousePos = ImVec2(static_cast<float>(input.mouse_px.x), static_cast<float>(input.mouse_px.y));
  io.MouseDown[0] = input.is_mouse_down;
  io.MouseWheel = static_cast<float>(input.scroll);
  ImGui::NewFrame();
  ImGui::SetNextWindowPos(ImVec2(10.0f, 0.2f * io.DisplaySize.y), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize(ImVec2(470.0f, 0.75f * io.DisplaySize.y), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowBgAlpha(0.85f);
  if (ImGui::Begin("What is shown (Tab closes)")) {
    AddOverlayEntries(choices);
    AddStereoEntries(choices);
    AddObjectEntries(objects, choices);
  }
  ImGui::End();
  ImGui::Render();
  has_mouse_ = io.WantCaptureMouse;
  Paint(*ImGui::GetDrawData(), target);
}

void Menu::Paint(const ImDrawData& data, const RenderTarget& target) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, target.width(), target.height());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glEnable(GL_SCISSOR_TEST);
  glUseProgram(program_.id());
  glUniform2f(0, static_cast<float>(target.width()), static_cast<float>(target.height()));
  glBindTextureUnit(0, font_.id());
  glBindVertexArray(layout_.id());
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    const GlBuffer vertices =
        MakeBuffer(list.VtxBuffer.Data, static_cast<std::size_t>(list.VtxBuffer.Size) * sizeof(ImDrawVert));
    const GlBuffer indices =
        MakeBuffer(list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.Size) * sizeof(ImDrawIdx));
    glVertexArrayVertexBuffer(layout_.id(), 0, vertices.id(), 0, sizeof(ImDrawVert));
    glVertexArrayElementBuffer(layout_.id(), indices.id());
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      const auto width = static_cast<GLsizei>(clip.z - clip.x), height = static_cast<GLsizei>(clip.w - clip.y);
      if (width <= 0 || height <= 0) continue;
      glScissor(static_cast<GLint>(clip.x), target.height() - static_cast<GLint>(clip.w), width, height);
      const std::uintptr_t first_byte = command.IdxOffset * sizeof(ImDrawIdx);
      // OpenGL passes an offset into the bound buffer as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
      const auto* const offset = reinterpret_cast<const void*>(first_byte);
      const GLenum type = sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT;
      glDrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.ElemCount), type, offset,
                               static_cast<GLint>(command.VtxOffset));
    }
  }
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
}

}  // namespace visual_node
