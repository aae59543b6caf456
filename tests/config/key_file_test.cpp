#include "config/key_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <new>

#include "tests/config/bundle_folder.hpp"

using namespace tissued::config;

namespace {

const std::string kDigits = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";
const std::string kOtherDigits = "ffEEddCCbbAA99887766554433221100ffeeddccbbaa99887766554433221100";

std::string fault(const std::string& text) {
  return refusal([&] { parse_keys(text, "keys"); });
}

class KeyFile {
 public:
  explicit KeyFile(const std::string& text) : path_(folder_.write("keys", text)) { chmod(path_.c_str(), 0600); }

  const std::filesystem::path& path() const { return path_; }
  void set_mode(mode_t mode) const { REQUIRE(chmod(path_.c_str(), mode) == 0); }

 private:
  BundleFolder folder_;
  std::filesystem::path path_;
};

}  // namespace

TEST_CASE("A key file is read in its order, comments and empty lines passed over") {
  const KeyFile file("# who may speak\n\nvicon tracker " + kDigits + "\n  # more\n \t\nwatcher\tclient   " +
                     kOtherDigits + " \r\n");
  const auto keys = read_key_file(file.path());
  REQUIRE(keys.size() == 2);
  CHECK(keys[0].name == "vicon");
  CHECK(keys[0].role == KeyRole::tracker);
  for (std::size_t i = 0; i < 32; ++i) CHECK(keys[0].secret[i] == i);
  CHECK(keys[1].name == "watcher");
  CHECK(keys[1].role == KeyRole::client);
  CHECK(keys[1].secret[0] == 0xFF);
  CHECK(keys[1].secret[1] == 0xEE);
  CHECK(keys[1].secret[15] == 0x00);
}

TEST_CASE("A last line needs no end") {
  CHECK(parse_keys("a both " + kDigits, "keys").size() == 1);
  CHECK(parse_keys("a both " + kDigits + "\n", "keys").size() == 1);
}

TEST_CASE("A key file that group or others may read or write is refused, whatever the bit") {
  const KeyFile file("a both " + kDigits);
  for (const mode_t bit : {0040U, 0020U, 0004U, 0002U}) {
    file.set_mode(0600 | bit);
    const std::string mode = bit == 0040 ? "0640" : bit == 0020 ? "0620" : bit == 0004 ? "0604" : "0602";
    CHECK(refusal([&] { read_key_file(file.path()); }) ==
          file.path().string() + ": its mode " + mode + " lets group or others read or write it; 0600 does not");
  }
  for (const mode_t mode : {0600U, 0400U, 0700U, 0611U}) {
    file.set_mode(mode);
    CHECK(read_key_file(file.path()).size() == 1);
  }
  // A link is as open as what it leads to.
  const auto link = file.path().parent_path() / "link";
  std::filesystem::create_symlink(file.path(), link);
  file.set_mode(0644);
  CHECK(refusal([&] { read_key_file(link); }).find("its mode 0644") != std::string::npos);
}

TEST_CASE("What is no file is refused") {
  const BundleFolder folder;
  CHECK(refusal([&] { read_key_file(folder.path() / "none"); }) ==
        (folder.path() / "none").string() + ": cannot be opened: No such file or directory");
  CHECK(refusal([&] { read_key_file(folder.path()); }) == folder.path().string() + ": is not a regular file");
  const auto pipe = folder.path() / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(refusal([&] { read_key_file(pipe); }) == pipe.string() + ": is not a regular file");
}

