#include "catch.h"
#include "folder.h"
#include "http.h"
#include "pipeline_text.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <algorithm>
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

using namespace fresco;
using namespace fresco::studio;
using fresco::testing::TemporaryFolder;

namespace
{
namespace fs = std::filesystem;

/// A server that answers with what it was asked for, and a browser of a few lines.
class Served
{
  public:
    explicit Served(std::uint64_t most_bytes = 100) : server_(options(most_bytes)), thread_([this] { server_.serve(); }) {}
    ~Served()
    {
        server_.stop();
        thread_.join();
    }

    std::string host() const { return "127.0.0.1:" + std::to_string(server_.port()); }

    /// The answer to a request as it goes over the wire.
    std::string say(const std::string& text) const
    {
        const int fd = socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(server_.port());
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        REQUIRE(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
        REQUIRE(write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
        std::string answer;
        char bytes[4096];
        for (ssize_t count = 0; (count = read(fd, bytes, sizeof bytes)) > 0;)
            answer.append(bytes, static_cast<std::size_t>(count));
        close(fd);
        return answer;
    }

    /// Status of a request; `head`: further lines, each with its end.
    int status(const std::string& method, const std::string& target, const std::string& head, const std::string& body = "") const
    {
        const std::string answer = say(method + " " + target + " HTTP/1.1\r\nConnection: close\r\n" + head + "\r\n" + body);
        return answer.size() > 12 ? std::stoi(answer.substr(9, 3)) : 0;
    }

    TemporaryFolder folder;
    std::atomic<int> handled = 0;

  private:
    ServerOptions options(std::uint64_t most_bytes)
    {
        return {.token = "0123456789abcdef",
                .body_rule =
                    [this, most_bytes](const Request& request) {
                        return BodyRule{most_bytes, request.path == "file" ? folder.path() : fs::path()};
                    },
                .handler =
                    [this](const Request& request)
                {
                    ++handled;
                    const std::string text = request.upload.empty() ? request.body : read_text_file(request.upload);
                    return Response{.body = request.method + " " + request.path + " " + text};
                }};
    }

    Server server_;
    std::thread thread_;
};

void touch(const fs::path& file, std::string_view text = "x")
{
    fs::create_directories(file.parent_path());
    write_file(file, text);
}
}  // namespace

TEST_CASE("only the page that has the token is served")
{
    const Served served;
    const std::string host = "Host: " + served.host() + "\r\n";
    CHECK(served.status("GET", "/0123456789abcdef/a%20b", host) == 200);
    CHECK(served.say("GET /0123456789abcdef/a%20b HTTP/1.1\r\nConnection: close\r\n" + host + "\r\n").ends_with("GET a b "));
    const int before = served.handled;
    CHECK(served.status("GET", "/", host) == 403);
    CHECK(served.status("GET", "/0123456789abcdee/", host) == 403);
    CHECK(served.status("GET", "/0123456789abcde/", host) == 403);
    CHECK(served.status("GET", "/0123456789abcdef", host) == 404);
    CHECK(served.status("GET", "/0123456789abcdef/%zz", host) == 400);
    CHECK(served.status("GET", "/0123456789abcdef/%00", host) == 400);
    CHECK(served.handled == before);
}

TEST_CASE("a name that was rebound, and other pages, are refused with the right token, too")
{
    const Served served;
    const std::string path = "/0123456789abcdef/";
    const std::string host = "Host: " + served.host() + "\r\n";
    CHECK(served.status("GET", path, "") == 403);
    CHECK(served.status("GET", path, "Host: evil.example\r\n") == 403);
    CHECK(served.status("GET", path, "Host: evil.example:" + served.host().substr(10) + "\r\n") == 403);
    CHECK(served.status("GET", path, "Host: 127.0.0.1:1\r\n") == 403);
    CHECK(served.status("POST", path, host + "Origin: http://evil.example\r\nContent-Length: 0\r\n") == 403);
    CHECK(served.status("POST", path, host + "Origin: null\r\nContent-Length: 0\r\n") == 403);
    CHECK(served.status("GET", path, host + "Sec-Fetch-Site: cross-site\r\n") == 403);
    CHECK(served.handled == 0);
    CHECK(served.status("POST", path, host + "Origin: http://" + served.host() + "\r\nContent-Length: 0\r\n") == 200);
}

TEST_CASE("bodies are bounded before they are read")
{
    const Served served;
    const std::string host = "Host: " + served.host() + "\r\n";
    for (const std::string name : {"memory", "file"})
    {
        const std::string path = "/0123456789abcdef/" + name;
        CHECK(served.status("PUT", path, host + "Content-Length: 100\r\n", std::string(100, 'a')) == 200);
        const int before = served.handled;
        CHECK(served.status("PUT", path, host + "Content-Length: 101\r\n") == 413);
        CHECK(served.status("PUT", path, host + "Content-Length: 99999999999999999\r\n") == 413);
        CHECK(served.status("PUT", path, host + "Transfer-Encoding: chunked\r\n") == 411);
        CHECK(served.handled == before);
    }
    CHECK(served.say("PUT /0123456789abcdef/file HTTP/1.1\r\nConnection: close\r\n" + host + "Content-Length: 3\r\n\r\nabc")
              .ends_with("PUT file abc"));
    CHECK(fs::is_empty(served.folder.path()));
    CHECK(served.status("GET", "/0123456789abcdef/" + std::string(20000, 'a'), host) != 200);
}

TEST_CASE("every answer forbids what a page could be tricked into")
{
    const Served served;
    const std::string answer =
        served.say("GET /0123456789abcdef/ HTTP/1.1\r\nConnection: close\r\nHost: " + served.host() + "\r\n\r\n");
    CHECK(answer.find("Content-Security-Policy: default-src 'none'; script-src 'self'") != std::string::npos);
    CHECK(answer.find("unsafe-inline") == std::string::npos);
    CHECK(answer.find("X-Content-Type-Options: nosniff") != std::string::npos);
    CHECK(answer.find("Access-Control") == std::string::npos);
}

TEST_CASE("a name leads to a file below the folder, or nowhere")
{
    const TemporaryFolder outside;
    touch(outside.path() / "secret.jpg");
    const TemporaryFolder folder;
    const fs::path base = fs::canonical(folder.path());
    touch(base / "in/a.jpg");
    touch(base / ".hidden/b.jpg");
    fs::create_symlink(outside.path(), base / "link");
    fs::create_symlink(outside.path() / "secret.jpg", base / "secret.jpg");
    fs::create_symlink(base / "in", base / "inner");
    CHECK(below(base, "in/a.jpg") == base / "in/a.jpg");
    CHECK(below(base, "inner/a.jpg") == base / "in/a.jpg");
    CHECK(below(base, ".") == base);
    for (const std::string& name : std::vector<std::string>{"", "..", "../" + outside.path().filename().string() + "/secret.jpg",
                                                            "in/../in/a.jpg", "/etc/passwd", "link/secret.jpg", "secret.jpg",
                                                            ".hidden/b.jpg", "in/none.jpg", "in//../../a", "./in/a.jpg"})
    {
        CAPTURE(name);
        CHECK_FALSE(below(base, name));
    }
    // A folder of which the base's name is only the beginning.
    fs::create_directories(base.string() + "_other");
    CHECK_FALSE(below(base, "../" + base.filename().string() + "_other"));
    fs::remove(base.string() + "_other");
}

TEST_CASE("recordings are found by the marks of their layouts, models and pictures by their names, and runs by their events")
{
    const TemporaryFolder folder;
    const fs::path& base = folder.path();
    const std::vector<Layout> layouts{{"layout.a", {"color|rgb", "pose-*.txt"}, {}}, {"layout.b", {"deep/*.conf"}, {".scan"}}};
    touch(base / "kitchen/rgb/0.jpg");
    touch(base / "kitchen/pose-1.txt");
    touch(base / "kitchen/depth/0.png");
    touch(base / "office/deep/x.conf");
    touch(base / "half/color/0.jpg");
    touch(base / "model.GLB");
    touch(base / "one.scan");
    touch(base / "styles/waves.jpg");
    touch(base / "out/progress.jsonl");
    touch(base / "out/views/0.png");
    touch(base / ".fresco-studio/paintings/1/out/view.glb");
    const Contents found = contents_of(base, layouts);
    REQUIRE(found.scans.size() == 4);
    const auto scan = [&](const std::string& name) { return *std::ranges::find(found.scans, name, &Scan::name); };
    CHECK(scan("kitchen").layout == "layout.a");
    CHECK(scan("kitchen").thumbnail == "kitchen/rgb/0.jpg");
    CHECK(scan("office").layout == "layout.b");
    CHECK(scan("one.scan").layout == "layout.b");
    CHECK(scan("model.GLB").kind == ScanKind::model);
    CHECK(found.pictures == std::vector<std::string>{"half/color/0.jpg", "styles/waves.jpg"});
    CHECK(found.runs == std::vector<std::string>{"out"});
    CHECK(found.complete);
}

TEST_CASE("what is added is what its name says, and replaces nothing")
{
    const TemporaryFolder folder;
    const fs::path upload = folder.path() / ".upload";
    write_file(upload, std::string_view("\x89PNG\r\n\x1a\nrest"));
    CHECK(take_in(upload, folder.path(), "a.png") == "a.png");
    CHECK(take_in(upload, folder.path(), "a.png") == "a_2.png");
    CHECK(take_in(upload, folder.path(), "../<b>.png") == "<b>.png");
    CHECK(take_in(upload, folder.path(), ".png.png") == "png.png");
    for (const std::string name : {"a.jpg", "a.glb", "a.ply", "a.html", "a", "a.svg", "a.obj"})
    {
        CAPTURE(name);
        CHECK_THROWS_AS(take_in(upload, folder.path(), name), Error);
    }
    CHECK_FALSE(fs::exists(folder.path() / "a.jpg"));
}

TEST_CASE("a painting is a pipeline file, and its settings are checked")
{
    PaintingRequest request{.scan = "/scans/a \"b\"", .picture = "/p.jpg"};
    request.settings =
        Value::Map{{"texture.stroke_cm", 6}, {"strength.color", 0.5}, {"keep", Value::List{"floor"}}, {"walls", "/w.jpg"}};
    const std::string text = pipeline_text(request);
    for (const char* line :
         {"base: room.yaml", R"(data: "/scans/a \"b\"")", "texture: {stroke_cm: 6}", "color: 0.5, strokes: 1}",
          R"(regions: {"floor": keep, walls: walls, ceiling: walls, "*": painted})", "bake: {input: {texture: mixed}}"})
    {
        CAPTURE(line);
        CHECK(text.find(line) != std::string::npos);
    }
    for (const Value::Map& settings :
         {Value::Map{{"scan.path", "/etc"}}, Value::Map{{"texture.a b", 1}}, Value::Map{{"texture.seed", Value::List{}}},
          Value::Map{{"keep", Value::List{"a: b"}}}, Value::Map{{"strength.color", "1"}}})
        CHECK_THROWS_AS(check_settings(settings), Error);
    request.picture = "/${HOME}.jpg";
    CHECK_THROWS_AS(pipeline_text(request), Error);
    CHECK_THROWS_AS(export_text(request, "exe"), Error);
}
