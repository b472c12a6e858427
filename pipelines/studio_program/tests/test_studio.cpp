#include "catch.h"
#include "folder.h"
#include "http.h"
#include "runs.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <algorithm>
#include <arpa/inet.h>
#include <fmt/format.h>
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

    /// The path of a new entrance.
    std::string entrance() { return server_.new_entrance().substr(7 + host().size()); }

    int connected() const
    {
        const int fd = socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(server_.port());
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        REQUIRE(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
        return fd;
    }

    /// The answer to a request as it goes over the wire.
    std::string say(const std::string& text) const
    {
        const int fd = connected();
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

TEST_CASE("the browser's entrance leads to the page once, and only the browser")
{
    Served served;
    const std::string host = "Host: " + served.host() + "\r\n";
    const std::string useless = served.entrance();
    CHECK(served.status("GET", "/0123456789abcdef/", host) == 200);
    CHECK(served.status("GET", useless, host) == 403);  // The page was open already.
    const std::string spent = served.entrance(), path = served.entrance();
    CHECK(served.status("GET", spent, host) == 403);
    CHECK(served.status("GET", path, "Host: evil.example\r\n") == 403);
    CHECK(served.status("GET", path, host + "Sec-Fetch-Site: cross-site\r\n") == 403);
    const std::string answer = served.say("GET " + path + " HTTP/1.1\r\nConnection: close\r\n" + host + "\r\n");
    CHECK(answer.starts_with("HTTP/1.1 303"));
    CHECK(answer.find("Location: /0123456789abcdef/\r\n") != std::string::npos);
    CHECK(served.status("GET", path, host) == 403);
    CHECK(served.handled == 1);
}

TEST_CASE("connections that say nothing keep nobody out")
{
    const Served served;
    std::vector<int> silent;
    for (int i = 0; i < 100; ++i)
        silent.push_back(served.connected());
    CHECK(served.status("GET", "/0123456789abcdef/", "Host: " + served.host() + "\r\n") == 200);
    char byte = 0;
    CHECK(read(silent.front(), &byte, 1) == 0);  // The oldest made room.
    for (const int fd : silent)
        close(fd);
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
    touch(base / "nets/vgg19.PTH");
    touch(base / "out/progress.jsonl");
    touch(base / "out/views/0.png");
    touch(base / ".fresco-studio/paintings/1/out/view.glb");
    touch(base / "gauss.ply", "ply\nproperty float f_dc_0\nend_header\n");
    const TemporaryFolder outside;
    touch(outside.path() / "secret.glb");
    fs::create_symlink(outside.path() / "secret.glb", base / "link.glb");
    fs::create_symlink(outside.path(), base / "others");
    touch(outside.path() / "secret.jpg");
    fs::create_symlink(outside.path(), base / "kitchen/a");
    fs::create_symlink(base / "model.GLB", base / "same.glb");
    const Contents found = contents_of(base, layouts);
    REQUIRE(found.scans.size() == 6);
    const auto scan = [&](const std::string& name) { return *std::ranges::find(found.scans, name, &Scan::name); };
    CHECK(scan("kitchen").layout == "layout.a");
    CHECK(scan("kitchen").thumbnail == "kitchen/rgb/0.jpg");
    CHECK(scan("office").layout == "layout.b");
    CHECK(scan("one.scan").layout == "layout.b");
    CHECK(scan("model.GLB").kind == paint::ScanKind::model);
    CHECK(scan("same.glb").kind == paint::ScanKind::model);
    CHECK(scan("gauss.ply").kind == paint::ScanKind::splats);
    CHECK(found.pictures == std::vector<std::string>{"half/color/0.jpg", "styles/waves.jpg"});
    CHECK(found.runs == std::vector<std::string>{"out"});
    CHECK(found.weights == std::vector<std::string>{"nets/vgg19.PTH"});
}

TEST_CASE("what recordings hold does not count against the entries of the folder, and an end of the search is told")
{
    const TemporaryFolder folder;
    const std::vector<Layout> layouts{{"layout.a", {"a-*|b-*|c-*|d-*|e-*|f-*|g-*|h-*|i-*|frame-*"}, {}}};
    for (int i = 0; i < 2400; ++i)
        touch(folder.path() / fmt::format("scan_{}/frame-{}", i % 3, i));
    Contents found = contents_of(folder.path(), layouts);
    CHECK(found.scans.size() == 3);
    CHECK_FALSE(found.is_cut);
    for (int i = 0; i < 20'000; ++i)
        fs::create_hard_link(folder.path() / "scan_0/frame-0", folder.path() / fmt::format("{}", i));
    CHECK(contents_of(folder.path(), layouts).is_cut);
}

TEST_CASE("what is added has a name of its own and replaces nothing")
{
    const TemporaryFolder folder;
    const fs::path upload = folder.path() / ".upload";
    for (const auto& [wanted, name] : std::vector<std::pair<std::string, std::string>>{
             {"a.png", "a.png"}, {"a.png", "a_2.png"}, {"../<b>.png", "<b>.png"}, {".png.png", "png.png"}})
    {
        write_file(upload, std::string_view("\x89PNG" + wanted));
        CHECK(take_in(upload, folder.path(), wanted) == name);
        CHECK(read_file(folder.path() / name).size() == 4 + wanted.size());
    }
    write_file(upload, std::string_view("\x89PNG"));
    for (const std::string name : {"a.html", "a", "a.svg", "a.obj", "a.glb", "a.ply"})
        CHECK_THROWS_AS(take_in(upload, folder.path(), name), Error);
    write_file(upload, std::string_view("text"));
    CHECK_THROWS_WITH(take_in(upload, folder.path(), "a.png"), Catch::Contains("not what its name says"));
    CHECK(take_in(upload, folder.path(), "a.splat") == "a.splat");
}

namespace
{

/// Paintings made by a program that waits as long as the folder has a file "wait", and notes when it was to tidy the store.
struct Workshop
{
    TemporaryFolder folder;
    fs::path program = folder.path() / "fresco";
    paint::Settings settings{.scan = "/model.glb", .pictures = {"/p.jpg"}, .for_page = true};
    Value asked{Value::Map{{"scan", "model.glb"}}};

    Workshop()
    {
        write_file(program, std::string_view("#!/bin/sh\n"
                                             "[ \"$1\" = store ] && touch \"${0%/*}/tidied\"\n"
                                             "[ \"$1\" = describe ] && echo 'warning: a plugin is missing' >&2\n"
                                             "[ \"$1\" = run ] || { echo '{}'; exit; }\n"
                                             "case \"$*\" in *--until*) exit;; esac\n"
                                             "[ -e \"${0%/*}/deaf\" ] && trap '' TERM\n"
                                             "echo '{\"event\":\"begin\"}'\n"
                                             "while [ -e \"${0%/*}/wait\" ]; do sleep 0.02; done\n"
                                             "echo told; [ ! -e \"${0%/*}/fail\" ]\n"));
        fs::permissions(program, fs::perms::owner_all);
    }

    void hold(bool on) const { on ? touch(folder.path() / "wait") : void(fs::remove(folder.path() / "wait")); }
    /// Until a painting's log has this text; its state then.
    std::string after(const Runs& runs, const std::string& id, const std::string& log, const std::string& text) const
    {
        for (int tries = 0; tries < 1000; ++tries, std::this_thread::sleep_for(std::chrono::milliseconds(10)))
            if (fs::exists(runs.folder_of(id) / log) &&
                read_text_file(runs.folder_of(id) / log).find(text) != std::string::npos &&
                (text != "ended" || runs.running().is_null()))
                return runs.find(id)->state;
        return "timed out";
    }
};
}  // namespace

TEST_CASE_METHOD(Workshop, "paintings are made one at a time, canceled, removed and resumed")
{
    {
        Runs runs(program, folder.path() / "studio");
        CHECK(runs.answer_of({"describe"}) == "{}\n");
        CHECK(runs.paint(settings, asked, "full").id == "0001");
        CHECK(after(runs, "0001", "log.jsonl", "ended") == "done");
        CHECK(read_text_file(runs.folder_of("0001") / "log.jsonl").find(R"({"event":"note","text":"told"})") !=
              std::string::npos);
        touch(folder.path() / "fail");
        runs.paint(settings, asked, "full");
        CHECK(after(runs, "0002", "log.jsonl", "ended") == "failed");
        fs::remove(folder.path() / "fail");
        hold(true);
        runs.paint(settings, asked, "full");
        CHECK(after(runs, "0003", "log.jsonl", "begin") == "running");
        CHECK_THROWS_WITH(runs.paint(settings, asked, "quick"), Catch::Contains("cancel it first"));
        CHECK_THROWS_WITH(runs.remove("0003"), Catch::Contains("cancel it first"));
        runs.cancel();
        CHECK(after(runs, "0003", "log.jsonl", "ended") == "canceled");
        runs.remove("0002");
        CHECK(runs.paintings().size() == 2);
        CHECK_THROWS_AS(runs.folder_of("../0001"), Error);
        runs.paint(settings, asked, "full");
        CHECK(after(runs, "0004", "log.jsonl", "begin") == "running");
    }
    hold(false);
    Runs runs(program, folder.path() / "studio");
    CHECK(after(runs, "0004", "log.jsonl", "ended") == "done");
    // One that waits for a preview to end is canceled.
    touch(folder.path() / "deaf");
    hold(true);
    const std::string log = fmt::format("log{}.jsonl", runs.paint(settings, asked, "preview").serial);
    CHECK(after(runs, "preview", log, "begin") == "running");
    CHECK(runs.paint(settings, asked, "full").id == "0005");
    runs.cancel();
    hold(false);
    CHECK(after(runs, "0005", "log.jsonl", "ended") == "canceled");
}

TEST_CASE_METHOD(Workshop, "StyleMesh is stopped and kept, by the next program if this one is killed meanwhile")
{
    // It makes a step when the folder has a file "go", and then waits to be stopped.
    write_file(program, std::string_view(
                            "#!/bin/sh\n"
                            "[ \"$1\" = run ] || { echo '{}'; exit; }\n"
                            "case \"$*\" in *--until*) exit;; esac\n"
                            "grep -q stop_at_step \"$2\" && exit\n"
                            "trap 'echo \"{\\\"event\\\":\\\"message\\\",\\\"stage\\\":\\\"texture\\\","
                            "\\\"text\\\":\\\"stopped after step 7; …\\\"}\"; exit 75' TERM\n"
                            "echo '{\"event\":\"begin\",\"stage\":\"texture\"}'\n"
                            "while [ ! -e \"${0%/*}/go\" ]; do sleep 0.02; done\n"
                            "echo '{\"event\":\"progress\",\"stage\":\"texture\",\"done\":7,\"total\":9,\"unit\":\"steps\"}'\n"
                            "while :; do sleep 0.02; done\n"));
    fs::permissions(program, fs::perms::owner_all);
    fs::create_directories(folder.path() / "scan");
    settings.scan = folder.path() / "scan";
    const fs::path go = folder.path() / "go", studio = folder.path() / "studio";
    std::optional<Runs> runs(std::in_place, program, studio);
    CHECK_THROWS_WITH(runs->keep(), Catch::Contains("no painting is being made"));
    asked.set("settings", Value::Map{});
    runs->paint(settings, asked, "full");
    CHECK(after(*runs, "0001", "log.jsonl", "begin") == "running");
    CHECK_THROWS_WITH(runs->keep(), Catch::Contains("only StyleMesh"));
    runs->cancel();
    CHECK(after(*runs, "0001", "log.jsonl", "ended") == "canceled");

    settings.weights = "/vgg19.pth";
    asked.set("settings", Value::Map{{"method", "stylemesh"}});
    const auto has_stop = [&](const std::string& id)
    {
        return read_text_file(runs->folder_of(id) / "painting.yaml").find("  texture: {stop_at_step: 7}\n") !=
                   std::string::npos &&
               runs->find(id)->request.at("settings").at("texture.stop_at_step") == Value(7) &&
               !fs::exists(runs->folder_of(id) / "keep");
    };
    const auto begin = [&](const std::string& id)
    {
        fs::remove(go);
        REQUIRE(runs->paint(settings, asked, "full").id == id);
        CHECK(after(*runs, id, "log.jsonl", "begin") == "running");
    };
    begin("0002");
    CHECK_THROWS_WITH(runs->keep(), Catch::Contains("has not made its first step"));
    touch(go);
    CHECK(after(*runs, "0002", "log.jsonl", "progress") == "running");
    runs->keep();
    CHECK(after(*runs, "0002", "log.jsonl", "ended") == "done");
    CHECK(has_stop("0002"));

    // Killed before it was stopped, and between the two files that get the step.
    for (const bool has_step : {false, true})
    {
        const std::string id = has_step ? "0004" : "0003";
        begin(id);
        const fs::path painting = runs->folder_of(id);
        runs.reset();
        touch(painting / "keep");
        if (has_step)
            write_file(painting / "painting.json",
                       std::string_view(R"({"settings": {"method": "stylemesh", "texture.stop_at_step": 7}})"));
        touch(go);
        runs.emplace(program, studio);
        CHECK(after(*runs, id, "log.jsonl", "ended") == "done");
        CHECK(has_stop(id));
    }

    // Canceled instead.
    begin("0005");
    runs->cancel();
    CHECK(after(*runs, "0005", "log.jsonl", "ended") == "canceled");
    CHECK_FALSE(has_stop("0005"));
}

TEST_CASE_METHOD(Workshop, "the store is tidied where it was made, and never again once the folder was elsewhere")
{
    const fs::path tidied = folder.path() / "tidied", here = folder.path() / "here", there = folder.path() / "there";
    const auto tidies = [&](const fs::path& studio)
    {
        fs::remove(tidied);
        const Runs runs(program, studio);
        return fs::exists(tidied);
    };
    CHECK_FALSE(tidies(here));
    fs::create_directories(here / "store");
    CHECK(tidies(here));
    fs::rename(here, there);
    CHECK_FALSE(tidies(there));
    fs::rename(there, here);
    CHECK_FALSE(tidies(here));
}

TEST_CASE_METHOD(Workshop, "a preview ends for the next one, and each has a log of its own")
{
    Runs runs(program, folder.path() / "studio");
    hold(true);
    asked.set("view", Value::Map{{"position_m", Value::List{0, 0, 0}}});
    const int first = runs.paint(settings, asked, "quick").serial;
    CHECK(after(runs, "preview", fmt::format("log{}.jsonl", first), "begin") == "running");
    CHECK(read_text_file(runs.folder_of("preview") / "look.yaml").find("position_m: [0,0,0]") != std::string::npos);
    const int second = runs.paint(settings, asked, "preview").serial;
    CHECK(after(runs, "preview", fmt::format("log{}.jsonl", second), "begin") == "running");
    hold(false);
    CHECK(after(runs, "preview", fmt::format("log{}.jsonl", second), "ended") == "done");
    const std::string log = read_text_file(runs.folder_of("preview") / fmt::format("log{}.jsonl", second));
    CHECK(std::ranges::count(log, '\n') == 3);
}
