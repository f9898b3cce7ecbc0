#include "page_server.h"

#include <stdexcept>

#ifndef TALUS_HAS_HTTPLIB

namespace talus::app
{
struct PageServer::Impl
{
};
PageServer::PageServer(const std::string&, int)
{
  throw std::runtime_error(
      "--page: this build has no page; install the package libcpp-httplib-dev and build again");
}
PageServer::~PageServer() = default;
void PageServer::begin(const std::string&, const std::string&) {}
void PageServer::show_now(const std::string&) {}
void PageServer::keep(const std::string&, const std::string&, const std::string&) {}
void PageServer::forget() {}
int PageServer::listeners() const { return 0; }
}  // namespace talus::app

#else

#include <arpa/inet.h>
#include <httplib.h>
#include <poll.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace talus::app
{
namespace
{
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kConnections = PageServer::kMaxListeners + 8;  // at a time, others wait
constexpr std::size_t kMaxRequest_bytes = 8192;
constexpr auto kMaxRequest = std::chrono::seconds(3), kMaxAnswer = std::chrono::seconds(20),
               kMaxWrite = std::chrono::seconds(5);  // how long they take
constexpr int kSendBuffer_bytes = 256 << 10;  // what a slow page has not read is old soon

/** A connection of which a stranger cannot take more bytes, memory or time than it has: the library
 * itself reads lines of any length. */
class BoundedStream : public httplib::Stream
{
 public:
  BoundedStream(socket_t socket, const std::atomic<bool>& ends)
      : socket_(socket), ends_(ends), begin_(Clock::now())
  {
  }
  /** From now on it lasts as long as each write is fast enough. */
  void stay() { stays_ = true; }

  bool is_readable() const override { return wait(POLLIN, begin_ + kMaxRequest); }
  bool is_writable() const override { return wait(POLLOUT, end_of_write()); }
  ssize_t read(char* to, size_t size) override
  {
    if (from_ == end_ && !receive()) return -1;
    const size_t count = std::min(size, end_ - from_);
    std::memcpy(to, request_ + from_, count);
    from_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, size_t size) override
  {
    if (!wait(POLLOUT, end_of_write())) return -1;
    return ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }

 private:
  bool receive()
  {
    if (end_ == sizeof(request_) || !is_readable()) return false;
    const ssize_t count = ::recv(socket_, request_ + end_, sizeof(request_) - end_, MSG_DONTWAIT);
    if (count <= 0) return false;
    end_ += static_cast<size_t>(count);
    return true;
  }
  Clock::time_point end_of_write() const
  {
    const auto end = Clock::now() + kMaxWrite;
    return stays_ ? end : std::min(end, begin_ + kMaxAnswer);
  }
  bool wait(short events, Clock::time_point end) const
  {
    while (!ends_)
    {
      const auto left = std::chrono::duration_cast<milliseconds>(end - Clock::now());
      if (left.count() <= 0) return false;
      pollfd one{socket_, events, 0};
      const int found = ::poll(&one, 1, static_cast<int>(std::min(left, milliseconds(50)).count()));
      if (found < 0 && errno != EINTR) return false;
      if (found > 0) return (one.revents & events) != 0;
    }
    return false;
  }

  socket_t socket_;
  const std::atomic<bool>& ends_;
  Clock::time_point begin_;
  std::atomic<bool> stays_{false};
  char request_[kMaxRequest_bytes];
  std::size_t from_ = 0, end_ = 0;
};

/** What a browser has opened, or a stranger, each in a thread; who comes when all are taken waits
 * outside, so that no files are open for him. */
class Threads : public httplib::TaskQueue
{
 public:
  explicit Threads(const std::atomic<bool>& ends) : pool_(kConnections), ends_(ends) {}

  using Taken = decltype(std::declval<httplib::TaskQueue&>().enqueue({}));
  Taken enqueue(std::function<void()> work) override
  {
    std::unique_lock lock(mutex_);
    while (used_ >= kConnections && !ends_) left_.wait_for(lock, milliseconds(50));
    ++used_;
    return pool_.enqueue(
        [this, work = std::move(work)]
        {
          work();
          const std::lock_guard done(mutex_);
          --used_;
          left_.notify_one();
        });
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  httplib::ThreadPool pool_;
  const std::atomic<bool>& ends_;
  std::mutex mutex_;
  std::condition_variable left_;
  int used_ = 0;
};

/** Of the library, with bounded connections, each for one request. */
class Server : public httplib::Server
{
 public:
  std::atomic<bool> ends{false};
  /** The connection of the request that this thread answers. */
  static BoundedStream*& stream()
  {
    thread_local BoundedStream* stream = nullptr;
    return stream;
  }

 private:
  bool process_and_close_socket(socket_t socket) override
  {
    ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer_bytes, sizeof(kSendBuffer_bytes));
    BoundedStream bounded(socket, ends);
    stream() = &bounded;
    bool is_closed = false;
    const bool done = process(bounded, is_closed, 0);
    stream() = nullptr;
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return done;
  }
  static void simplify(httplib::Request& request)
  {
    request.ranges.clear();
    request.headers.erase("Accept-Encoding");  // to compress takes longer than to send
  }
  /** Versions of the library differ. */
  template <class S>
  auto process(S& to, bool& is_closed, int)
      -> decltype(this->process_request(to, true, is_closed, simplify))
  {
    return this->process_request(to, true, is_closed, simplify);
  }
  template <class S>
  auto process(S& to, bool& is_closed, long)
      -> decltype(this->process_request(to, "", 0, "", 0, true, is_closed, simplify))
  {
    return this->process_request(to, "", 0, "", 0, true, is_closed, simplify);
  }
};

/** The name of the machine in a request for it: "[::1]:8070" is "[::1]". */
std::string host_of(const httplib::Request& request)
{
  const std::string host = request.get_header_value("Host");
  const auto colon = host.rfind(':');
  return colon == std::string::npos || host.find(']', colon) != std::string::npos
             ? host
             : host.substr(0, colon);
}

bool is_this_machine(const std::string& name)
{
  in_addr address;  // and no other one's name: 127.example.org is none
  return name == "localhost" || name == "[::1]" ||
         (::inet_pton(AF_INET, name.c_str(), &address) == 1 && ntohl(address.s_addr) >> 24 == 127);
}
}  // namespace

struct PageServer::Impl
{
  struct Kept
  {
    std::string kind, data;
    std::uint64_t version = 0;
  };

  Server server;
  std::thread thread;
  bool is_local = false;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::string page, run;
  std::shared_ptr<const std::string> now;
  Clock::time_point now_at;
  std::uint64_t now_version = 0, version = 0, map = 1;
  std::map<std::uint64_t, std::shared_ptr<const Kept> > kept;  //!< by version
  std::map<std::string, std::uint64_t> version_of;  //!< by name
  int listeners = 0;

  /** What a page has been sent. */
  struct Sent
  {
    std::uint64_t map = 0, version = 0, now = 0;
    Clock::time_point at;
  };

  static std::string event(const char* kind, const std::string& data, const std::string& id = "")
  {
    return std::string("event: ") + kind + (id.empty() ? "" : "\nid: " + id) + "\ndata: " + data +
           "\n\n";
  }
  std::string age() const
  {
    const double age_s = std::chrono::duration<double>(Clock::now() - now_at).count();
    return std::to_string(age_s);
  }

  /** What a page that comes again with the identifier of its last event has. */
  Sent known(const std::string& last) const
  {
    Sent sent;
    unsigned long long of_map = 0, of_version = 0;
    const bool is_mine = last.compare(0, run.size() + 1, run + ".") == 0;
    if (is_mine &&
        std::sscanf(last.c_str() + run.size() + 1, "%llu.%llu", &of_map, &of_version) == 2)
      if (of_map == map) sent.version = std::min<std::uint64_t>(of_version, version);
    return sent;
  }

  /** The next event for a page, "" if there is none. With the lock. */
  std::string next(Sent& sent) const
  {
    if (sent.map != map)
    {
      if (sent.map != 0) sent.version = 0;
      sent.map = map;
      return event("begin", "{\"run\":\"" + run + "\",\"map\":" + std::to_string(map) + "}");
    }
    if (now && sent.now != now_version)
    {
      sent.now = now_version;
      sent.at = Clock::now();
      return event("now", age() + "\ndata: " + *now);
    }
    if (const auto found = kept.upper_bound(sent.version); found != kept.end())
    {
      sent.version = found->first;
      return event(
          found->second->kind.c_str(), found->second->data,
          run + "." + std::to_string(map) + "." + std::to_string(found->first));
    }
    constexpr auto kIdle = std::chrono::seconds(1);
    if (Clock::now() - sent.at < kIdle) return "";
    sent.at = Clock::now();
    return event("idle", now ? age() : "");
  }

  /** Sends the next event; false where the page has left, or all ends. */
  bool send_next(Sent& sent, httplib::DataSink& sink)
  {
    std::string text;
    {
      std::unique_lock lock(mutex);
      constexpr milliseconds kLook(250);
      changed.wait_for(lock, kLook, [&] { return server.ends || !(text = next(sent)).empty(); });
    }
    if (server.ends) return false;
    return text.empty() ? sink.is_writable() : sink.write(text.data(), text.size());
  }

  void answer(const httplib::Request& request, httplib::Response& response)
  {
    const auto refuse = [&](int status, const std::string& why)
    {
      response.status = status;
      response.set_content(why + "\n", "text/plain");
    };
    if (is_local && !is_this_machine(host_of(request)))  // a page elsewhere that calls itself so
      return refuse(403, "this page is for its own machine: --page-address opens it to others");
    if (request.method != "GET") return refuse(405, "GET only");
    if (request.path == "/") return answer_page(response);
    if (request.path == "/events") return answer_events(request, response);
    refuse(404, "there is / only");
  }
  void answer_page(httplib::Response& response)
  {
    const std::lock_guard lock(mutex);
    response.set_content(page, "text/html; charset=utf-8");
  }
  void answer_events(const httplib::Request& request, httplib::Response& response)
  {
    const std::lock_guard lock(mutex);
    if (listeners >= kMaxListeners)
    {
      response.status = 503;
      response.set_content("too many pages are open\n", "text/plain");
      return;
    }
    ++listeners;
    Server::stream()->stay();
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, sent = known(request.get_header_value("Last-Event-ID"))](
            size_t, httplib::DataSink& sink) mutable { return send_next(sent, sink); },
        [this](bool)
        {
          const std::lock_guard left(mutex);
          --listeners;
        });
  }
};

