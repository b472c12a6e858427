#include "folder.h"
#include "http.h"
#include "runs.h"

#include <page_parts.h>

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/page/page.h>
#include <fresco/process.h>
#include <fresco/wording.h>

#include <command_program.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <mutex>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

/// \file The program fresco-studio, which `fresco studio` runs: shows scans, paints them by `fresco run` and shows the results,
/// in a page at 127.0.0.1.

using namespace fresco;
using namespace fresco::studio;

namespace
{
namespace fs = std::filesystem;

constexpr std::uint64_t megabyte = std::uint64_t{1} << 20U;
constexpr std::uint64_t most_model_bytes = 512 * megabyte;
constexpr std::uint64_t most_picture_bytes = 64 * megabyte;
constexpr std::uint64_t most_weights_bytes = 600 * megabyte;  // The whole VGG-19 has 548 MB.
constexpr const char* shipped = "shipped/";
constexpr const char* no_weights = "none";  // Exports need no weights.
constexpr const char* stylemesh = "texture.optimize";

/// Whether the folder is a run's own output folder, into which nothing is written but by the run: it is only watched.
bool is_only_watched(const fs::path& folder)
{
    return fs::exists(folder / "progress.jsonl") && !fs::exists(folder / ".fresco-studio");
}

/// Tells the log of one run from that of the next in the same place, which may even get its inode. It is weak (W/) while the run
/// goes on, which locks its log until it ends or is killed.
std::string log_tag(const fs::path& log)
{
    const FileDescriptor file(open(log.c_str(), O_RDONLY | O_CLOEXEC));
    struct statx status = {};
    statx(file.get(), "", AT_EMPTY_PATH, STATX_INO | STATX_BTIME, &status);
    struct flock lock = {};
    lock.l_type = F_RDLCK;
    const bool is_locked = fcntl(file.get(), F_OFD_GETLK, &lock) != 0 || lock.l_type != F_UNLCK;
    return fmt::format("{}\"{}-{}-{}\"", is_locked ? "W/" : "", status.stx_ino, status.stx_btime.tv_sec,
                       status.stx_btime.tv_nsec);
}

class Studio
{
  public:
    Studio(const fs::path& program, fs::path folder, bool only_watches, const std::string& weights)
        : folder_(std::move(folder)), pictures_(program.parent_path().parent_path() / "share/fresco/pipelines/pictures"),
          only_watches_(only_watches), runs_(program, only_watches ? fs::path() : folder_ / ".fresco-studio"),
          given_weights_(weights.empty() ? fs::path() : fs::absolute(weights))
    {
        std::error_code error;
        pictures_ = fs::canonical(pictures_, error);
        declarations_ = Value::Map{};
        for (const char* type : {"texture.synthesize", "atlas.project", "texture.relief", "texture.mix", "scan.mesh"})
            declare(type);
        const Value types = parse_json(runs_.answer_of({"stages", "--json"}), "stages");
        for (const Value& type : types.at("types").as_list())
            if (type.at("kind").as_string() == "layout")
                add_layout(type.at("type").as_string());
            else if (type.at("type").as_string() == stylemesh)
                declare(stylemesh);
    }

    BodyRule body_rule(const Request& request) const
    {
        if (request.method == "PUT" && request.path == "add" && !only_watches_)
            return {is_picture(name_in(request)) ? most_picture_bytes : most_model_bytes, folder_ / ".fresco-studio"};
        return {request.path == "api/thumbnail" ? megabyte : megabyte / 16, {}};
    }

    Response answer(const Request& request)
    {
        if (request.method == "GET")
            return shown(request);
        if (only_watches_)
            return refusal(403,
                           "this is the folder of a run, which is only watched: start fresco studio in another folder to paint");
        if (request.method == "PUT" && request.path == "add")
            return json(Value::Map{{"name", take_in(request.upload, folder_, name_in(request))}});
        if (request.method == "PUT" && request.path == "api/thumbnail")
            return set_thumbnail(request);
        if (request.method != "POST")
            return refusal(405, "not a request that the studio knows");
        return done(request.path, parse_json(request.body.empty() ? "{}" : request.body, "request"));
    }

