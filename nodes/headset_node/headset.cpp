#include "nodes/headset_node/headset.hpp"

#include <epoxy/gl.h>
#include <epoxy/glx.h>
// epoxy comes first: the others must not include GL headers of their own.
#define GLFW_INCLUDE_NONE
#define GLFW_EXPOSE_NATIVE_X11
#define GLFW_EXPOSE_NATIVE_GLX
#include <GLFW/glfw3.h>
#include <GLFW/glfw3native.h>
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#include <openxr/openxr_platform.h>

#include <algorithm>
#include <cstring>
#include <ctime>

namespace headset_node {
namespace {

constexpr XrViewConfigurationType kTwoEyes = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;

core::Result<void> Check(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return {};
  return core::Fail(core::ErrorCode::kResource, std::string("the headset's runtime: ") + call + " fails with " +
                                                    std::to_string(static_cast<int>(result)));
}

void Sleep_ms(long ms) {
  const timespec pause{0, ms * 1'000'000};
  nanosleep(&pause, nullptr);
}

core::Result<XrInstance> MakeInstance() {
  XrInstanceCreateInfo info{};
  info.type = XR_TYPE_INSTANCE_CREATE_INFO;
  std::strncpy(info.applicationInfo.applicationName, "VR-OOS", XR_MAX_APPLICATION_NAME_SIZE - 1);
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  const char* const extensions[] = {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME};
  info.enabledExtensionCount = 1;
  info.enabledExtensionNames = extensions;
  XrInstance instance = XR_NULL_HANDLE;
  const XrResult made = xrCreateInstance(&info, &instance);
  if (XR_SUCCEEDED(made)) return instance;
  if (made == XR_ERROR_EXTENSION_NOT_PRESENT) {
    return core::Fail(core::ErrorCode::kUnsupported, "the headset's runtime does not take pictures by OpenGL");
  }
  return core::Fail(core::ErrorCode::kNotFound,
                    "no OpenXR runtime answers; start the one of the headset's maker, or name its file in "
                    "XR_RUNTIME_JSON");
}

// The context that is current on the window, in X's terms.
XrGraphicsBindingOpenGLXlibKHR BindingOf(GLFWwindow* window) {
  XrGraphicsBindingOpenGLXlibKHR binding{};
  binding.type = XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR;
  binding.xDisplay = glfwGetX11Display();
  binding.glxContext = glfwGetGLXContext(window);
  binding.glxDrawable = glfwGetGLXWindow(window);
  int config_id = 0, number = 0;
  glXQueryContext(binding.xDisplay, binding.glxContext, GLX_FBCONFIG_ID, &config_id);
  const int wanted[] = {GLX_FBCONFIG_ID, config_id, None};
  GLXFBConfig* const configs = glXChooseFBConfig(binding.xDisplay, DefaultScreen(binding.xDisplay), wanted, &number);
  if (number < 1) return binding;
  binding.glxFBConfig = configs[0];
  if (XVisualInfo* const visual = glXGetVisualFromFBConfig(binding.xDisplay, configs[0])) {
    binding.visualid = static_cast<std::uint32_t>(visual->visualid);
    XFree(visual);
  }
  XFree(configs);
  return binding;
}

}  // namespace

core::Result<std::unique_ptr<Headset>> Headset::Open(GLFWwindow* window) {
  auto instance = MakeInstance();
  if (!instance) return tl::unexpected(instance.error());
  std::unique_ptr<Headset> headset(new Headset);
  headset->instance_ = *instance;
  if (auto found = headset->FindSystem(); !found) return tl::unexpected(found.error());
  if (auto begun = headset->BeginSession(window); !begun) return tl::unexpected(begun.error());
  if (auto made = headset->MakeSwapchains(); !made) return tl::unexpected(made.error());
  return headset;
}

Headset::~Headset() {
  for (Swapchain& swapchain : swapchains_) {
    swapchain.framebuffers.clear();
    if (swapchain.handle != XR_NULL_HANDLE) xrDestroySwapchain(swapchain.handle);
  }
  if (space_ != XR_NULL_HANDLE) xrDestroySpace(space_);
  if (session_ != XR_NULL_HANDLE) xrDestroySession(session_);
  if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
}

core::Result<void> Headset::FindSystem() {
  XrSystemGetInfo wanted{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  if (XR_FAILED(xrGetSystem(instance_, &wanted, &system_))) {
    return core::Fail(core::ErrorCode::kNotFound, "the OpenXR runtime knows no headset; is it plugged in?");
  }
  XrInstanceProperties runtime{};
  runtime.type = XR_TYPE_INSTANCE_PROPERTIES;
  XrSystemProperties properties{};
  properties.type = XR_TYPE_SYSTEM_PROPERTIES;
  if (auto known = Check(xrGetInstanceProperties(instance_, &runtime), "xrGetInstanceProperties"); !known) return known;
  if (auto known = Check(xrGetSystemProperties(instance_, system_, &properties), "xrGetSystemProperties"); !known) {
    return known;
  }
  std::array<XrViewConfigurationView, kNumEyes> views{};
  for (XrViewConfigurationView& view : views) view.type = XR_TYPE_VIEW_CONFIGURATION_VIEW;
  std::uint32_t number = 0;
  const XrResult told =
      xrEnumerateViewConfigurationViews(instance_, system_, kTwoEyes, kNumEyes, &number, views.data());
  if (auto known = Check(told, "xrEnumerateViewConfigurationViews"); !known) return known;
  size_px_ = {static_cast<int>(views[0].recommendedImageRectWidth),
              static_cast<int>(views[0].recommendedImageRectHeight)};
  description_ = std::string(properties.systemName) + " by " + runtime.runtimeName;
  return {};
}

core::Result<void> Headset::BeginSession(GLFWwindow* window) {
  PFN_xrGetOpenGLGraphicsRequirementsKHR get_requirements = nullptr;
  const XrResult found = xrGetInstanceProcAddr(instance_, "xrGetOpenGLGraphicsRequirementsKHR",
                                               reinterpret_cast<PFN_xrVoidFunction*>(&get_requirements));
  if (auto known = Check(found, "xrGetInstanceProcAddr"); !known) return known;
  XrGraphicsRequirementsOpenGLKHR requirements{};
  requirements.type = XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR;
  if (auto told = Check(get_requirements(instance_, system_, &requirements), "xrGetOpenGLGraphicsRequirementsKHR");
      !told) {
    return told;
  }
  const XrGraphicsBindingOpenGLXlibKHR binding = BindingOf(window);
  const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, &binding, 0, system_};
  if (auto made = Check(xrCreateSession(instance_, &info, &session_), "xrCreateSession"); !made) return made;
  XrReferenceSpaceCreateInfo space{};
  space.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
  space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;  // its origin: where the head was at first
  space.poseInReferenceSpace.orientation.w = 1.0f;
  return Check(xrCreateReferenceSpace(session_, &space, &space_), "xrCreateReferenceSpace");
}

// Pictures hold sRGB, as developed; so do the images.
core::Result<void> Headset::MakeSwapchains() {
  std::uint32_t number = 0;
  xrEnumerateSwapchainFormats(session_, 0, &number, nullptr);
  std::vector<std::int64_t> formats(number);
  xrEnumerateSwapchainFormats(session_, number, &number, formats.data());
  if (std::find(formats.begin(), formats.end(), GL_SRGB8_ALPHA8) == formats.end()) {
    return core::Fail(core::ErrorCode::kUnsupported, "the headset's runtime has no images of 8-bit sRGB");
  }
  XrSwapchainCreateInfo info{};
  info.type = XR_TYPE_SWAPCHAIN_CREATE_INFO;
  info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT;
  info.format = GL_SRGB8_ALPHA8;
  info.sampleCount = info.faceCount = info.arraySize = info.mipCount = 1;
  info.width = static_cast<std::uint32_t>(size_px_.x);
  info.height = static_cast<std::uint32_t>(size_px_.y);
  for (Swapchain& swapchain : swapchains_) {
    if (auto made = Check(xrCreateSwapchain(session_, &info, &swapchain.handle), "xrCreateSwapchain"); !made) {
      return made;
    }
    xrEnumerateSwapchainImages(swapchain.handle, 0, &number, nullptr);
    XrSwapchainImageOpenGLKHR none{};
    none.type = XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR;
    std::vector<XrSwapchainImageOpenGLKHR> images(number, none);
    const XrResult told = xrEnumerateSwapchainImages(swapchain.handle, number, &number,
                                                     reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data()));
    if (auto known = Check(told, "xrEnumerateSwapchainImages"); !known) return known;
    for (const XrSwapchainImageOpenGLKHR& image : images) {
      GLuint name = 0;
      glCreateFramebuffers(1, &name);
      glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, image.image, 0);
      swapchain.framebuffers.emplace_back(name);
    }
  }
  return {};
}

