#include "lsmvs/execution/helpers/helper_leader.h"

#include <glog/logging.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

// Last of the system's: Boost 1.74 does not include <utility>, which it uses.
#include <boost/asio.hpp>

#include "lsmvs/execution/helpers/connection_options.h"
#include "lsmvs/execution/helpers/leader_address.h"
#include "lsmvs/execution/helpers/loop_items.h"
#include "lsmvs/execution/helpers/message.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

// Beyond those that a helper's threads work on, so that they need not wait for the network.
constexpr size_t kItemsAhead = 1;
// With strangers who say nothing.
constexpr size_t kMaxLinks = 1000;

std::string HashOf(const std::string& bytes) { return Hasher().Update(bytes).HexDigest(); }

}  // namespace

// All members but those for the caller of Run() are used by the network's own thread.
class HelperLeader::Network {
 public:
  explicit Network(std::filesystem::path address_file)
      : address_file_(std::move(address_file)), token_(MakeToken()), acceptor_(io_) {
    acceptor_.open(tcp::v4());
    acceptor_.bind(tcp::endpoint(tcp::v4(), 0));
    acceptor_.listen();
    WriteLeaderAddress(address_file_,
                       {HostsOfThisMachine(), acceptor_.local_endpoint().port(), token_});
    Accept();
    thread_ = std::thread([this] { Serve(); });
  }
  ~Network() {
    asio::post(io_, [this] {
      error_code ignored;
      acceptor_.close(ignored);
      CloseAll();
      io_.stop();
    });
    thread_.join();
    std::error_code ignored;
    std::filesystem::remove(address_file_, ignored);
  }

  void Run(const SharedLoop& loop, const RunContext& context) {
    std::vector<LoopState> states;
    const size_t num_helpers = num_ready_;
    if (num_helpers > 0) states = loop.states();
    LoopItems items(loop.count, num_helpers, loop.longest_row);
    {
      const std::lock_guard lock(mutex_);
      present_ = {&loop, &items, ++num_loops_};
    }
    if (num_helpers > 0) {
      asio::post(io_, [this, kind = loop.kind, number = num_loops_, states = std::move(states)] {
        BeginLoop(kind, number, states);
      });
    }
    try {
      ParallelFor(context, static_cast<size_t>(context.num_threads()), 1,
                  [&](size_t) { Work(loop, &items, context); });
    } catch (...) {
      EndLoop();
      throw;
    }
    EndLoop();
    num_by_helpers_ += items.num_by_helpers();
    if (items.error()) std::rethrow_exception(items.error());
  }

  size_t num_by_helpers() const { return num_by_helpers_; }
  size_t num_ready() const { return num_ready_; }

 private:
  // The loop that is under way.
  struct Present {
    const SharedLoop* loop = nullptr;
    LoopItems* items = nullptr;
    uint64_t number = 0;
  };

  // A helper's connection.
  class Link : public std::enable_shared_from_this<Link> {
   public:
    Link(Network* network, tcp::socket socket, int number)
        : network_(*network), socket_(std::move(socket)), number_(number) {
      SetConnectionOptions(socket_.native_handle());
    }

    bool is_ready() const { return num_threads_ > 0; }

    void Read() {
      asio::async_read(socket_, asio::buffer(&header_, sizeof header_),
                       [self = shared_from_this()](error_code error, size_t) {
                         if (error || !self->MayFollow()) return self->Close();
                         self->ReadBytes();
                       });
    }

    void Begin(int kind, uint64_t loop, const std::vector<LoopState>& states,
               const std::vector<std::string>& hashes) {
      // One that has not even taken the states of an earlier loop stays out of this one.
      if (std::any_of(queue_.begin(), queue_.end(), [](const Message& message) {
            return message.header.kind == MessageKind::kState;
          })) {
        return;
      }
      for (size_t k = 0; k < states.size(); ++k) {
        std::string& sent = sent_[states[k].key];
        if (sent == hashes[k]) continue;
        sent = hashes[k];
        Send(Message::Make(MessageKind::kState, states[k].key, loop, 0, states[k].bytes));
      }
      Send(Message::Make(MessageKind::kBegin, kind, loop, 0));
      loop_ = loop;
      num_at_work_ = 0;
      SendItems();
    }

    void Close() {
      error_code ignored;
      socket_.close(ignored);
      network_.OnClosed(shared_from_this(), number_);
    }

   private:
    // Whether such a message is to be expected.
    bool MayFollow() const {
      if (!is_ready()) {
        return header_.kind == MessageKind::kHello && header_.num_bytes <= kMaxHelloBytes;
      }
      return header_.kind == MessageKind::kResult;
    }

    // The message's bytes, from those on that are there.
    void ReadBytes() {
      piece_in_.resize(std::min(kMaxPieceBytes, header_.num_bytes - bytes_.size()));
      asio::async_read(socket_, asio::buffer(piece_in_),
                       [self = shared_from_this()](error_code error, size_t) {
                         if (error) return self->Close();
                         self->bytes_ += self->piece_in_;
                         if (self->bytes_.size() < self->header_.num_bytes)
                           return self->ReadBytes();
                         if (!self->Take()) return self->Close();
                         self->bytes_.clear();
                         self->Read();
                       });
    }

    bool Take() {
      if (header_.kind == MessageKind::kHello) {
        if (bytes_ != HelloText(network_.token_) || header_.item == 0) return false;
        num_threads_ = static_cast<size_t>(header_.item);
        ++network_.num_ready_;
        return true;
      }
      network_.Deliver(header_, bytes_);
      if (header_.loop == loop_) {
        --num_at_work_;
        SendItems();
      }
      return true;
    }