  private:
    static Response json(const Value& value) { return {.body = to_json(value)}; }
    static Response started(const Started& run) { return json(Value::Map{{"id", run.id}, {"serial", run.serial}}); }

    static std::string name_in(const Request& request)
    {
        const auto name = request.query.find("name");
        return name == request.query.end() ? "" : fs::path(name->second).filename().string();
    }

    void declare(const char* type) { declarations_.set(type, parse_json(runs_.answer_of({"describe", type, "--json"}), type)); }

    void add_layout(const std::string& type)
    {
        const Value described = parse_json(runs_.answer_of({"describe", type, "--json"}), type);
        const Value* marks = described.at("declaration").find("marks");
        if (marks == nullptr)
            return;
        Layout layout{.type = type};
        for (const Value& mark : marks->at("contains").as_list())
            layout.contains.push_back(mark.as_string());
        for (const Value& format : marks->at("formats").as_list())
            for (const Value& extension : format.at("extensions").as_list())
                layout.extensions.push_back(extension.as_string());
        const Value::List& before = marks->at("before").as_list();
        layouts_.insert(before.empty() ? layouts_.end() : layouts_.begin(), std::move(layout));
    }

    Response page_part(const std::string& path) const
    {
        if (path.empty())
            return {.type = "text/html; charset=utf-8", .body = page_html};
        if (path == "icon.svg")
            return {.type = "image/svg+xml", .body = page_icon};
        if (path == "studio.css")
            return {.type = "text/css", .body = std::string(page::room_scripts().css) + page_css};
        if (path == "studio.js")
            return {.type = "text/javascript", .body = "\"use strict\";\n" + std::string(page::room_scripts().js) + page_js};
        return {.type = "text/javascript", .body = std::string(page::room_scripts().library)};
    }

    Response shown(const Request& request)
    {
        const std::string& path = request.path;
        if (path.empty() || path == "icon.svg" || path == "studio.css" || path == "studio.js" || path == "three.js")
            return page_part(path);
        if (path == "api/folder")
        {
            Contents contents = contents_of(folder_, layouts_);
            if (only_watches_)
                contents.scans.clear();
            Value value = as_value(contents);
            value.set("shipped", shipped_pictures());
            value.set("folder", folder_.string());
            value.set("only_watches", only_watches_);
            return json(value);
        }
        if (path == "api/declarations")
            return json(declarations_);
        if (path == "api/state")
            return json(state());
        if (path == "api/stylemesh")
        {
            const Network found = network();
            return json(Value::Map{{"weights", found.weights.string()}, {"lack", found.lack}});
        }
        if (path == "api/pipeline")
            return as_pipeline(request);
        if (path.starts_with("picture/"))
            return file_response(picture(path.substr(8)), {".jpg", ".jpeg", ".png", ".webp", ".avif", ".bmp"}, request);
        if (path.starts_with("painting/"))
            return painting_file(path.substr(9), request);
        if (path.starts_with("run/"))
            return file_response(
                below(folder_, path.substr(4)),
                {".jsonl", ".png", ".jpg", ".glb", ".gltf", ".bin", ".obj", ".ply", ".splat", ".spz", ".jpeg", ".webp"}, request);
        return refusal(404, "there is nothing at this address");
    }

    Response done(const std::string& path, const Value& body)
    {
        const JsonPlace place(body, "request");
        if (path == "api/paint")
        {
            place.has_only({"scan", "picture", "settings", "care", "view"});
            const paint::Settings settings = settings_of(body);
            if (settings.weights == no_weights)
                throw Error(network().lack);
            return started(runs_.paint(settings, body, place["care"].text()));
        }
        if (path == "api/take")
        {
            const std::string id = place["id"].text();
            const auto painting = runs_.find(id);
            if (!painting)
                throw Error(id + ": no such painting");
            return started(runs_.take(id, settings_of(painting->request), place["kind"].text()));
        }
        if (path == "api/cancel")
            runs_.cancel();
        else if (path == "api/keep")
            runs_.keep();
        else if (path == "api/delete")
            runs_.remove(place["id"].text());
        else
            return refusal(404, "there is nothing at this address");
        return json(Value::Map{});
    }

