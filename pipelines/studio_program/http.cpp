#include "http.h"

#include <fresco/error.h>
#include <fresco/value.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <chrono>
#include <fmt/format.h>
#include <limits>
#include <mutex>
#include <sys/random.h>
#include <sys/socket.h>
#include <thread>
#include <utility>
#include <vector>

namespace fresco::studio
{
namespace
{
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace fs = std::filesystem;
using tcp = asio::ip::tcp;

constexpr std::uint32_t most_head_bytes = 16384;
constexpr std::size_t most_connections = 64;

/// Takes as long for a wrong token as for a right one.
bool equal_in_constant_time(std::string_view a, std::string_view b)
{
    if (a.size() != b.size())
        return false;
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
    return difference == 0;
}

std::optional<std::map<std::string, std::string>> query_of(std::string_view text)
{
    std::map<std::string, std::string> query;
    while (!text.empty())
    {
        const std::string_view part = text.substr(0, text.find('&'));
        text.remove_prefix(std::min(text.size(), part.size() + 1));
        const std::size_t middle = std::min(part.find('='), part.size());
        const auto name = url_decoded(part.substr(0, middle));
        const auto value = url_decoded(part.substr(std::min(part.size(), middle + 1)));
        if (!name || !value)
            return std::nullopt;
        query[*name] = *value;
    }
    return query;
}

void add_head(http::fields& fields, const Response& response)
{
    fields.set(http::field::content_type, response.type);
    fields.set(http::field::cache_control, "no-store");
    fields.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
               "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    fields.set("X-Content-Type-Options", "nosniff");
    fields.set("Referrer-Policy", "no-referrer");
    fields.set("Cross-Origin-Resource-Policy", "same-origin");
    if (!response.tag.empty())
        fields.set(http::field::etag, response.tag);
    if (!response.location.empty())
        fields.set(http::field::location, response.location);
    if (!response.download.empty())
    {
        std::string name;
        for (const char c : response.download)
            name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' ? c : '_';
        fields.set(http::field::content_disposition, "attachment; filename=\"" + name + "\"");
    }
}

/// A file that is removed again.
class UploadFile
{
  public:
    explicit UploadFile(const fs::path& folder) : path_(folder / (".upload-" + random_token())) {}
    UploadFile(const UploadFile&) = delete;
    UploadFile& operator=(const UploadFile&) = delete;
    ~UploadFile()
    {
        std::error_code error;
        fs::remove(path_, error);
    }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};
}  // namespace

struct Server::State
{
    explicit State(ServerOptions given) : options(std::move(given)), acceptor(context) {}

    /// Why the request is refused; nullopt: it is not. Fills `request`.
    std::optional<Response> check(const http::fields& head, const std::string& method, std::string_view target, Request& request)
    {
        const std::string host(head[http::field::host]);
        if (std::ranges::find(hosts, host) == hosts.end())
            return refusal(403, "this address is not the studio's");
        // Browsers send it with everything that changes something.
        if (const std::string origin(head[http::field::origin]); !origin.empty() && origin != "http://" + host)
            return refusal(403, "another page asks; only the studio's own may");
        if (const std::string site(head["Sec-Fetch-Site"]); site == "cross-site" || site == "same-site")
            return refusal(403, "another page asks; only the studio's own may");
        if (target.empty() || target.front() != '/')
            return refusal(400, "not a path");
        target.remove_prefix(1);
        const std::string_view token = target.substr(0, target.find_first_of("/?"));
        if (is_entrance(token))
            return Response{.status = 303, .location = "/" + options.token + "/"};
        if (!equal_in_constant_time(token, options.token))
            return refusal(403, "the address lacks its token, or was used before: open the one that fresco studio has printed");
        {
            const std::lock_guard lock(mutex);
            entrance.clear();  // The page is open.
        }
        target.remove_prefix(token.size());
        if (!target.starts_with('/'))
            return refusal(404, "the address ends with a '/' after the token");
        target.remove_prefix(1);
        const std::size_t mark = std::min(target.find('?'), target.size());
        const auto path = url_decoded(target.substr(0, mark));
        const auto query = query_of(target.substr(std::min(target.size(), mark + 1)));
        if (!path || !query)
            return refusal(400, "the address is not encoded as URLs are");
        request.method = method;
        request.path = *path;
        request.query = *query;
        return std::nullopt;
    }