core::Result<void> Headset::TakeEvents() {
  for (;;) {
    XrEventDataBuffer event{};
    event.type = XR_TYPE_EVENT_DATA_BUFFER;
    const XrResult polled = xrPollEvent(instance_, &event);
    if (polled == XR_EVENT_UNAVAILABLE) return {};
    if (auto good = Check(polled, "xrPollEvent"); !good) return good;
    if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) is_over_ = true;
    if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    XrEventDataSessionStateChanged changed{};
    std::memcpy(&changed, &event, sizeof changed);
    if (changed.state == XR_SESSION_STATE_READY) {
      const XrSessionBeginInfo begin{XR_TYPE_SESSION_BEGIN_INFO, nullptr, kTwoEyes};
      if (auto begun = Check(xrBeginSession(session_, &begin), "xrBeginSession"); !begun) return begun;
      is_running_ = true;
    } else if (changed.state == XR_SESSION_STATE_STOPPING) {
      is_running_ = false;
      if (auto ended = Check(xrEndSession(session_), "xrEndSession"); !ended) return ended;
    } else if (changed.state == XR_SESSION_STATE_EXITING || changed.state == XR_SESSION_STATE_LOSS_PENDING) {
      is_over_ = true;
    }
  }
}

core::Result<bool> Headset::BeginFrame() {
  if (auto taken = TakeEvents(); !taken) return tl::unexpected(taken.error());
  if (!is_running_ || is_over_) {
    Sleep_ms(10);
    return false;
  }
  XrFrameState state{};
  state.type = XR_TYPE_FRAME_STATE;
  if (auto waited = Check(xrWaitFrame(session_, nullptr, &state), "xrWaitFrame"); !waited) {
    return tl::unexpected(waited.error());
  }
  if (auto begun = Check(xrBeginFrame(session_, nullptr), "xrBeginFrame"); !begun) {
    return tl::unexpected(begun.error());
  }
  time_ = state.predictedDisplayTime;
  XrViewState known{};
  known.type = XR_TYPE_VIEW_STATE;
  for (XrView& eye : eyes_) eye.type = XR_TYPE_VIEW;
  const XrViewLocateInfo where{XR_TYPE_VIEW_LOCATE_INFO, nullptr, kTwoEyes, time_, space_};
  std::uint32_t number = 0;
  const XrResult located = xrLocateViews(session_, &where, &known, kNumEyes, &number, eyes_.data());
  if (auto good = Check(located, "xrLocateViews"); !good) return tl::unexpected(good.error());
  constexpr XrViewStateFlags kWhole = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
  if (state.shouldRender == XR_TRUE && (known.viewStateFlags & kWhole) == kWhole) return true;
  const XrFrameEndInfo nothing{XR_TYPE_FRAME_END_INFO, nullptr, time_, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0, nullptr};
  if (auto ended = Check(xrEndFrame(session_, &nothing), "xrEndFrame"); !ended) return tl::unexpected(ended.error());
  return false;
}

