#include "config/key_file.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "config/config_error.hpp"
#include "config/json_reader.hpp"

namespace tissued::config {
namespace {

constexpr std::string_view kBlanks = " \t\r";  // with the ends of lines that another system wrote

// The open file, so that what was looked at is what is read.
class OpenFile {
 public:
  // O_NONBLOCK: a pipe without a writer would wait here for ever.
  explicit OpenFile(const std::filesystem::path& path) : fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~OpenFile() {
    if (fd_ >= 0) close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  int fd() const { return fd_; }

 private:
  int fd_;
};

// One byte more than a file may have, to tell one that is too long; wiped at the end.
class FileText {
 public:
  ~FileText() { sodium_memzero(bytes_.data(), bytes_.size()); }

  // False, with errno, where reading fails.
  bool read_all(int fd) {
    while (size_ < bytes_.size()) {
      const ssize_t count = ::read(fd, bytes_.data() + size_, bytes_.size() - size_);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return false;
      if (count == 0) return true;
      size_ += static_cast<std::size_t>(count);
    }
    return true;
  }
  std::string_view view() const { return {bytes_.data(), size_}; }

 private:
  std::vector<char> bytes_ = std::vector<char>(kMaxKeyFileBytes + 1);
  std::size_t size_ = 0;
};

std::string octal(mode_t mode) {
  std::string digits;
  for (int shift = 9; shift >= 0; shift -= 3) digits += static_cast<char>('0' + ((mode >> shift) & 7U));
  return digits;
}

void refuse_unless_private(const struct stat& status, const std::string& source) {
  if (!S_ISREG(status.st_mode)) throw ConfigError(source + ": is not a regular file");
  if ((status.st_mode & (S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH)) == 0) return;
  throw ConfigError(source + ": its mode " + octal(status.st_mode & 07777) +
                    " lets group or others read or write it; 0600 does not");
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return fields;
}

// What is wrong with a name; nothing where it can stand in the file.
std::optional<std::string> name_fault(std::string_view name) {
  if (name.empty()) return "the name is empty";
  if (name.size() > kMaxKeyName) {
    return "the name has " + std::to_string(name.size()) + " characters, more than " + std::to_string(kMaxKeyName);
  }
  const bool visible = std::all_of(name.begin(), name.end(), [](char c) { return c > 0x20 && c <= 0x7E; });
  if (!visible) return "the name holds a blank or a byte that is not printable ASCII";
  if (name.front() == '#') return "the name begins with #, as a comment does";
  return std::nullopt;
}

std::optional<std::string> read_secret(std::string_view digits, std::array<std::uint8_t, 32>& secret) {
  if (digits.size() != 2 * secret.size()) {
    return "the key has " + std::to_string(digits.size()) + " characters, not 64 hexadecimal digits";
  }
  std::size_t size = 0;
  const char* end = nullptr;
  sodium_hex2bin(secret.data(), secret.size(), digits.data(), digits.size(), nullptr, &size, &end);
  if (size != secret.size()) return "the key holds a character that is no hexadecimal digit";
  const bool uniform = std::all_of(secret.begin(), secret.end(), [&](std::uint8_t b) { return b == secret.front(); });
  if (uniform) return "the key is one byte repeated, which nobody drew at random";
  return std::nullopt;
}

std::optional<std::string> read_line(const std::vector<std::string_view>& fields, PreSharedKey& key) {
  if (fields.size() != 3) return "has " + std::to_string(fields.size()) + " words, not the three NAME ROLE KEY";
  if (auto fault = name_fault(fields[0])) return fault;
  const auto role = key_role_of(fields[1]);
  if (!role) return "the role is not one of tracker, client or both";
  key.name = fields[0];
  key.role = *role;
  return read_secret(fields[2], key.secret);
}

class KeyList {
 public:
  KeyList() { keys_.reserve(kMaxKeys); }

  // What is wrong with a line.
  std::optional<std::string> add(std::string_view line, int number) {
    const auto fields = split(line);
    if (fields.empty() || fields.front().starts_with('#')) return std::nullopt;
    PreSharedKey key;
    if (auto fault = read_line(fields, key)) return fault;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const std::string there = "that of line " + std::to_string(lines_[i]);
      if (keys_[i].name == key.name) return "the name " + key.name + " is " + there;
      if (sodium_memcmp(keys_[i].secret.data(), key.secret.data(), key.secret.size()) == 0)
        return "the key is " + there;
    }
    if (keys_.size() == kMaxKeys) return "is one key more than the " + std::to_string(kMaxKeys) + " there may be";
    keys_.push_back(key);
    lines_.push_back(number);
    return std::nullopt;
  }

  std::vector<PreSharedKey> take() { return std::move(keys_); }

 private:
  std::vector<PreSharedKey> keys_;
  std::vector<int> lines_;  // (keys)
};

}  // namespace

PreSharedKey::~PreSharedKey() { sodium_memzero(secret.data(), secret.size()); }

const char* to_string(KeyRole role) {
  switch (role) {
    case KeyRole::tracker:
      return "tracker";
    case KeyRole::client:
      return "client";
    case KeyRole::both:
      return "both";
  }
  return "unknown";
}

std::optional<KeyRole> key_role_of(std::string_view word) {
  for (const KeyRole role : {KeyRole::tracker, KeyRole::client, KeyRole::both}) {
    if (word == to_string(role)) return role;
  }
  return std::nullopt;
}

std::vector<PreSharedKey> read_key_file(const std::filesystem::path& path) {
  const std::string source = one_line(path.string(), 200);
  const OpenFile file(path);
  const auto failed = [&](const char* what) { return ConfigError(source + ": " + what + ": " + std::strerror(errno)); };
  if (file.fd() < 0) throw failed("cannot be opened");
  struct stat status {};
  if (fstat(file.fd(), &status) != 0) throw failed("cannot be looked at");
  refuse_unless_private(status, source);
  FileText text;
  if (!text.read_all(file.fd())) throw failed("cannot be read");
  return parse_keys(text.view(), source);
}

std::vector<PreSharedKey> parse_keys(std::string_view text, const std::string& source) {
  if (text.size() > kMaxKeyFileBytes) {
    throw ConfigError(source + ": has more than " + std::to_string(kMaxKeyFileBytes) + " bytes");
  }
  KeyList list;
  int number = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const auto fault = list.add(line, ++number);
    if (fault) throw ConfigError(source + ":" + std::to_string(number) + ": " + *fault);
  }
  return list.take();
}

std::string make_key_line(std::string_view name, KeyRole role) {
  if (const auto fault = name_fault(name)) throw ConfigError(one_line(std::string(name), 200) + ": " + *fault);
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot start: no source of randomness");
  PreSharedKey key;
  randombytes_buf(key.secret.data(), key.secret.size());
  std::array<char, 2 * 32 + 1> digits{};
  sodium_bin2hex(digits.data(), digits.size(), key.secret.data(), key.secret.size());
  std::string line = std::string(name) + ' ' + to_string(role) + ' ' + digits.data();
  sodium_memzero(digits.data(), digits.size());
  return line;
}

}  // namespace tissued::config