    bool is_entrance(std::string_view code)
    {
        const std::lock_guard lock(mutex);
        const bool is_open = !entrance.empty() && std::chrono::steady_clock::now() < entrance_end;
        return is_open && equal_in_constant_time(code, entrance) && !std::exchange(entrance, {}).empty();
    }

    void send(tcp::socket& stream, const Response& response, bool keep_alive, unsigned version) const
    {
        beast::error_code error;
        const auto sent = [&](auto message)
        {
            add_head(message, response);
            message.keep_alive(keep_alive);
            message.prepare_payload();
            http::write(stream, message, error);
        };
        const auto status = static_cast<http::status>(response.status);
        if (response.file.empty())
            return sent(http::response<http::string_body>(status, version, response.body));
        http::response<http::file_body> message(status, version);
        message.body().open(response.file.c_str(), beast::file_mode::scan, error);
        if (error)
            return send(stream, refusal(404, "no such file"), keep_alive, version);
        sent(std::move(message));
    }

    Response handled(Request& request) const
    {
        try
        {
            return options.handler(request);
        }
        catch (const std::exception& error)
        {
            return refusal(400, error.what());
        }
    }

    void converse(tcp::socket& stream)
    {
        beast::flat_buffer buffer(std::size_t{1} << 20U);
        for (beast::error_code error; !error;)
        {
            http::request_parser<http::empty_body> head;
            head.header_limit(most_head_bytes);
            head.body_limit(std::numeric_limits<std::uint64_t>::max());  // Judged below, before any of it is read.
            http::read_header(stream, buffer, head, error);
            if (error)
                break;
            note(stream.native_handle(), true);
            const auto& fields = head.get();
            const unsigned version = fields.version();
            const bool keep_alive = fields.keep_alive();
            const std::string target(fields.target());
            Request request;
            auto refused = check(fields.base(), std::string(fields.method_string()), target, request);
            BodyRule rule;
            if (!refused && !head.is_done())
            {
                rule = options.body_rule(request);
                const auto length = head.content_length();
                if (!length)
                    refused = refusal(411, "the size of the upload is missing");
                else if (*length > rule.most_bytes)
                    refused = refusal(413, fmt::format("at most {} MB are accepted here", rule.most_bytes >> 20U));
            }
            if (refused)
            {
                send(stream, *refused, false, version);
                break;
            }
            std::optional<UploadFile> upload;
            if (!head.is_done() && !rule.folder.empty())
            {
                upload.emplace(rule.folder);
                http::request_parser<http::file_body> parser(std::move(head));
                parser.body_limit(rule.most_bytes);
                parser.get().body().open(upload->path().c_str(), beast::file_mode::write_new, error);
                while (!error && !parser.is_done())
                {
                    http::read_some(stream, buffer, parser, error);
                    note(stream.native_handle(), true);
                }
                parser.get().body().close();
                request.upload = upload->path();
            }
            else if (!head.is_done())
            {
                http::request_parser<http::string_body> parser(std::move(head));
                parser.body_limit(rule.most_bytes);
                http::read(stream, buffer, parser, error);
                request.body = std::move(parser.get().body());
            }
            if (upload && error == boost::system::errc::no_space_on_device)
                send(stream, refusal(507, "the disk is full: free some space, and add the file again"), false, version);
            if (error)
                break;
            send(stream, handled(request), keep_alive, version);
            if (!keep_alive)
                break;
        }
        beast::error_code ignored;
        stream.shutdown(tcp::socket::shutdown_send, ignored);
        // A browser that still sends what was refused would lose the answer.
        std::vector<char> rest(std::size_t{1} << 16U);
        for (int count = 0; count < 1024 && !ignored; ++count)
            stream.read_some(asio::buffer(rest), ignored);
    }

    /// Keeps the handle of an open connection and when it last said something, so that stop() and make_room() can end it while it
    /// waits for its next request.
    void note(int handle, bool is_open)
    {
        const std::lock_guard lock(mutex);
        if (is_open)
            heard[handle] = std::chrono::steady_clock::now();
        else
            heard.erase(handle);
        if (is_open && stopped)
            ::shutdown(handle, SHUT_RDWR);
    }

    /// Ends the connection that has been silent longest where there are too many: idle ones keep nobody out.
    void make_room()
    {
        const std::lock_guard lock(mutex);
        if (heard.size() >= most_connections)
        {
            const auto silent = std::ranges::min_element(heard, {}, [](const auto& each) { return each.second; });
            ::shutdown(silent->first, SHUT_RDWR);
            heard.erase(silent);
        }
    }