PageServer::PageServer(const std::string& address, int port) : impl_(std::make_unique<Impl>())
{
  auto& server = impl_->server;
  impl_->is_local = is_this_machine(address) || address == "::1";
  server.new_task_queue = [&server] { return new Threads(server.ends); };
  server.set_socket_options(  // else two programs may hear the same port
      [](socket_t socket)
      {
        const int yes = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
      });
  server.set_default_headers(
      {{"Cache-Control", "no-store"},
       {"X-Content-Type-Options", "nosniff"},
       {"X-Frame-Options", "DENY"},
       {"Referrer-Policy", "no-referrer"}});
  server.set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response)
      {
        impl_->answer(request, response);
        return Server::HandlerResponse::Handled;
      });
  errno = 0;
  if (!server.bind_to_port(address, port))
    throw std::runtime_error(
        "--page: nobody can be answered at " + address + ", port " + std::to_string(port) +
        (errno ? std::string(": ") + std::strerror(errno) : "") +
        "; --page PORT takes another port, --page-address another address of this machine");
}

PageServer::~PageServer()
{
  impl_->server.ends = true;
  impl_->changed.notify_all();
  impl_->server.stop();
  if (impl_->thread.joinable()) impl_->thread.join();
}

void PageServer::begin(const std::string& page, const std::string& run)
{
  impl_->page = page;
  impl_->run = run;
  impl_->thread = std::thread([this] { impl_->server.listen_after_bind(); });
}

void PageServer::show_now(const std::string& data)
{
  const std::lock_guard lock(impl_->mutex);
  impl_->now = std::make_shared<const std::string>(data);
  impl_->now_at = Clock::now();
  ++impl_->now_version;
  impl_->changed.notify_all();
}

void PageServer::keep(const std::string& name, const std::string& kind, const std::string& data)
{
  const std::lock_guard lock(impl_->mutex);
  auto& version = impl_->version_of[name];
  impl_->kept.erase(version);
  version = ++impl_->version;
  impl_->kept[version] = std::make_shared<const Impl::Kept>(Impl::Kept{kind, data, version});
  impl_->changed.notify_all();
}

void PageServer::forget()
{
  const std::lock_guard lock(impl_->mutex);
  impl_->kept.clear();
  impl_->version_of.clear();
  ++impl_->map;
  impl_->changed.notify_all();
}

int PageServer::listeners() const
{
  const std::lock_guard lock(impl_->mutex);
  return impl_->listeners;
}

}  // namespace talus::app

#endif
