#include "page_server.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <poll.h>
#include <strings.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <list>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace talus::app
{
namespace
{
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds, std::chrono::seconds;

constexpr std::size_t kConnections = PageServer::kMaxListeners + 8;  // at a time
constexpr std::size_t kMaxRequest_bytes = 8192;
constexpr seconds kMaxRequest(3), kMaxAnswer(20), kMaxWrite(5);  // how long they take
constexpr int kSendBuffer_bytes = 256 << 10;  // what a slow page has not read is old soon

/** Closes it. */
class Descriptor
{
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor()
  {
    ::shutdown(number_, SHUT_RDWR);  // a child may have it, too
    ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number_; }

 private:
  int number_;
};

/** Of a machine, on which it waits for others; -1: see errno. */
int listening_socket(const std::string& address, int port)
{
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE;
  errno = 0;
  if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) return -1;
  constexpr int kYes = 1;
  const int type = SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC;
  int made = ::socket(found->ai_family, type, 0);
  ::setsockopt(made, SOL_SOCKET, SO_REUSEADDR, &kYes, sizeof(kYes));
  if (::bind(made, found->ai_addr, found->ai_addrlen) != 0 || ::listen(made, SOMAXCONN) != 0)
  {
    const int why = errno;
    ::close(std::exchange(made, -1));
    errno = why;
  }
  ::freeaddrinfo(found);
  return made;
}

/** Of a whole request; "" where it has none. `name`: with a colon. */
std::string header(const std::string& request, const std::string& name)
{
  for (auto at = request.find("\r\n"); at + 2 < request.size(); at = request.find("\r\n", at + 2))
  {
    if (::strncasecmp(&request[at + 2], name.c_str(), name.size()) != 0) continue;
    const auto from = request.find_first_not_of(' ', at + 2 + name.size());
    return request.substr(from, request.find_first_of(" \r", from) - from);
  }
  return "";
}

/** "localhost", or an address that is no other one's name: without a port. */
bool is_this_machine(const std::string& name)
{
  in_addr address{};
  return name == "localhost" || name == "[::1]" || name == "::1" ||
         (::inet_pton(AF_INET, name.c_str(), &address) == 1 && ntohl(address.s_addr) >> 24 == 127);
}

/** "[::1]:8070" is "[::1]". */
std::string without_port(const std::string& host)
{
  const auto colon = host.rfind(':');
  return host.find(']', colon) == std::string::npos ? host.substr(0, colon) : host;
}

std::string event_text(const char* kind, const std::string& data, const std::string& id = "")
{
  return std::string("event: ") + kind + (id.empty() ? "" : "\nid: " + id) + "\ndata: " + data +
         "\n\n";
}

/** `length`: with its name, "" where the end of the connection tells it. */
std::string head_of_answer(
    const std::string& status, const std::string& type, const std::string& length = "")
{
  return "HTTP/1.1 " + status + "\r\nContent-Type: " + type + "\r\n" + length +
         "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
         "X-Frame-Options: DENY\r\nReferrer-Policy: no-referrer\r\n\r\n";
}

std::string answer_of(const std::string& status, const std::string& type, const std::string& body)
{
  return head_of_answer(status, type, "Content-Length: " + std::to_string(body.size()) + "\r\n") +
         body;
}

/** Of a browser, or of a stranger, who cannot take more bytes, memory or time than it has. */
struct Connection
{
  explicit Connection(int number) : socket(number) {}

  Descriptor socket;
  Clock::time_point end = Clock::now() + kMaxRequest;
  std::string request, answer;  //!< what has come, and what is still to be sent
  bool listens = false;  //!< to events, of which it has been sent these
  std::uint64_t map = 0, version = 0, now = 0;
  Clock::time_point now_at;
};
}  // namespace

struct PageServer::Impl
{
  Impl(const std::string& address, int port)
      : is_local(is_this_machine(address)), socket(listening_socket(address, port))
  {
  }