    Value state() const
    {
        Value::List paintings;
        for (const Painting& painting : runs_.paintings())
            paintings.push_back(Value::Map{{"id", painting.id},
                                           {"state", painting.state},
                                           {"request", painting.request},
                                           {"thumbnail", painting.has_thumbnail}});
        return Value::Map{{"running", runs_.running()}, {"paintings", std::move(paintings)}};
    }

    Value shipped_pictures() const
    {
        std::vector<std::string> names;
        std::error_code error;
        for (fs::directory_iterator entry(pictures_, error); !error && entry != fs::directory_iterator(); entry.increment(error))
            if (is_picture(entry->path()))
                names.push_back(shipped + entry->path().filename().string());
        std::ranges::sort(names);
        return Value::List(names.begin(), names.end());
    }

    std::optional<fs::path> picture(const std::string& name) const
    {
        if (name.starts_with(shipped))
            return below(pictures_, name.substr(std::string_view(shipped).size()));
        return below(folder_, name);
    }

    /// Throws Error naming what is not there.
    paint::Settings settings_of(const Value& asked) const
    {
        const JsonPlace place(asked, "request");
        const auto existing = [](const std::optional<fs::path>& path, const std::string& name)
        {
            if (!path)
                throw Error(name + ": not in the folder any more");
            return *path;
        };
        const std::string scan = place["scan"].text(), style = place["picture"].text();
        paint::Settings settings{.scan = existing(below(folder_, scan), scan),
                                 .pictures = {existing(picture(style), style)},
                                 .chosen = place["settings"].value(),
                                 .for_page = true};
        if (const Value* method = settings.chosen.find("method"))
        {
            if (method->as_string() != "stylemesh")
                throw Error("method: expected stylemesh, or none for brush strokes");
            std::erase_if(settings.chosen.as_map(), [](const Value::Entry& entry) { return entry.first == "method"; });
            settings.weights = network().weights;
            if (settings.weights.empty())
                settings.weights = no_weights;
        }
        if (const Value* walls = settings.chosen.find("walls"))
            settings.chosen.set("walls", existing(picture(walls->as_string()), walls->as_string()).string());
        return settings;
    }

    Response as_pipeline(const Request& request) const
    {
        const std::string id = request.query.contains("id") ? request.query.at("id") : "";
        const auto painting = runs_.find(id);
        if (!painting || id == "preview")
            return refusal(404, "no such painting");
        return json(Value::Map{{"text", read_text_file(runs_.folder_of(id) / "painting.yaml")},
                               {"command", "fresco run painting.yaml --store ../../store --out out"},
                               {"folder", runs_.folder_of(id).string()}});
    }

    Response painting_file(const std::string& path, const Request& request) const
    {
        const std::size_t slash = std::min(path.find('/'), path.size());
        std::error_code error;
        const fs::path folder = fs::canonical(runs_.folder_of(path.substr(0, slash)), error);
        if (error || slash + 1 >= path.size())
            return refusal(404, "no such painting");
        return file_response(below(folder, path.substr(slash + 1)),
                             {".jsonl", ".jpg", ".png", ".glb", ".gltf", ".bin", ".usdz", ".obj", ".mtl", ".ply", ".html", ".mp4",
                              ".spz", ".splat"},
                             request);
    }

