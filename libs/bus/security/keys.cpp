#include "bus/security/keys.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <fstream>
#include <system_error>

#include "bus/security/sealing.hpp"

namespace bus {
namespace {

constexpr std::size_t kKeyCharacters = 40;
constexpr const char* kAllowedFile = "allowed";

using Path = std::filesystem::path;

core::Result<void> WritePrivately(const Path& file, const std::string& text, int flags) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0600);
  const bool is_written = fd >= 0 && write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (fd >= 0) close(fd);
  if (is_written) return {};
  return core::Fail(core::ErrorCode::kIo, "cannot write the key file " + file.string() + ": " +
                                              std::error_code(error, std::generic_category()).message());
}

core::Result<void> CheckPrivate(const Path& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "there is no " + path.string() + "; 'oos run' makes a run's key directory, keys/ in its folder");
  }
  if (info.st_uid != geteuid()) {  // the owner could change it at any time
    return core::Fail(core::ErrorCode::kInvalidInput, path.string() + " belongs to user " +
                                                          std::to_string(info.st_uid) + "; take keys that user " +
                                                          std::to_string(geteuid()) + " made, or chown them");
  }
  if ((info.st_mode & 077) == 0) return {};
  return core::Fail(core::ErrorCode::kInvalidInput,
                    path.string() + " can be read by others; keys need chmod 700 (directory) and 600 (files)");
}

bool IsKey(const std::string& text) {
  std::array<std::uint8_t, 32> bytes;
  return text.size() == kKeyCharacters && zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

bool IsName(const std::string& name) {
  return !name.empty() && name.find_first_of("/ \t\n") == std::string::npos && name.front() != '.';
}

core::Result<std::map<std::string, std::string>> ReadAllowed(const Path& directory) {
  const Path file = directory / kAllowedFile;
  if (auto is_private = CheckPrivate(file); !is_private) return tl::unexpected(is_private.error());
  std::map<std::string, std::string> allowed;
  std::ifstream in(file);
  for (std::string key, name; in >> key;) {
    if (!std::getline(in >> std::ws, name) || !IsKey(key) || !IsName(name)) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        file.string() + " is damaged: a line is not '<public key> <name>'; make the keys again");
    }
    allowed[key] = name;
  }
  return allowed;
}

core::Result<KeyPair> ReadPair(const Path& file) {
  if (auto is_private = CheckPrivate(file); !is_private) return tl::unexpected(is_private.error());
  std::ifstream in(file);
  KeyPair pair;
  if (in >> pair.public_key >> pair.secret_key && IsKey(pair.public_key) && IsKey(pair.secret_key)) return pair;
  return core::Fail(core::ErrorCode::kInvalidInput, file.string() + " is damaged; make the keys again");
}

}  // namespace

std::string Keys::PublicKeyOf(const std::string& name) const {
  for (const auto& [key, owner] : allowed) {
    if (owner == name) return key;
  }
  return {};
}

core::Result<void> MakeKeys(const Path& directory, const std::vector<std::string>& names) {
  std::error_code error;
  std::filesystem::create_directories(directory.parent_path(), error);
  if (mkdir(directory.c_str(), 0700) != 0 && !std::filesystem::is_directory(directory)) {
    return core::Fail(core::ErrorCode::kIo, "cannot make the key directory " + directory.string());
  }
  if (auto is_private = CheckPrivate(directory); !is_private) return is_private;
  std::vector<std::string> all = {kRegistryKeyName};
  all.insert(all.end(), names.begin(), names.end());
  for (const std::string& name : all) {
    const Path file = directory / (name + ".key");
    if (!IsName(name)) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "'" + name + "' is not a name for a key: no spaces, no slashes");
    }
    if (std::filesystem::exists(file)) continue;
    std::array<char, kKeyCharacters + 1> public_key, secret_key;
    if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
      return core::Fail(core::ErrorCode::kResource, "libzmq has no CURVE; install the distribution's libzmq5");
    }
    const std::string first = public_key.data();
    if (auto written = WritePrivately(file, first + "\n" + secret_key.data() + "\n", O_EXCL); !written) return written;
    auto listed = WritePrivately(directory / kAllowedFile, first + " " + name + "\n", O_APPEND);
    if (!listed) return listed;
  }
  return {};
}

core::Result<Keys> LoadKeys(const Path& directory, const std::string& node_name) {
  if (!detail::CanSeal()) {
    return core::Fail(
        core::ErrorCode::kInvalidInput,
        "this machine's processor has no AES instructions, which encryption needs; use another machine, or give "
        "--no_encryption");
  }
  if (auto is_private = CheckPrivate(directory); !is_private) return tl::unexpected(is_private.error());
  auto allowed = ReadAllowed(directory);
  if (!allowed) return tl::unexpected(allowed.error());
  Keys keys;
  keys.allowed = std::move(*allowed);
  for (std::string name = node_name; !name.empty();) {
    if (std::filesystem::exists(directory / (name + ".key"))) {
      auto pair = ReadPair(directory / (name + ".key"));
      if (!pair) return tl::unexpected(pair.error());
      keys.own = std::move(*pair);
      keys.own_name = name;
      break;
    }
    const std::size_t dash = name.rfind('-');
    name.resize(dash == std::string::npos ? 0 : dash);
  }
  if (keys.own_name.empty()) {
    return core::Fail(core::ErrorCode::kNotFound, "no key for " + node_name + " in " + directory.string() +
                                                      "; there must be a " + node_name + ".key");
  }
  if (keys.PublicKeyOf(kRegistryKeyName).empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      (directory / kAllowedFile).string() + " does not list 'registry'");
  }
  return keys;
}

bool IsKeyFor(const std::string& key_name, const std::string& node_name) {
  return node_name.compare(0, key_name.size(), key_name) == 0 &&
         (node_name.size() == key_name.size() || node_name[key_name.size()] == '-');
}

}  // namespace bus
