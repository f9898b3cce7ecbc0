// talus-live --page on loopback: what a browser gets, and what strangers do not.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <chrono>
#include <memory>
#include <thread>

#include "command_run.h"
#include "robot.h"
#include "talus_map_run.h"

using namespace talus::test;

namespace
{
sockaddr_in local(int port)
{
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/** A connection; all waits end after some seconds. */
class Socket
{
 public:
  /** `waits`: until the other side is there. */
  explicit Socket(int port, bool waits = true)
  {
    if (!waits) ::fcntl(socket_, F_SETFL, O_NONBLOCK);
    const timeval wait{5, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof(wait));
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &wait, sizeof(wait));
    const auto to = local(port);
    (void)::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  }
  ~Socket() { ::close(socket_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void send(const std::string& text) const
  {
    ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  /** What comes until `end` has come, or no more does. */
  std::string receive(const std::string& end = "") const
  {
    std::string all;
    char part[4096];
    while (end.empty() || all.find(end) == std::string::npos)
    {
      const auto count = ::recv(socket_, part, sizeof(part), 0);
      if (count <= 0) break;
      all.append(part, static_cast<std::size_t>(count));
    }
    return all;
  }

 private:
  int socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
};

int free_port()
{
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  auto address = local(0);
  socklen_t size = sizeof(address);
  (void)::bind(socket, reinterpret_cast<const sockaddr*>(&address), size);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(socket);
  return ntohs(address.sin_port);
}

const std::string kLive = TALUS_BIN "/talus-live --backend cpu --page ";
constexpr const char* kHost = " HTTP/1.1\r\nHost: localhost\r\n";

/** A robot's map on a page. */
class Page : public CommandTest
{
 protected:
  void SetUp() override
  {
    own_domain();
    live_ = ::fork();
    if (live_ == 0)
    {
      const std::string line = "cd '" + path() + "' && exec " + kLive + std::to_string(port_) +
                               " --output live >live.txt 2>&1";
      ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      ::_exit(127);
    }
    const auto said = [&] { return read_bytes(path("live.txt")); };
    for (int i = 0; i < 1000 && said().find("joins") == std::string::npos; ++i)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (said().find("libcpp-httplib-dev") != std::string::npos) GTEST_SKIP() << said();
    }
    EXPECT_SAYS(said(), "http://127.0.0.1:" + std::to_string(port_));
  }
  void TearDown() override { end(); }

  /** How long it took [s]. */
  double end()
  {
    const auto begin = std::chrono::steady_clock::now();
    if (live_ > 0)
    {
      ::kill(live_, SIGTERM);
      ::waitpid(live_, nullptr, 0);
    }
    live_ = 0;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  std::string ask(const std::string& request) const
  {
    const Socket to(port_);
    to.send(request);
    return to.receive();
  }
  void map_drive() const
  {
    write_log(path("drive.rawlog"), floor_scans(10), Packing::Gz);
    write_bytes(path("drive.tum"), straight_tum(10));
    expect_end(shell(TALUS_BIN "/talus-replay drive.rawlog --rate 5"), 0, {"published"});
  }

  const int port_ = free_port();
  pid_t live_ = 0;
};

TEST_F(Page, refuses_what_strangers_send)
{
  const auto get = [&](const std::string& path, const std::string& more = "")
  { return ask("GET " + path + kHost + more + "\r\n"); };
  const std::string page = get("/", "Accept-Encoding: gzip\r\nRange: bytes=0-3,0-3\r\n");
  EXPECT_SAYS(page, "HTTP/1.1 200 OK");
  EXPECT_SAYS(page, "script-src 'nonce-");
  EXPECT_SAYS(page, "connect-src 'self'\"");
  EXPECT_SAYS(page, "talus-live: live</title>");
  for (const char* path : {"/../../etc/passwd", "/%2e%2e/etc/passwd", "/events/", "/page.js"})
    EXPECT_SAYS(get(path), "404 Not Found");
  EXPECT_SAYS(ask(std::string("POST /") + kHost + "Content-Length: 99999999\r\n\r\n"), " 405 ");
  for (const char* host : {"example.org", "127.example.org", "127.0.0.1.example.org:8070"})
    EXPECT_SAYS(ask(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n"), " 403 ");
  std::string headers;
  while (headers.size() < std::size_t{1} << 20) headers += "A: b\r\n";
  const std::string kAll[] = {
      std::string(10000, '\0'), "GET /" + std::string(std::size_t{1} << 20, 'a'),
      "GET /" + (kHost + headers)};
  for (const auto& text : kAll) EXPECT_SAYS_NOT(ask(text), " 200 ");
  expect_end(
      shell(kLive + std::to_string(port_) + " --output other"), 1,
      {"port " + std::to_string(port_) + ": Address already in use", "--page PORT"});
  EXPECT_FALSE(std::filesystem::exists(path("other")));
  expect_end(shell(kLive + "70000"), 2, {"'70000' is no port"});
}

TEST_F(Page, goes_on_whoever_connects)
{
  std::vector<std::unique_ptr<Socket>> pages;
  for (int i = 0; i < 16; ++i)
  {
    pages.push_back(std::make_unique<Socket>(port_));
    pages.back()->send(std::string("GET /events") + kHost + "\r\n");
    EXPECT_SAYS(pages.back()->receive("event: begin"), "text/event-stream");
  }
  EXPECT_SAYS(ask(std::string("GET /events") + kHost + "\r\n"), " 503 ");
  for (int i = 0; i < 200; ++i)  // who say nothing
    pages.push_back(std::make_unique<Socket>(port_, false));
  map_drive();
  const std::string events = pages.front()->receive("event: path");
  for (const char* text : {"event: now\ndata: 0.", "\"yaw_rad\":", "\"cells\":[", "\nid: "})
    EXPECT_SAYS(events, text);
  EXPECT_LT(end(), 3);
  EXPECT_SAYS(read_bytes(path("live.txt")), "10 frames of 10 scans are mapped");
}

TEST_F(Page, shows_the_map_in_a_browser)
{
  map_drive();
  const CommandEnd o =
      shell("/usr/bin/python3 " TALUS_BROWSER_SCRIPT " http://127.0.0.1:" + std::to_string(port_));
  if (o.code == 77) GTEST_SKIP() << o.text;
  EXPECT_EQ(o.code, 0) << o.text;
}
}  // namespace
