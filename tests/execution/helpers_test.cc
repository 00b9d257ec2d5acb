#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <set>
#include <thread>

#include "lsmvs/execution/helpers/helper_leader.h"
#include "lsmvs/execution/helpers/leader_address.h"
#include "lsmvs/execution/helpers/loop_items.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

// Loops that several processes share. The helpers are threads here, with connections of their own.

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

void Sleep(int count) { std::this_thread::sleep_for(milliseconds(count)); }

// What the items of the test's loops give.
std::string ResultOf(const std::string& factor, int kind, size_t item) {
  return factor + "/" + std::to_string(kind) + "/" + std::to_string(item);
}

class TestWorker : public LoopWorker {
 public:
  // `hook` is called with the number of items so far, before each.
  explicit TestWorker(std::function<void(size_t)> hook = {}) : hook_(std::move(hook)) {}
  void SetState(int key, std::string bytes) override {
    EXPECT_EQ(num_at_work_, 0);
    ++num_states;
    if (key == 1) factor_ = bytes;
  }
  void Begin(int kind) override { kind_ = kind; }
  std::string Compute(int kind, size_t item) override {
    ++num_at_work_;
    EXPECT_EQ(kind, kind_);
    if (hook_) hook_(num_items_++);
    const std::string result = ResultOf(factor_, kind, item);
    --num_at_work_;
    return result;
  }

  std::atomic<int> num_states{0};

 private:
  std::function<void(size_t)> hook_;
  std::string factor_;
  int kind_ = 0;
  std::atomic<int> num_at_work_{0};
  std::atomic<size_t> num_items_{0};
};

struct LoopRun {
  std::vector<std::string> results;
  size_t num_here = 0, num_kept = 0;
};

