#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

namespace lsmvs {

// Which of the items that are kept was used least recently, and how many bytes they hold. The items
// themselves lie with the caller. Not thread-safe. O(log n) per call, but LeastRecent().
template <class Key>
class LruOrder {
 public:
  // The item is used now; a new one joins with 0 bytes.
  void Use(const Key& key) {
    const auto [item, is_new] = items_.try_emplace(key);
    if (is_new) {
      item->second.place = order_.insert(order_.begin(), key);
    } else {
      order_.splice(order_.begin(), order_, item->second.place);
    }
  }

  // What an item holds from now on. Nothing happens if it is not there.
  void SetBytes(const Key& key, size_t bytes) {
    const auto item = items_.find(key);
    if (item == items_.end()) return;
    held_bytes_ += bytes - item->second.bytes;
    item->second.bytes = bytes;
  }

  void Remove(const Key& key) {
    const auto item = items_.find(key);
    if (item == items_.end()) return;
    held_bytes_ -= item->second.bytes;
    order_.erase(item->second.place);
    items_.erase(item);
  }

  bool Contains(const Key& key) const { return items_.contains(key); }
  // 0 for an item that is not there.
  size_t BytesOf(const Key& key) const {
    const auto item = items_.find(key);
    return item == items_.end() ? 0 : item->second.bytes;
  }
  size_t held_bytes() const { return held_bytes_; }

  // The item used least recently of those that `may_drop(key)` allows; O(items before it).
  template <class MayDrop>
  std::optional<Key> LeastRecent(const MayDrop& may_drop) const {
    const auto found = std::find_if(order_.rbegin(), order_.rend(), may_drop);
    return found == order_.rend() ? std::nullopt : std::optional<Key>(*found);
  }

 private:
  struct Item {
    typename std::list<Key>::iterator place;
    size_t bytes = 0;
  };

  std::map<Key, Item> items_;
  std::list<Key> order_;  // most recently used first
  size_t held_bytes_ = 0;
};

// Values that are loaded when they are asked for, of which the most recently used ones are kept
// within a budget of bytes. Values in use elsewhere live on until they are let go. Thread-safe:
// different values are loaded at the same time, the same one once.
template <class Key, class Value>
class LruCache {
 public:
  using Pointer = std::shared_ptr<const Value>;
  struct Loaded {
    Pointer value;  // null: there is none; nothing is kept
    size_t bytes = 0;
  };

  explicit LruCache(size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  // The value, by `Loaded load()` if it is not kept. The one asked for is kept even beyond the
  // budget, until the next one is. Passes on what load() throws.
  template <class Load>
  Pointer Get(const Key& key, const Load& load) {
    const std::shared_ptr<Entry> entry = Touch(key);
    const std::lock_guard lock(entry->loading);
    if (!entry->value) {
      const Loaded loaded = load();
      entry->value = loaded.value;
      Account(key, entry, loaded);
    }
    return entry->value;
  }

  void SetBudget(size_t budget_bytes) {
    {
      const std::lock_guard lock(mutex_);
      budget_bytes_ = budget_bytes;
    }
    Trim(budget_bytes);
  }

  // Drops the least recently used values until at most `max_bytes` are held.
  void Trim(size_t max_bytes) {
    const std::lock_guard lock(mutex_);
    DropBeyond(max_bytes, [&](const Key& key) { return order_.BytesOf(key) > 0; });
  }

  size_t held_bytes() const {
    const std::lock_guard lock(mutex_);
    return order_.held_bytes();
  }

 private:
  struct Entry {
    std::mutex loading;
    Pointer value;
  };

  std::shared_ptr<Entry> Touch(const Key& key) {
    const std::lock_guard lock(mutex_);
    order_.Use(key);
    std::shared_ptr<Entry>& entry = entries_[key];
    if (!entry) entry = std::make_shared<Entry>();
    return entry;
  }

  void Account(const Key& key, const std::shared_ptr<Entry>& entry, const Loaded& loaded) {
    const std::lock_guard lock(mutex_);
    // Another thread may have dropped it while it was loaded: then only the caller has it.
    const auto found = entries_.find(key);
    if (found == entries_.end() || found->second != entry) return;
    if (!loaded.value) return Drop(key);
    order_.SetBytes(key, loaded.bytes);
    // Entries of 0 bytes are still being loaded.
    DropBeyond(budget_bytes_, [&](const Key& other) {
      return (key < other || other < key) && order_.BytesOf(other) > 0;
    });
  }

  template <class MayDrop>
  void DropBeyond(size_t max_bytes, const MayDrop& may_drop) {
    while (order_.held_bytes() > max_bytes) {
      const std::optional<Key> oldest = order_.LeastRecent(may_drop);
      if (!oldest) return;
      Drop(*oldest);
    }
  }

  void Drop(const Key& key) {
    order_.Remove(key);
    entries_.erase(key);
  }

  mutable std::mutex mutex_;  // of all but Entry::loading and Entry::value
  size_t budget_bytes_;
  std::map<Key, std::shared_ptr<Entry>> entries_;
  LruOrder<Key> order_;
};

}  // namespace lsmvs
