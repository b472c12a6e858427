#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

/// \file A web server for one user on one machine. Everything that a stranger's page could use against it is refused before a
/// handler sees the request: another Host (DNS rebinding), another Origin, a missing token, a body that is too large. Paths begin
/// with the token, so that every relative address in the page carries it. The browser that is opened gets a code in its place,
/// which works once: whoever may read this machine's list of processes finds it spent.

namespace fresco::studio
{

struct Request
{
    std::string method{};
    std::string path{};                          ///< Without the token and what follows '?', decoded: "api/state".
    std::map<std::string, std::string> query{};  ///< Decoded.
    std::string body{};                          ///< The body, unless it went to a file.
    std::filesystem::path upload{};              ///< The file with the body; removed after the handler.
};

struct Response
{
    int status = 200;
    std::string type = "application/json";
    std::string body{};
    std::filesystem::path file{};  ///< Sent instead of the body.
    std::string location{};        ///< The address that a status of 303 leads to.
    std::string download{};        ///< Name under which the browser saves it; empty: it shows it.
    std::string tag{};             ///< Another file at the same address has another one.
};

/// {"error": text}
Response refusal(int status, const std::string& text);

/// Limits of a request's body, decided by its head.
struct BodyRule
{
    std::uint64_t most_bytes = 0;
    std::filesystem::path folder{};  ///< The body goes to a new file in it; empty: to memory.
};

struct ServerOptions
{
    std::string host = "127.0.0.1";  ///< An address of this machine.
    std::uint16_t port = 0;          ///< 0: any that is free.
    std::string token{};
    std::function<BodyRule(const Request&)> body_rule{};
    std::function<Response(const Request&)> handler{};
};

/// 32 hexadecimal digits from the kernel.
std::string random_token();

/// Decodes %XX; empty for what is no valid encoding or holds a zero byte.
std::optional<std::string> url_decoded(std::string_view text);

class Server
{
  public:
    /// Opens the port; throws Error if that fails.
    explicit Server(ServerOptions options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::uint16_t port() const;
    /// "http://127.0.0.1:8123/TOKEN/"
    std::string address() const;
    /// An address that leads to the other one, once, for a minute and until the other is used; the one given before is void.
    std::string new_entrance();
    /// Serves until stop(), which any thread may call.
    void serve();
    void stop();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace fresco::studio