    ServerOptions options;
    asio::io_context context;
    tcp::acceptor acceptor;
    std::vector<std::string> hosts;
    std::atomic<std::size_t> connections = 0;
    std::atomic<bool> stopped = false;
    std::mutex mutex;
    std::map<int, std::chrono::steady_clock::time_point> heard;  ///< By the handles of open connections.
    std::string entrance;
    std::chrono::steady_clock::time_point entrance_end;
};

Response refusal(int status, const std::string& text)
{
    return {.status = status, .body = to_json(Value::Map{{"error", text}})};
}

std::string random_token()
{
    std::array<unsigned char, 16> bytes{};
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw Error("the kernel gives no random numbers");
    std::string text;
    for (const unsigned char byte : bytes)
        text += fmt::format("{:02x}", byte);
    return text;
}

std::optional<std::string> url_decoded(std::string_view text)
{
    const auto digit = [](char c) {
        return c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
    };
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i)
    {
        if (text[i] != '%')
        {
            result += text[i];
            continue;
        }
        if (i + 2 >= text.size() || digit(text[i + 1]) < 0 || digit(text[i + 2]) < 0)
            return std::nullopt;
        result += static_cast<char>(16 * digit(text[i + 1]) + digit(text[i + 2]));
        i += 2;
    }
    return result.find('\0') == std::string::npos ? std::optional(result) : std::nullopt;
}

Server::Server(ServerOptions options) : state_(std::make_unique<State>(std::move(options)))
{
    boost::system::error_code error;
    const auto address = asio::ip::make_address(state_->options.host, error);
    if (error)
        throw Error("--host " + state_->options.host + ": not an address, such as 127.0.0.1");
    if (address.is_unspecified())
        throw Error("--host " + state_->options.host +
                    ": name one address of this machine, so that requests for others can be refused");
    const tcp::endpoint endpoint(address, state_->options.port);
    state_->acceptor.open(endpoint.protocol(), error);
    if (!error)
        state_->acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error)
        state_->acceptor.bind(endpoint, error);
    if (!error)
        state_->acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error)
        throw Error(fmt::format("port {} of {} cannot be opened: {}; choose another with --port", state_->options.port,
                                state_->options.host, error.message()));
    const std::string at = ":" + std::to_string(port());
    const std::string shown = address.is_v6() ? "[" + state_->options.host + "]" : state_->options.host;
    state_->hosts = {shown + at, "localhost" + at, "127.0.0.1" + at};
    if (port() == 80)
        for (std::size_t i = 0; i < 3; ++i)
            state_->hosts.push_back(state_->hosts[i].substr(0, state_->hosts[i].size() - at.size()));
}

Server::~Server() = default;

std::uint16_t Server::port() const
{
    return state_->acceptor.local_endpoint().port();
}

std::string Server::address() const
{
    return "http://" + state_->hosts.front() + "/" + state_->options.token + "/";
}

std::string Server::new_entrance()
{
    const std::lock_guard lock(state_->mutex);
    state_->entrance = random_token();
    state_->entrance_end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    return "http://" + state_->hosts.front() + "/" + state_->entrance + "/";
}

void Server::serve()
{
    while (!state_->stopped)
    {
        boost::system::error_code error;
        tcp::socket socket(state_->context);
        state_->acceptor.accept(socket, error);
        if (error)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));  // Descriptors may be free again.
        if (error || state_->stopped || state_->connections >= 2 * most_connections)
            continue;
        state_->make_room();
        state_->note(socket.native_handle(), true);
        ++state_->connections;
        std::thread(
            [state = state_.get()](tcp::socket taken)
            {
                {
                    // Closed before the state may go, whose context it belongs to.
                    tcp::socket stream = std::move(taken);
                    try
                    {
                        state->converse(stream);
                    }
                    catch (const std::exception& cause)
                    {
                        fmt::print(stderr, "warning: a connection ended: {}\n", cause.what());
                    }
                    state->note(stream.native_handle(), false);
                }
                --state->connections;
            },
            std::move(socket))
            .detach();
    }
    // Connections refer to the state until they end.
    while (state_->connections > 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

void Server::stop()
{
    const std::lock_guard lock(state_->mutex);
    state_->stopped = true;
    ::shutdown(state_->acceptor.native_handle(), SHUT_RDWR);
    for (const auto& [handle, unused] : state_->heard)
        ::shutdown(handle, SHUT_RDWR);
}

}  // namespace fresco::studio