  void serve();
  void accept();
  bool go_on(Connection& page);
  bool receive(Connection& page);
  void answer(Connection& page);
  void begin_events(Connection& page);
  std::string next(Connection& page) const;
  bool send(Connection& page) const;
  std::string age() const
  {
    return std::to_string(std::chrono::duration<double>(Clock::now() - now_at).count());
  }
  void wake() const { ::eventfd_write(changed, 1); }

  bool is_local;
  Descriptor socket, changed{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
  std::list<Connection> connections;  //!< of the thread
  std::atomic<int> listeners{0};
  std::atomic<bool> ends{false};

  std::mutex mutex;  //!< of what follows
  std::string html, run, now;
  Clock::time_point now_at;
  std::uint64_t now_version = 0, version = 0, map = 1;
  std::map<std::uint64_t, std::string> kept;  //!< events, by version
  std::map<std::string, std::uint64_t> version_of;  //!< by name

  std::thread thread;
};

void PageServer::Impl::serve()
{
  constexpr int kLook_ms = 250;
  ::setpriority(PRIO_PROCESS, 0, 10);  // of this thread: the map comes first
  std::vector<pollfd> all;
  while (!ends)
  {
    all = {{changed, POLLIN, 0}, {socket, POLLIN, 0}};
    for (const auto& page : connections)
      all.push_back({page.socket, static_cast<short>(page.answer.empty() ? POLLIN : POLLOUT), 0});
    ::poll(all.data(), all.size(), kLook_ms);
    eventfd_t count = 0;
    ::eventfd_read(changed, &count);
    connections.remove_if([&](Connection& page) { return !go_on(page); });
    listeners = static_cast<int>(std::count_if(
        connections.begin(), connections.end(), [](const auto& page) { return page.listens; }));
    if (all[1].revents != 0) accept();
  }
}

void PageServer::Impl::accept()
{
  const int number = ::accept4(socket, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (number < 0) return std::this_thread::sleep_for(milliseconds(50));  // no file is left for it
  ::setsockopt(number, SOL_SOCKET, SO_SNDBUF, &kSendBuffer_bytes, sizeof(kSendBuffer_bytes));
  const auto asks = [](const auto& page) { return !page.listens; };
  if (connections.size() == kConnections)  // who takes longest to ask has to ask again
    connections.erase(std::find_if(connections.begin(), connections.end(), asks));
  connections.emplace_back(number);
}

/** False: it ends. */
bool PageServer::Impl::go_on(Connection& page)
{
  if (Clock::now() > page.end) return false;
  if (page.answer.empty() && !receive(page)) return false;
  if (page.listens && page.answer.empty())
  {
    const std::lock_guard lock(mutex);
    page.answer = next(page);
    page.end = page.answer.empty() ? Clock::time_point::max() : Clock::now() + kMaxWrite;
  }
  return page.answer.empty() || send(page);
}

/** Who listens says nothing more. */
bool PageServer::Impl::receive(Connection& page)
{
  char part[kMaxRequest_bytes];
  const auto count = ::recv(page.socket, part, sizeof(part) - page.request.size(), 0);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return true;
  if (count <= 0 || page.listens) return false;
  page.request.append(part, static_cast<std::size_t>(count));
  const auto end = page.request.find("\r\n\r\n");
  if (end == std::string::npos) return page.request.size() < kMaxRequest_bytes;
  page.request.resize(end + 4);
  page.end = Clock::now() + kMaxAnswer;
  answer(page);
  return true;
}

void PageServer::Impl::answer(Connection& page)
{
  const auto refuse = [&](const char* status, const char* why)
  { page.answer = answer_of(status, "text/plain", std::string(why) + "\n"); };
  const std::string line = page.request.substr(0, page.request.find("\r\n"));
  const std::string path = line.substr(0, line.find_first_of(" ?", 4));
  // A page elsewhere may call itself so.
  if (is_local && !is_this_machine(without_port(header(page.request, "Host:"))))
    return refuse(
        "403 Forbidden", "this page is for its own machine: --page-address opens it to others");
  if (line.compare(0, 4, "GET ") != 0) return refuse("405 Method Not Allowed", "GET only");
  const std::lock_guard lock(mutex);
  if (path == "GET /")
    page.answer = answer_of("200 OK", "text/html; charset=utf-8", html);
  else if (path != "GET /events")
    refuse("404 Not Found", "there is / only");
  else if (listeners >= kMaxListeners)
    refuse("503 Service Unavailable", "too many pages are open");
  else
    begin_events(page);
}

/** A page that comes again tells its last event. */
void PageServer::Impl::begin_events(Connection& page)
{
  ++listeners;
  page.listens = true;
  page.answer = head_of_answer("200 OK", "text/event-stream");
  const std::string last = header(page.request, "Last-Event-ID:"), mine = run + ".";
  unsigned long long of_map = 0, of_version = 0;
  if (last.compare(0, mine.size(), mine) == 0 &&
      std::sscanf(last.c_str() + mine.size(), "%llu.%llu", &of_map, &of_version) == 2)
    if (of_map == map) page.version = std::min<std::uint64_t>(of_version, version);
}

/** The next event for a page, "" if there is none. With the lock. */
std::string PageServer::Impl::next(Connection& page) const
{
  if (page.map != map)
  {
    if (page.map != 0) page.version = 0;
    page.map = map;
    return event_text("begin", "{\"run\":\"" + run + "\",\"map\":" + std::to_string(map) + "}");
  }
  if (page.now != now_version)
  {
    page.now = now_version;
    page.now_at = Clock::now();
    return event_text("now", age() + "\ndata: " + now);
  }
  if (const auto found = kept.upper_bound(page.version); found != kept.end())
  {
    page.version = found->first;
    return found->second;
  }
  if (Clock::now() - page.now_at < seconds(1)) return "";
  page.now_at = Clock::now();
  return event_text("idle", now.empty() ? "" : age());
}

/** As much as is taken. */
bool PageServer::Impl::send(Connection& page) const
{
  const auto count = ::send(page.socket, page.answer.data(), page.answer.size(), MSG_NOSIGNAL);
  if (count < 0) return errno == EAGAIN || errno == EINTR;
  page.answer.erase(0, static_cast<std::size_t>(count));
  return !page.answer.empty() || page.listens;
}

PageServer::PageServer(const std::string& address, int port)
    : impl_(std::make_unique<Impl>(address, port))
{
  if (impl_->socket < 0)
    throw std::runtime_error(
        "--page: nobody can be answered at " + address + ", port " + std::to_string(port) +
        (errno ? std::string(": ") + std::strerror(errno) : "") +
        "; --page PORT takes another port, --page-address another address of this machine");
}

PageServer::~PageServer()
{
  impl_->ends = true;
  impl_->wake();
  if (impl_->thread.joinable()) impl_->thread.join();
}

void PageServer::begin(const std::string& page, const std::string& run)
{
  impl_->html = page;
  impl_->run = run;
  impl_->thread = std::thread([this] { impl_->serve(); });
}

void PageServer::show_now(const std::string& data)
{
  const std::lock_guard lock(impl_->mutex);
  impl_->now = data;
  impl_->now_at = Clock::now();
  ++impl_->now_version;
  impl_->wake();
}

void PageServer::keep(const std::string& name, const char* kind, const std::string& data)
{
  auto& me = *impl_;
  const std::lock_guard lock(me.mutex);
  auto& version = me.version_of[name];
  me.kept.erase(version);
  version = ++me.version;
  const std::string id = me.run + "." + std::to_string(me.map) + "." + std::to_string(version);
  me.kept[version] = event_text(kind, data, id);
  me.wake();
}

void PageServer::forget()
{
  const std::lock_guard lock(impl_->mutex);
  impl_->kept.clear();
  impl_->version_of.clear();
  ++impl_->map;
  impl_->wake();
}

int PageServer::listeners() const { return impl_->listeners; }

}  // namespace talus::app
