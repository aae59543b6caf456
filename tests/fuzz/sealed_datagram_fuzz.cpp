// Any bytes at either end of a sealed channel: without the key nothing opens, and no answer is longer than the
// question.

#include <array>
#include <cstdint>
#include <span>

#include "protocol/sealed_contact.hpp"
#include "protocol/sealed_sessions.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

SecretKey key() {
  std::array<std::uint8_t, kSecretKeySize> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);  // of the seeds
  return SecretKey(bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::array<SealedSessions::Key, 1> keys{{{key(), true}}};
  static SealedSessions daemon(SealChannel::client, keys);
  static SealedContact contact(SealChannel::client, key());
  const std::span bytes(data, size);
  SealHeader header;
  const SealRefusal refusal = read_seal_header(bytes, header);
  const SealedSessions::Opened at_daemon = daemon.open(bytes, {});
  promise(at_daemon.refusal != SealRefusal::none || at_daemon.kind == SealKind::first_contact,
          "nothing was sealed to us");
  promise(at_daemon.payload.empty(), "nothing opens");
  promise(at_daemon.challenge.size() <= size, "no answer is longer than the question");
  promise(refusal == SealRefusal::none || at_daemon.refusal == refusal, "the header's gates come first");
  const SealedContact::Opened at_contact = contact.open(bytes);
  promise(at_contact.refusal != SealRefusal::none && at_contact.payload.empty() && !contact.established(),
          "nobody answered us");
  return 0;
}