core::Result<void> Headset::Show(std::size_t eye, const visual_node::RenderTarget& picture) {
  Swapchain& swapchain = swapchains_[eye];
  std::uint32_t index = 0;
  const XrSwapchainImageAcquireInfo acquire{XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO, nullptr};
  if (auto got = Check(xrAcquireSwapchainImage(swapchain.handle, &acquire, &index), "xrAcquireSwapchainImage"); !got) {
    return got;
  }
  const XrSwapchainImageWaitInfo wait{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, XR_INFINITE_DURATION};
  if (auto free = Check(xrWaitSwapchainImage(swapchain.handle, &wait), "xrWaitSwapchainImage"); !free) return free;
  glDisable(GL_FRAMEBUFFER_SRGB);  // bytes are copied as they are
  glBlitNamedFramebuffer(picture.framebuffer(), swapchain.framebuffers[index].id(), 0, 0, picture.width(),
                         picture.height(), 0, 0, size_px_.x, size_px_.y, GL_COLOR_BUFFER_BIT, GL_LINEAR);
  const XrSwapchainImageReleaseInfo release{XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO, nullptr};
  return Check(xrReleaseSwapchainImage(swapchain.handle, &release), "xrReleaseSwapchainImage");
}

core::Result<void> Headset::EndFrame() {
  std::array<XrCompositionLayerProjectionView, kNumEyes> views{};
  for (std::size_t eye = 0; eye < kNumEyes; ++eye) {
    views[eye].type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
    views[eye].pose = eyes_[eye].pose;
    views[eye].fov = eyes_[eye].fov;
    views[eye].subImage.swapchain = swapchains_[eye].handle;
    views[eye].subImage.imageRect.extent = {size_px_.x, size_px_.y};
  }
  const XrCompositionLayerProjection layer{
      XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, space_, kNumEyes, views.data()};
  const auto* const layers = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
  const XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO, nullptr, time_, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 1, &layers};
  return Check(xrEndFrame(session_, &info), "xrEndFrame");
}

}  // namespace headset_node
