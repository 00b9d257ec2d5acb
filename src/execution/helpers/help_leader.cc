#include <glog/logging.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

// Last of the system's: Boost 1.74 does not include <utility>, which it uses.
#include <boost/asio.hpp>

#include "lsmvs/execution/helpers/connection_options.h"
#include "lsmvs/execution/helpers/helper_leader.h"
#include "lsmvs/execution/helpers/leader_address.h"
#include "lsmvs/execution/helpers/message.h"

namespace lsmvs {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using std::chrono::milliseconds;

constexpr std::chrono::seconds kLongestWait(60);
constexpr milliseconds kLook(200);
// For a connection to one address.
constexpr std::chrono::seconds kConnectWait(3);
// A process that cannot be reached so often is not there any more, or never will be.
constexpr int kMostRefusals = 10;

// Whether one of this machine's addresses, of which many machines may have the same (bridges), is
// meant by another machine.
bool IsOtherMachine(const std::string& host, const LeaderAddress& address,
                    const std::vector<std::string>& own) {
  const bool is_here = address.hosts.front() == own.front();
  return is_here || std::find(own.begin(), own.end(), host) == own.end();
}

bool ConnectTo(const std::string& host, uint16_t port, asio::io_context* io, tcp::socket* socket) {
  error_code error;
  tcp::resolver resolver(*io);
  const auto places = resolver.resolve(tcp::v4(), host, std::to_string(port), error);
  if (error) return false;
  bool is_connected = false;
  asio::async_connect(*socket, places, [&](error_code connecting, const tcp::endpoint&) {
    is_connected = !connecting;
  });
  io->restart();
  io->run_for(kConnectWait);
  if (is_connected) return true;
  socket->close(error);
  io->run();  // the handler ends
  return false;
}

bool Connect(const LeaderAddress& address, const RunContext& context, asio::io_context* io,
             tcp::socket* socket) {
  const std::vector<std::string> own = HostsOfThisMachine();
  for (const std::string& host : address.hosts) {
    context.ThrowIfCancelled();
    if (IsOtherMachine(host, address, own) && ConnectTo(host, address.port, io, socket))
      return true;
  }
  return false;
}

// Computes items in threads of its own, as they come in.
class ItemThreads {
 public:
  using Reply = std::function<void(const MessageHeader& item, const std::string& bytes)>;

  // `on_error`: an item has failed.
  ItemThreads(LoopWorker* worker, int num_threads, Reply reply, std::function<void()> on_error)
      : worker_(*worker), reply_(std::move(reply)), on_error_(std::move(on_error)) {
    for (int i = 0; i < num_threads; ++i) threads_.emplace_back([this] { Run(); });
  }
  ~ItemThreads() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  void Add(const MessageHeader& item) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(item);
    }
    changed_.notify_one();
  }
  // Forgets what waits, and returns once nothing is at work. Throws what an item has thrown.
  void Clear() {
    std::unique_lock lock(mutex_);
    waiting_.clear();
    changed_.wait(lock, [this] { return num_at_work_ == 0; });
    if (error_) std::rethrow_exception(error_);
  }
  void SetKind(int kind) { kind_ = kind; }
  size_t num_done() const { return num_done_; }

 private:
  void Run() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
      if (stop_) return;
      const MessageHeader item = waiting_.front();
      waiting_.pop_front();
      ++num_at_work_;
      lock.unlock();
      try {
        reply_(item, worker_.Compute(kind_, static_cast<size_t>(item.item)));
        ++num_done_;
      } catch (...) {
        Fail(std::current_exception());
      }
      lock.lock();
      --num_at_work_;
      changed_.notify_all();
    }
  }

  void Fail(const std::exception_ptr& error) {
    {
      const std::lock_guard lock(mutex_);
      error_ = error;
    }
    on_error_();
  }

  LoopWorker& worker_;
  const Reply reply_;
  const std::function<void()> on_error_;
  std::atomic<int> kind_{0};
  std::atomic<size_t> num_done_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<MessageHeader> waiting_;
  size_t num_at_work_ = 0;
  bool stop_ = false;
  std::exception_ptr error_;
  std::vector<std::thread> threads_;
};

