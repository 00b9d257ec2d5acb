#include "lsmvs/util/lru_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace lsmvs {
namespace {

TEST(LruOrderTest, OldestIsTheOneUsedLeastRecently) {
  LruOrder<int> order;
  for (const int key : {1, 2, 3}) order.Use(key);
  order.Use(1);
  const auto any = [](int) { return true; };
  EXPECT_EQ(order.LeastRecent(any), 2);
  EXPECT_EQ(order.LeastRecent([](int key) { return key != 2; }), 3);
  order.Remove(2);
  order.Remove(3);
  EXPECT_EQ(order.LeastRecent(any), 1);
  EXPECT_EQ(order.LeastRecent([](int key) { return key != 1; }), std::nullopt);
}

TEST(LruOrderTest, BytesAreThoseOfTheItemsThatAreThere) {
  LruOrder<int> order;
  order.Use(1);
  order.SetBytes(1, 10);
  order.Use(2);
  order.SetBytes(2, 5);
  order.SetBytes(1, 3);
  order.SetBytes(7, 100);  // not there
  EXPECT_EQ(order.held_bytes(), 8u);
  order.Remove(1);
  EXPECT_EQ(order.held_bytes(), 5u);
}

using Cache = LruCache<int, std::string>;

class LruCacheTest : public testing::Test {
 protected:
  std::shared_ptr<const std::string> Get(int key) {
    return cache_.Get(key, [&] {
      ++num_loads_;
      const auto value = std::make_shared<const std::string>(10, static_cast<char>('a' + key));
      return Cache::Loaded{value, value->size()};
    });
  }

  Cache cache_{25};  // two values
  int num_loads_ = 0;
};

TEST_F(LruCacheTest, KeepsTheMostRecentlyUsedWithinTheBudget) {
  Get(0), Get(1), Get(0);
  EXPECT_EQ(num_loads_, 2);
  Get(2);  // drops 1
  EXPECT_EQ(cache_.held_bytes(), 20u);
  EXPECT_EQ(*Get(0), std::string(10, 'a'));
  EXPECT_EQ(num_loads_, 3);
  Get(1);
  EXPECT_EQ(num_loads_, 4);
}

TEST_F(LruCacheTest, ValueInUseOutlivesItsPlace) {
  const auto held = Get(0);
  cache_.Trim(0);
  EXPECT_EQ(cache_.held_bytes(), 0u);
  EXPECT_EQ(*held, std::string(10, 'a'));
  Get(0);
  EXPECT_EQ(num_loads_, 2);
}

TEST_F(LruCacheTest, ValueLargerThanTheBudgetIsKeptAlone) {
  cache_.SetBudget(5);
  Get(0), Get(0);
  EXPECT_EQ(num_loads_, 1);
  Get(1);
  EXPECT_EQ(cache_.held_bytes(), 10u);
}

TEST_F(LruCacheTest, FailedLoadIsTriedAgain) {
  const auto fails = [&]() -> Cache::Loaded { throw std::runtime_error("no"); };
  EXPECT_THROW(cache_.Get(0, fails), std::runtime_error);
  const auto none = [&] { return Cache::Loaded{}; };
  EXPECT_EQ(cache_.Get(0, none), nullptr);
  EXPECT_EQ(*Get(0), std::string(10, 'a'));
}

TEST(LruCacheThreadsTest, EachValueIsLoadedOnceByManyThreads) {
  Cache cache(1000);
  std::atomic<int> num_loads = 0, num_wrong = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 200; ++i) {
        const int key = i % 20;
        const auto value = cache.Get(key, [&] {
          ++num_loads;
          return Cache::Loaded{std::make_shared<const std::string>(1, static_cast<char>('a' + key)),
                               1};
        });
        if (*value != std::string(1, static_cast<char>('a' + key))) ++num_wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(num_loads, 20);
  EXPECT_EQ(num_wrong, 0);
}

}  // namespace
}  // namespace lsmvs