TEST_CASE("Every other shape of a line is refused with its number, and no key is told") {
  struct Case {
    std::string line;
    const char* reason;
  };
  const Case cases[] = {
      {"a", "has 1 words, not the three NAME ROLE KEY"},
      {"a both", "has 2 words, not the three NAME ROLE KEY"},
      {"both " + kDigits, "has 2 words, not the three NAME ROLE KEY"},
      {"a both " + kDigits + " # mine", "has 5 words, not the three NAME ROLE KEY"},
      {"a-name-of-25-characters--- both " + kDigits, "the name has 26 characters, more than 24"},
      {"caf\xC3\xA9 both " + kDigits, "the name holds a blank or a byte that is not printable ASCII"},
      {std::string("a\0b", 3) + " both " + kDigits, "the name holds a blank or a byte that is not printable ASCII"},
      {"a Both " + kDigits, "the role is not one of tracker, client or both"},
      {"a daemon " + kDigits, "the role is not one of tracker, client or both"},
      {kDigits + " both a", "the name has 64 characters, more than 24"},
      {"a both " + kDigits.substr(1), "the key has 63 characters, not 64 hexadecimal digits"},
      {"a both " + kDigits + "0", "the key has 65 characters, not 64 hexadecimal digits"},
      {"a both x" + kDigits.substr(1), "the key holds a character that is no hexadecimal digit"},
      {"a both " + kDigits.substr(1) + "x", "the key holds a character that is no hexadecimal digit"},
      {"a both " + kDigits.substr(1) + "\x01", "the key holds a character that is no hexadecimal digit"},
      {"a both " + std::string(64, '0'), "the key is one byte repeated, which nobody drew at random"},
      {"a both " + std::string(64, 'a'), "the key is one byte repeated, which nobody drew at random"},
      {"first both " + kDigits, "the name first is that of line 2"},
      {"a client " + kOtherDigits, "the key is that of line 2"},
  };
  for (const Case& bad : cases) {
    CAPTURE(bad.line);
    const std::string line = fault("# keys\nfirst both " + kOtherDigits + "\n" + bad.line + "\nlast both x\n");
    CHECK(line == std::string("keys:3: ") + bad.reason);
    CHECK(line.find("0203") == std::string::npos);
  }
}

TEST_CASE("A key line cut off anywhere is refused") {
  const std::string line = "watcher client " + kDigits;
  for (std::size_t size = 1; size < line.size(); ++size) {
    CAPTURE(size);
    CHECK(fault(line.substr(0, size)).rfind("keys:", 0) == 0);
  }
}

TEST_CASE("At most 64 keys, in at most 64 KiB") {
  CHECK(parse_keys("", "keys").empty());
  CHECK(parse_keys("# none\n\n", "keys").empty());
  std::string text;
  for (int i = 0; i < 64; ++i) text += make_key_line("key" + std::to_string(i), KeyRole::both) + '\n';
  CHECK(parse_keys(text, "keys").size() == 64);
  CHECK(fault(text + make_key_line("one-more", KeyRole::both)) == "keys:65: is one key more than the 64 there may be");
  const std::string line = "a both " + kDigits + "\n#";
  CHECK(parse_keys(line + std::string(65536 - line.size(), ' '), "keys").size() == 1);
  CHECK(fault(line + std::string(65537 - line.size(), ' ')) == "keys: has more than 65536 bytes");
  const KeyFile large(line + std::string(1 << 20, ' '));
  CHECK(refusal([&] { read_key_file(large.path()); }) == large.path().string() + ": has more than 65536 bytes");
}

TEST_CASE("A fresh line is read back, and no two are alike") {
  for (const KeyRole role : {KeyRole::tracker, KeyRole::client, KeyRole::both}) {
    const std::string line = make_key_line("pad-tracker_24.of!them~~", role);
    const auto keys = parse_keys(line, "keys");
    REQUIRE(keys.size() == 1);
    CHECK(keys[0].name == "pad-tracker_24.of!them~~");
    CHECK(keys[0].role == role);
    CHECK(line.size() == 24 + 1 + std::string(to_string(role)).size() + 1 + 64);
    CHECK(key_role_of(to_string(role)) == role);
  }
  CHECK(make_key_line("a", KeyRole::both) != make_key_line("a", KeyRole::both));
  CHECK_FALSE(key_role_of("unknown"));
}

TEST_CASE("A name that could not stand in the file gets no line") {
  for (const auto& [name, reason] :
       {std::pair("", "the name is empty"), std::pair("#a", "the name begins with #, as a comment does"),
        std::pair("a b", "the name holds a blank or a byte that is not printable ASCII"),
        std::pair("abcdefghijklmnopqrstuvwxy", "the name has 25 characters, more than 24")}) {
    CHECK(refusal([&, n = name] { make_key_line(n, KeyRole::both); }) == std::string(name) + ": " + reason);
  }
}

TEST_CASE("A pre-shared key is wiped when it is dropped") {
  alignas(PreSharedKey) std::array<unsigned char, sizeof(PreSharedKey)> memory{};
  auto* key = new (memory.data()) PreSharedKey(parse_keys("a both " + kOtherDigits, "keys").front());
  const std::size_t begin = static_cast<std::size_t>(key->secret.data() - memory.data());
  const volatile unsigned char* seen = memory.data();
  REQUIRE(seen[begin] == 0xFF);
  key->~PreSharedKey();
  for (std::size_t i = 0; i < 32; ++i) CHECK(seen[begin + i] == 0);
}
