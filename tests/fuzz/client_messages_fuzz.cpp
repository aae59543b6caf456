// Any bytes as a datagram of the client protocol: whatever is accepted must survive another round trip unchanged.

#include <cstdint>
#include <span>
#include <vector>

#include "protocol/client_messages.hpp"
#include "protocol/sequence_gate.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

std::vector<std::uint8_t> encode(const DecodedMessage& decoded) {
  std::vector<std::uint8_t> buffer(kMaxDatagram);
  buffer.resize(
      std::visit([&](const auto& message) { return encode_client_message(decoded.header.envelope, message, buffer); },
                 decoded.message));
  return buffer;
}

void check(std::span<const std::uint8_t> bytes, SequenceGate& gate) {
  const DecodedMessage decoded = decode_client_message(bytes);
  if (decoded.refusal != ClientRefusal::none) return;
  gate.judge(decoded.header.envelope);
  // The encoder refuses numbers that are not finite, so an empty answer means that one was accepted.
  const auto once = encode(decoded);
  promise(once.size() == bytes.size(), "an accepted message is encoded to as many bytes");
  const DecodedMessage again = decode_client_message(once);
  promise(again.refusal == ClientRefusal::none, "what we encode is accepted");
  promise(encode(again) == once, "a second round trip changes nothing");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SequenceGate gate;
  check({data, size}, gate);
  if (size < kHeaderSize) return 0;
  // Once more with the length put right, which a mutation rarely hits.
  std::vector<std::uint8_t> bytes(data, data + size);
  for (std::size_t i = 0; i < 4; ++i) bytes[20 + i] = static_cast<std::uint8_t>(size >> (8 * i));
  check(bytes, gate);
  return 0;
}