// The connection to the process that is helped.
class Helper {
 public:
  Helper(tcp::socket socket, LoopWorker* worker, const RunContext& context)
      : socket_(std::move(socket)),
        worker_(*worker),
        context_(context),
        threads_(
            worker, context.num_threads(),
            [this](const MessageHeader& item, const std::string& bytes) {
              Send({MessageKind::kResult, 0, item.loop, item.item, bytes.size()}, bytes);
            },
            [this] { ShutDown(); }) {}

  // Until the other side closes. Throws what an item has thrown.
  size_t Run(const std::string& token) {
    SetConnectionOptions(socket_.native_handle());
    const std::string hello = HelloText(token);
    Send({MessageKind::kHello, 0, 0, static_cast<uint64_t>(context_.num_threads()), hello.size()},
         hello);
    MessageHeader header;
    while (Read(&header, sizeof header)) {
      std::string bytes(header.num_bytes, '\0');
      if (!Read(bytes.data(), bytes.size())) break;
      Take(header, std::move(bytes));
    }
    threads_.Clear();
    return threads_.num_done();
  }

 private:
  void Take(const MessageHeader& header, std::string bytes) {
    if (header.kind == MessageKind::kItem) return threads_.Add(header);
    threads_.Clear();
    if (header.kind == MessageKind::kState) worker_.SetState(header.key, std::move(bytes));
    if (header.kind == MessageKind::kBegin) {
      worker_.Begin(header.key);
      threads_.SetKind(header.key);
    }
  }

  // The other side is to give to others what this one was to do; reading ends, too.
  void ShutDown() {
    error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_both, ignored);
  }

  // False once the other side has closed.
  bool Read(void* data, size_t num_bytes) {
    if (num_bytes == 0) return true;
    // Between messages there may be long waits, in which a cancel is to be noticed.
    pollfd look = {socket_.native_handle(), POLLIN, 0};
    for (int num_ready = 0; num_ready <= 0;) {
      context_.ThrowIfCancelled();
      num_ready = ::poll(&look, 1, static_cast<int>(kLook.count()));
      if (num_ready < 0 && errno != EINTR) return false;
    }
    error_code error;
    asio::read(socket_, asio::buffer(data, num_bytes), error);
    return !error;
  }

  // What cannot be sent is not missed: the reader ends, too.
  void Send(const MessageHeader& header, const std::string& bytes) {
    const std::lock_guard lock(sending_);
    error_code ignored;
    asio::write(socket_,
                std::array<asio::const_buffer, 2>{asio::buffer(&header, sizeof header),
                                                  asio::buffer(bytes)},
                ignored);
  }

  tcp::socket socket_;
  LoopWorker& worker_;
  const RunContext& context_;
  std::mutex sending_;
  ItemThreads threads_;  // last: it uses the others
};

}  // namespace

size_t HelpLeader(const std::filesystem::path& address_file, const std::function<bool()>& is_over,
                  LoopWorker* worker, const RunContext& context) {
  const auto end = std::chrono::steady_clock::now() + kLongestWait;
  int num_refusals = 0;
  while (std::chrono::steady_clock::now() < end && num_refusals < kMostRefusals && !is_over()) {
    context.ThrowIfCancelled();
    const std::optional<LeaderAddress> address = ReadLeaderAddress(address_file);
    asio::io_context io;
    tcp::socket socket(io);
    if (address && Connect(*address, context, &io, &socket)) {
      return Helper(std::move(socket), worker, context).Run(address->token);
    }
    num_refusals += address.has_value();
    std::this_thread::sleep_for(kLook);
  }
  LOG(INFO) << "nobody needs help";
  return 0;
}

}  // namespace lsmvs