// Runs a loop whose items take so long here.
LoopRun RunLoop(LoopHelpers* helpers, const std::string& factor, int kind, size_t count,
                int milliseconds_here, int num_threads = 1) {
  RunContext context(num_threads);
  context.helpers = helpers;
  LoopRun run;
  run.results.assign(count, "");
  std::mutex mutex;
  const auto put = [&](size_t item, std::string result) {
    const std::lock_guard lock(mutex);
    EXPECT_EQ(run.results[item], "") << item;
    run.results[item] = std::move(result);
  };
  SharedLoop loop;
  loop.kind = kind;
  loop.count = count;
  loop.states = [&] {
    return std::vector<LoopState>{{1, std::make_shared<const std::string>(factor)},
                                  {2, std::make_shared<const std::string>(100'000, 'x')}};
  };
  loop.compute = [&](size_t item, const std::function<bool()>& is_first) {
    Sleep(milliseconds_here);
    if (!is_first()) return;
    put(item, ResultOf(factor, kind, item));
    ++run.num_here;
  };
  loop.keep = [&](size_t item, std::string_view result) {
    put(item, std::string(result));
    ++run.num_kept;
  };
  RunSharedLoop(loop, context);
  return run;
}

std::vector<std::string> Expected(const std::string& factor, int kind, size_t count) {
  std::vector<std::string> results;
  for (size_t i = 0; i < count; ++i) results.push_back(ResultOf(factor, kind, i));
  return results;
}

// A process that is helped, and its helpers.
class Team {
 public:
  Team() : leader_(std::make_unique<HelperLeader>(path())) {}
  ~Team() { End(); }
  fs::path path() const { return folder_.path() / "leader"; }
  HelperLeader* leader() { return leader_.get(); }

  void Add(TestWorker* worker, int num_threads = 1, const std::atomic<bool>* cancel = nullptr) {
    const size_t before = leader_->num_helpers();
    threads_.emplace_back([=, this] {
      RunContext context(num_threads);
      context.cancel = cancel;
      try {
        HelpLeader(
            path(), [] { return false; }, worker, context);
      } catch (const std::exception&) {
        ++num_failed;
      }
    });
    for (int i = 0; i < 500 && leader_->num_helpers() == before; ++i) Sleep(10);
    ASSERT_EQ(leader_->num_helpers(), before + 1);
  }
  void End() {
    leader_.reset();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  std::atomic<int> num_failed{0};

 private:
  TemporaryFolder folder_;
  std::unique_ptr<HelperLeader> leader_;
  std::vector<std::thread> threads_;
};

TEST(SharedLoop, WithoutHelpersRunsHere) {
  const LoopRun run = RunLoop(nullptr, "a", 1, 20, 0, 3);
  EXPECT_EQ(run.results, Expected("a", 1, 20));
  EXPECT_EQ(run.num_here, 20u);
}

TEST(HelperLeader, WithoutHelpersDoesAllAlone) {
  Team team;
  EXPECT_EQ(RunLoop(team.leader(), "a", 1, 20, 0).results, Expected("a", 1, 20));
  EXPECT_EQ(RunLoop(team.leader(), "a", 1, 0, 0).results, Expected("a", 1, 0));
  EXPECT_EQ(team.leader()->num_items_by_helpers(), 0u);
}

TEST(HelperLeader, HelpersTakeTheirShareOfEveryLoop) {
  Team team;
  TestWorker first([](size_t) { Sleep(10); }), second([](size_t) { Sleep(10); });
  team.Add(&first);
  team.Add(&second, 2);
  for (int k = 0; k < 5; ++k) {
    const std::string factor(1, static_cast<char>('a' + k));
    const LoopRun run = RunLoop(team.leader(), factor, k, 80, 10);
    EXPECT_EQ(run.results, Expected(factor, k, 80));
    // Of four threads one is here.
    EXPECT_GT(run.num_here, 5u);
    EXPECT_GT(run.num_kept, 40u);
  }
  team.End();
  // The second state was the same each time.
  EXPECT_EQ(first.num_states, 6);
  EXPECT_EQ(second.num_states, 6);
}

// Sent and received in pieces.
TEST(HelperLeader, LongStatesAndResultsArriveWhole) {
  std::string factor;
  for (size_t i = 0; factor.size() < 3'500'000; ++i) factor += std::to_string(i) + " ";
  Team team;
  TestWorker worker;
  team.Add(&worker, 2);
  const LoopRun run = RunLoop(team.leader(), factor, 7, 12, 20);
  EXPECT_TRUE(run.results == Expected(factor, 7, 12));
  EXPECT_GT(run.num_kept, 0u);
}

TEST(HelperLeader, AHelperThatIsLostInTheMiddleOfALoopIsReplaced) {
  Team team;
  std::atomic<bool> cancel{false};
  TestWorker worker([&](size_t count) {
    if (count == 3) cancel = true;
    Sleep(count < 3 ? 1 : 300);
  });
  team.Add(&worker, 1, &cancel);
  const LoopRun run = RunLoop(team.leader(), "a", 1, 60, 20);
  EXPECT_EQ(run.results, Expected("a", 1, 60));
  EXPECT_GE(run.num_kept, 3u);
  for (int i = 0; i < 500 && team.leader()->num_helpers() > 0; ++i) Sleep(10);
  EXPECT_EQ(team.leader()->num_helpers(), 0u);
  EXPECT_EQ(RunLoop(team.leader(), "b", 1, 10, 0).results, Expected("b", 1, 10));
}

TEST(HelperLeader, AHelperThatIsFarTooSlowIsNotWaitedFor) {
  Team team;
  TestWorker worker([](size_t) { Sleep(3000); });
  team.Add(&worker);
  const auto begin = std::chrono::steady_clock::now();
  const LoopRun run = RunLoop(team.leader(), "a", 1, 20, 5);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, milliseconds(2500));
  EXPECT_EQ(run.results, Expected("a", 1, 20));
}

TEST(HelperLeader, AHelperThatFailsEndsAndTheLoopDoesNot) {
  Team team;
  TestWorker worker([](size_t count) {
    if (count == 1) throw Error(ExitCode::kMemory, "too large");
  });
  team.Add(&worker);
  EXPECT_EQ(RunLoop(team.leader(), "a", 1, 30, 5).results, Expected("a", 1, 30));
  EXPECT_EQ(RunLoop(team.leader(), "b", 1, 30, 5).results, Expected("b", 1, 30));
  team.End();
  EXPECT_EQ(team.num_failed, 1);
}

TEST(HelperLeader, WhoComesLaterHelpsFromTheNextLoopOn) {
  Team team;
  TestWorker first, second;
  team.Add(&first);
  EXPECT_EQ(RunLoop(team.leader(), "a", 1, 30, 1).results, Expected("a", 1, 30));
  team.Add(&second);
  EXPECT_EQ(RunLoop(team.leader(), "a", 1, 30, 1).results, Expected("a", 1, 30));
  team.End();
  EXPECT_EQ(first.num_states, 2);
  EXPECT_EQ(second.num_states, 2);
}

TEST(HelperLeader, ThrowsWhatAnItemThrows) {
  Team team;
  TestWorker worker([](size_t) { Sleep(10); });  // leaves some to this process
  team.Add(&worker);
  SharedLoop loop;
  loop.count = 10;
  loop.states = [] { return std::vector<LoopState>(); };
  loop.keep = [](size_t, std::string_view) {};
  loop.compute = [](size_t, const std::function<bool()>&) {
    throw Error(ExitCode::kFileSystem, "the disk is full");
  };
  RunContext context(2);
  context.helpers = team.leader();
  EXPECT_THROW(RunSharedLoop(loop, context), Error);
  loop.compute = [](size_t, const std::function<bool()>& is_first) {
    Sleep(20);
    is_first();
  };
  loop.keep = [](size_t, std::string_view) { throw Error(ExitCode::kInternal, "cut off"); };
  EXPECT_THROW(RunSharedLoop(loop, context), Error);
  EXPECT_EQ(RunLoop(team.leader(), "b", 1, 10, 1).results, Expected("b", 1, 10));
}

TEST(HelperLeader, StrangersAreTurnedAway) {
  Team team;
  const LeaderAddress address = *ReadLeaderAddress(team.path());
  EXPECT_EQ(address.token.size(), 32u);
  EXPECT_EQ(fs::status(team.path()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const TemporaryFolder folder;
  WriteLeaderAddress(folder.path() / "leader", {address.hosts, address.port, std::string(32, '0')});
  TestWorker worker;
  EXPECT_EQ(HelpLeader(
                folder.path() / "leader", [] { return false; }, &worker, RunContext(1)),
            0u);
  EXPECT_EQ(worker.num_states, 0);
  EXPECT_EQ(RunLoop(team.leader(), "a", 1, 10, 1).results, Expected("a", 1, 10));
}

TEST(HelpLeader, EndsWhereNobodyNeedsHelp) {
  const TemporaryFolder folder;
  TestWorker worker;
  EXPECT_EQ(HelpLeader(
                folder.path() / "leader", [] { return true; }, &worker, RunContext(1)),
            0u);
  std::atomic<bool> cancel{true};
  RunContext context(1);
  context.cancel = &cancel;
  EXPECT_THROW(HelpLeader(
                   folder.path() / "leader", [] { return false; }, &worker, context),
               CancelledError);
}

TEST(LoopItems, EachIsHandedOutOnce) {
  LoopItems items(40, 1, 8);
  std::set<size_t> seen;
  for (int k = 0; k < 20; ++k) {
    for (const auto item : {items.TakeForHelper(1), items.TakeHere([] {})}) {
      ASSERT_TRUE(item);
      EXPECT_TRUE(seen.insert(*item).second);
      EXPECT_TRUE(items.Finish(*item, *item % 2 == 0));
      EXPECT_FALSE(items.Finish(*item, true));
    }
  }
  EXPECT_FALSE(items.TakeForHelper(1));
  EXPECT_FALSE(items.TakeHere([] {}));
  EXPECT_EQ(items.num_by_helpers(), 20u);
}

TEST(LoopItems, EachTakesARowAndThenHelpsTheOthers) {
  LoopItems items(9, 2, 100);
  EXPECT_EQ(items.TakeForHelper(1), 0u);
  EXPECT_EQ(items.TakeHere([] {}), 3u);
  EXPECT_EQ(items.TakeForHelper(2), 6u);
  EXPECT_EQ(items.TakeForHelper(2), 7u);
  EXPECT_EQ(items.TakeForHelper(2), 8u);
  EXPECT_EQ(items.TakeForHelper(1), 1u);
  EXPECT_EQ(items.TakeForHelper(2), 5u);  // the end of the longest row
  EXPECT_EQ(items.TakeHere([] {}), 4u);
  EXPECT_EQ(items.TakeHere([] {}), 2u);
  EXPECT_FALSE(items.TakeForHelper(1));
}

TEST(LoopItems, WhatALostHelperHadIsHandedOutAgain) {
  LoopItems items(10, 1, 8);
  const size_t lost = *items.TakeForHelper(1);
  items.GiveBack(1);
  std::set<size_t> seen;
  while (const auto item = items.TakeHere([] {})) {
    seen.insert(*item);
    items.Finish(*item, false);
  }
  EXPECT_EQ(seen.size(), 10u);
  EXPECT_TRUE(seen.contains(lost));
}

TEST(LoopItems, AHelpersLateItemIsHandedOutAgain) {
  LoopItems items(2, 1, 8);
  const size_t late = *items.TakeForHelper(1);
  items.Finish(*items.TakeHere([] {}), false);
  const auto again = items.TakeHere([] {});
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, late);
  EXPECT_TRUE(items.Finish(late, true));
  EXPECT_FALSE(items.Finish(late, true));
}

}  // namespace
}  // namespace lsmvs
