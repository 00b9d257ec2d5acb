#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace lsmvs {

// What a process and its helpers send each other, over TCP: a header, and bytes that follow it.
// Both are the same program on machines of the same kind, so that numbers are sent as they lie in
// memory.
enum class MessageKind : uint32_t {
  kHello = 1,  // helper: HelloText() of the run's token; `item`: its threads
  kState,      // `key`, the state's bytes
  kBegin,      // a loop of kind `key`, number `loop`: its states are set
  kItem,       // an item of it is to be computed
  kResult,     // helper: the item's bytes
};

struct MessageHeader {
  MessageKind kind = MessageKind::kHello;
  int32_t key = 0;
  uint64_t loop = 0, item = 0, num_bytes = 0;
};

struct Message {
  MessageHeader header;
  std::shared_ptr<const std::string> bytes;  // null: none

  static Message Make(MessageKind kind, int32_t key, uint64_t loop, uint64_t item,
                      std::shared_ptr<const std::string> bytes = nullptr) {
    return {{kind, key, loop, item, bytes ? bytes->size() : 0}, std::move(bytes)};
  }
};

// A hello is no longer than that; nobody is made to reserve memory by strangers.
inline constexpr uint64_t kMaxHelloBytes = 256;

// What messages are sent and received in pieces of: a large block of memory may lie in a file
// (ScratchMemory), which the system must not be told to read or write.
inline constexpr uint64_t kMaxPieceBytes = uint64_t{1} << 20;

}  // namespace lsmvs