    static Response file_response(const std::optional<fs::path>& file, std::initializer_list<std::string_view> extensions,
                                  const Request& request)
    {
        static const std::map<std::string, std::string> types{{".jpg", "image/jpeg"},
                                                              {".jpeg", "image/jpeg"},
                                                              {".png", "image/png"},
                                                              {".webp", "image/webp"},
                                                              {".avif", "image/avif"},
                                                              {".bmp", "image/bmp"},
                                                              {".jsonl", "text/plain; charset=utf-8"}};
        const std::string extension = file ? lower_extension(*file) : "";
        if (!file || !fs::is_regular_file(*file) || std::ranges::find(extensions, extension) == extensions.end())
            return request.query.contains("optional") ? Response{.status = 204} : refusal(404, "no such file");
        const auto type = types.find(extension);
        Response response{.type = type == types.end() ? "application/octet-stream" : type->second, .file = *file};
        if (const auto from = request.query.find("from"); from != request.query.end())
        {
            // A page asks for the rest of a log that it has read up to there.
            std::ifstream stream(*file, std::ios::binary);
            stream.seekg(static_cast<std::streamoff>(std::strtoull(from->second.c_str(), nullptr, 10)));
            response.body.resize(std::size_t{1} << 20U);  // The page asks on.
            stream.read(response.body.data(), static_cast<std::streamsize>(response.body.size()));
            response.body.resize(static_cast<std::size_t>(stream.gcount()));
            response.tag = log_tag(*file);
            response.file.clear();
        }
        // Never shown as a page of this address, whatever it holds.
        if (type == types.end())
            response.download = file->filename();
        return response;
    }

    Response set_thumbnail(const Request& request)
    {
        const std::string id = request.query.contains("id") ? request.query.at("id") : "";
        if (!request.body.starts_with("\xff\xd8\xff") || !runs_.find(id))
            return refusal(400, "expected a JPEG of a painting");
        write_durable_file(runs_.folder_of(id) / "thumb.jpg", std::string_view(request.body));
        return json(Value::Map{});
    }

    /// VGG-19 for StyleMesh; `lack`: why it cannot be painted with, empty if it can.
    struct Network
    {
        fs::path weights{};
        std::string lack{};
    };

    Network network() const
    {
        if (declarations_.find(stylemesh) == nullptr)
            return {{}, "StyleMesh needs libtorch, without which this fresco was built (sdk/docs/building.md)"};
        std::vector<fs::path> files{given_weights_};
        if (given_weights_.empty())
        {
            files.clear();
            for (const std::string& name : contents_of(folder_, layouts_).weights)
                if (fs::file_size(folder_ / name) <= most_weights_bytes)
                    files.push_back(folder_ / name);
        }
        std::string lack =
            "StyleMesh needs weights of VGG-19: start fresco studio with --weights FILE, or put the file into this "
            "folder; fresco weights get vgg19 downloads it";
        for (const fs::path& file : files)
        {
            const std::string fault = fault_of(file);
            if (fault.empty())
                return {file, {}};
            lack = "StyleMesh needs weights of VGG-19 up to conv5_1, as fresco weights get vgg19 downloads them; " + fault;
        }
        return {{}, lack};
    }

    /// Why a file cannot serve as weights; empty if it can. Files are read once.
    std::string fault_of(const fs::path& file) const
    {
        const std::lock_guard lock(inspecting_);
        std::error_code error;
        const auto& [entry, is_new] = faults_.try_emplace({file, fs::last_write_time(file, error)});
        if (is_new)
            try
            {
                const std::string told = runs_.answer_of({"weights", "inspect", file});
                const std::size_t end = told.find(" to conv");
                if (end == std::string::npos || told.compare(end + 8, 3, "5_1") < 0)
                    entry->second = file.filename().string() + " ends at " + told.substr(std::min(end + 4, told.size()), 7);
            }
            catch (const Error& fault)
            {
                entry->second = fault.what();
            }
        return entry->second;
    }