    void SendItems() {
      while (num_at_work_ < num_threads_ + kItemsAhead) {
        const std::optional<size_t> item = network_.NextItem(number_, loop_);
        if (!item) return;
        ++num_at_work_;
        Send(Message::Make(MessageKind::kItem, 0, loop_, *item));
      }
    }

    void Send(Message message) {
      queue_.push_back(std::move(message));
      if (queue_.size() == 1) Write();
    }

    // The next piece of the first message.
    void Write() {
      const Message& message = queue_.front();
      piece_out_.clear();
      if (num_sent_ == 0) {
        piece_out_.assign(reinterpret_cast<const char*>(&message.header), sizeof message.header);
      }
      const size_t begin = num_sent_ == 0 ? 0 : num_sent_ - sizeof message.header;
      if (message.bytes) piece_out_.append(*message.bytes, begin, kMaxPieceBytes);
      asio::async_write(socket_, asio::buffer(piece_out_),
                        [self = shared_from_this()](error_code error, size_t num_bytes) {
                          if (error) return self->Close();
                          self->OnWritten(num_bytes);
                        });
    }

    void OnWritten(size_t num_bytes) {
      num_sent_ += num_bytes;
      const MessageHeader& header = queue_.front().header;
      if (num_sent_ == sizeof header + header.num_bytes) {
        queue_.pop_front();
        num_sent_ = 0;
      }
      if (!queue_.empty()) Write();
    }

    Network& network_;
    tcp::socket socket_;
    const int number_;
    MessageHeader header_;
    std::string bytes_, piece_in_, piece_out_;
    size_t num_sent_ = 0;              // of the first message in the queue
    std::deque<Message> queue_;        // to be sent; the first is being sent
    std::map<int, std::string> sent_;  // hashes of states, by key
    size_t num_threads_ = 0, num_at_work_ = 0;
    uint64_t loop_ = 0;
  };

  // What goes wrong with the connections ends these, and not the task.
  void Serve() {
    while (true) {
      try {
        io_.run();
        return;
      } catch (const std::exception& error) {
        LOG(WARNING) << "helpers are let go: " << error.what();
        CloseAll();
      }
    }
  }

  void CloseAll() {
    for (const auto& link : std::set(links_)) link->Close();
  }

  void Accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error || links_.size() >= kMaxLinks) return AcceptLater();
      const auto link = std::make_shared<Link>(this, std::move(socket), ++num_links_);
      links_.insert(link);
      link->Read();
      Accept();
    });
  }

  void AcceptLater() {
    timer_.expires_after(std::chrono::seconds(1));
    timer_.async_wait([this](error_code error) {
      if (!error) Accept();
    });
  }

  void BeginLoop(int kind, uint64_t number, const std::vector<LoopState>& states) {
    std::vector<std::string> hashes;
    for (const LoopState& state : states) hashes.push_back(HashOf(*state.bytes));
    for (const auto& link : std::set(links_)) {
      if (link->is_ready()) link->Begin(kind, number, states, hashes);
    }
  }

  void EndLoop() {
    const std::lock_guard lock(mutex_);
    present_ = {};
  }

  std::optional<size_t> NextItem(int helper, uint64_t loop) {
    const std::lock_guard lock(mutex_);
    if (present_.items == nullptr || present_.number != loop) return std::nullopt;
    return present_.items->TakeForHelper(helper);
  }

  void Deliver(const MessageHeader& header, const std::string& bytes) {
    const std::lock_guard lock(mutex_);
    if (present_.loop == nullptr || present_.number != header.loop) return;
    if (header.item >= present_.loop->count) return;
    if (!present_.items->Finish(static_cast<size_t>(header.item), true)) return;
    try {
      present_.loop->keep(static_cast<size_t>(header.item), bytes);
    } catch (...) {
      present_.items->Stop(std::current_exception());
    }
  }

  void OnClosed(const std::shared_ptr<Link>& link, int number) {
    if (links_.erase(link) == 0) return;
    if (!link->is_ready()) return;
    --num_ready_;
    const std::lock_guard lock(mutex_);
    if (present_.items != nullptr) present_.items->GiveBack(number);
  }

  // A thread of this process.
  static void Work(const SharedLoop& loop, LoopItems* items, const RunContext& context) {
    try {
      while (const auto item = items->TakeHere([&] { context.ThrowIfCancelled(); })) {
        loop.compute(*item, [&, item] { return items->Finish(*item, false); });
      }
    } catch (...) {
      items->Stop(std::current_exception());
    }
  }

  const std::filesystem::path address_file_;
  const std::string token_;
  asio::io_context io_;
  tcp::acceptor acceptor_;
  asio::steady_timer timer_{io_};
  std::set<std::shared_ptr<Link>> links_;
  int num_links_ = 0;
  uint64_t num_loops_ = 0;  // of the caller
  std::atomic<size_t> num_ready_{0}, num_by_helpers_{0};
  std::mutex mutex_;  // of what follows
  Present present_;
  std::thread thread_;  // last: it uses the others
};

HelperLeader::HelperLeader(std::filesystem::path address_file) {
  try {
    network_ = std::make_unique<Network>(std::move(address_file));
  } catch (const std::exception& error) {
    LOG(WARNING) << "no other machine can help: " << error.what();
  }
}

HelperLeader::~HelperLeader() = default;

void HelperLeader::Run(const SharedLoop& loop, const RunContext& context) {
  if (network_) return network_->Run(loop, context);
  RunContext alone = context;
  alone.helpers = nullptr;
  RunSharedLoop(loop, alone);
}

size_t HelperLeader::num_items_by_helpers() const {
  return network_ ? network_->num_by_helpers() : 0;
}

size_t HelperLeader::num_helpers() const { return network_ ? network_->num_ready() : 0; }

}  // namespace lsmvs
