#include "daemon/source_filter.hpp"

#include <linux/filter.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>

namespace tissued::daemon {

namespace {

// A program of the kernel's packet filter, at most as long as we need.
class Program {
 public:
  void add(unsigned code, std::uint32_t k, unsigned jump_true = 0, unsigned jump_false = 0) {
    steps_[size_++] = {static_cast<std::uint16_t>(code), static_cast<std::uint8_t>(jump_true),
                       static_cast<std::uint8_t>(jump_false), k};
  }
  // Goes on where what was loaded is `value`, else drops.
  void require(std::uint32_t value) {
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0);
    add(BPF_RET | BPF_K, 0);
  }
  bool attach(int socket) {
    sock_fprog program{static_cast<unsigned short>(size_), steps_.data()};
    return ::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
  }

 private:
  std::array<sock_filter, 24> steps_{};
  std::size_t size_ = 0;
};

constexpr auto kNetworkHeader = static_cast<std::uint32_t>(SKF_NET_OFF);
constexpr std::uint32_t kWhole = 0xFFFFFFFF;

template <typename Bytes>
std::uint32_t word_of(const Bytes& bytes, std::size_t begin) {
  std::uint32_t word = 0;
  for (std::size_t i = begin; i < begin + 4; ++i) word = word << 8 | bytes[i];
  return word;
}

}  // namespace

bool admit_only(int socket, const boost::asio::ip::udp::endpoint& from) noexcept {
  using namespace boost::asio::ip;
  const address source = from.address();
  const bool v4 = source.is_v4() || source.to_v6().is_v4_mapped();
  Program program;
  program.add(BPF_LD | BPF_B | BPF_ABS, kNetworkHeader);
  program.add(BPF_ALU | BPF_RSH | BPF_K, 4);
  program.require(v4 ? 4 : 6);
  const auto require_word = [&program](std::uint32_t offset, std::uint32_t word) {
    program.add(BPF_LD | BPF_W | BPF_ABS, kNetworkHeader + offset);
    program.require(word);
  };
  if (v4) {
    const auto bytes = (source.is_v4() ? source.to_v4() : make_address_v4(v4_mapped, source.to_v6())).to_bytes();
    require_word(12, word_of(bytes, 0));
  } else {
    const auto bytes = source.to_v6().to_bytes();
    for (std::uint32_t i = 0; i < 16; i += 4) require_word(8 + i, word_of(bytes, i));
  }
  program.add(BPF_LD | BPF_H | BPF_ABS, 0);  // UDP's header: its source port
  program.require(from.port());
  program.add(BPF_RET | BPF_K, kWhole);
  return program.attach(socket);
}

void admit_all(int socket) noexcept {
  const int ignored = 0;
  ::setsockopt(socket, SOL_SOCKET, SO_DETACH_FILTER, &ignored, sizeof ignored);
}

}  // namespace tissued::daemon