    fs::path folder_;
    fs::path pictures_;
    bool only_watches_;
    Runs runs_;
    fs::path given_weights_;
    mutable std::mutex inspecting_;
    mutable std::map<std::pair<fs::path, fs::file_time_type>, std::string> faults_;  ///< By file and time of its last change.
    Value declarations_;
    std::vector<Layout> layouts_;
};

struct Arguments
{
    std::string folder = ".";
    std::string host = "127.0.0.1";
    int port = 0;
    bool no_browser = false;
    std::string weights;
};

/// One studio per folder: a second would paint over the first one's paintings.
FileDescriptor locked(const fs::path& studio)
{
    fs::create_directories(studio);
    FileDescriptor file(open((studio / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (!file.valid() || flock(file.get(), LOCK_EX | LOCK_NB) != 0)
        throw Error(studio.parent_path().string() + ": cannot be locked; is another fresco studio open in this folder?");
    // A killed studio leaves its uploads behind.
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(studio, error))
        if (entry.path().filename().string().starts_with(".upload-"))
            fs::remove(entry.path(), error);
    return file;
}

void open_browser(const std::string& address)
{
    const bool display = std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
    const std::string opener = display ? find_program("xdg-open") : "";
    if (opener.empty())
        return;
    const pid_t child = fork();
    if (child == 0)
    {
        if (fork() != 0)
            _exit(0);            // So that nobody has to wait for the browser itself.
        close_range(3, ~0U, 0);  // It may outlive the studio, whose port must be free then.
        std::signal(SIGPIPE, SIG_DFL);
        sigset_t none;
        sigemptyset(&none);
        sigprocmask(SIG_SETMASK, &none, nullptr);
        setsid();
        execl(opener.c_str(), "xdg-open", address.c_str(), nullptr);
        _exit(1);
    }
    if (child > 0)
        waitpid(child, nullptr, 0);
}

int serve(const Arguments& arguments)
{
    std::error_code error;
    const fs::path folder = fs::canonical(arguments.folder, error);
    if (error || !fs::is_directory(folder))
        throw MissingInput(arguments.folder + ": no such folder");
    if (!arguments.weights.empty() && !fs::is_regular_file(arguments.weights))
        throw MissingInput(arguments.weights + ": no such file");
    const bool only_watches = is_only_watched(folder);
    const FileDescriptor lock = only_watches ? FileDescriptor() : locked(folder / ".fresco-studio");
    const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "fresco";
    sigset_t ends;
    sigemptyset(&ends);
    for (const int number : {SIGINT, SIGTERM, SIGHUP})
        sigaddset(&ends, number);
    pthread_sigmask(SIG_BLOCK, &ends, nullptr);
    Studio studio(program, folder, only_watches, arguments.weights);
    Server server({.host = arguments.host,
                   .port = static_cast<std::uint16_t>(arguments.port),
                   .token = random_token(),
                   .body_rule = [&](const Request& request) { return studio.body_rule(request); },
                   .handler = [&](const Request& request) { return studio.answer(request); }});
    if (arguments.host != "127.0.0.1" && arguments.host != "::1")
        fmt::print(stderr,
                   "warning: others can reach {}: whoever has the address below can paint here and read the models and pictures "
                   "of {}. It is not encrypted; prefer ssh -L {}:127.0.0.1:{}\n",
                   arguments.host, folder.string(), server.port(), server.port());
    fmt::print("{}\n", server.address());
    std::fflush(stdout);
    if (!arguments.no_browser)
        open_browser(server.new_entrance());
    std::thread ending(
        [&]
        {
            int number = 0;
            sigwait(&ends, &number);
            server.stop();
        });
    server.serve();
    ending.join();
    return 0;
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app("Paint scans in a page in the browser: choose, preview, paint, go back, take along", "fresco studio");
    Arguments arguments;
    app.add_option("folder", arguments.folder, "Folder with scans, models and pictures, or of a run to watch")
        ->capture_default_str();
    app.add_option("--port", arguments.port, "Port of the page; 0: any that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    app.add_option("--host", arguments.host,
                   "Address of this machine to serve at; any but 127.0.0.1 lets in anyone who has the page's address")
        ->capture_default_str();
    app.add_option("--weights", arguments.weights,
                   "StyleMesh's VGG-19 (fresco weights get vgg19 downloads it); without: a file of weights in the folder");
    app.add_flag("--no-browser", arguments.no_browser, "Only print the address");
    return paint::run_command(app, argc, argv, [&] { return serve(arguments); });
}
