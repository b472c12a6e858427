#include "command_program.h"
#include "sheet.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/process.h>
#include <fresco/value.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

/// \file The program fresco-paint, which `fresco paint` runs: writes a pipeline file for a scan, pictures and a few settings, and
/// lets fresco run it.

using namespace fresco;
using namespace fresco::paint;

namespace
{

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

struct Arguments
{
    Settings settings;
    std::string out;
    bool preview = false;
    bool stylemesh = false;
    Words keep;
    Words sets;
    Words of_run;  ///< For `fresco run`, as they are.
};

fs::path own_folder()
{
    return fs::read_symlink("/proc/self/exe").parent_path();
}

std::string command_text(const Words& words)
{
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : " ") + shell_word(word);
    return text;
}

/// Relative where that is shorter to type: of what lies below the working directory.
std::string typed(const fs::path& path)
{
    const std::string relative = fs::proximate(path).string();
    return relative.starts_with("..") ? path.string() : relative;
}

/// fresco as the user can call it here.
std::string fresco_word()
{
    const fs::path program = own_folder() / "fresco";
    std::error_code failure;
    const std::string in_path = find_program("fresco");
    return !in_path.empty() && fs::equivalent(in_path, program, failure) ? "fresco" : typed(program);
}

std::string shipped_pictures()
{
    std::set<std::string> files;
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(own_folder().parent_path() / "share/fresco/pipelines/pictures", failure))
        files.insert(shell_word(typed(entry.path())));
    return fmt::format("\n  {}", fmt::join(files, "\n  "));
}

/// Makes the paths of the settings absolute. Throws where one is missing.
void resolve(Arguments& arguments)
{
    Settings& settings = arguments.settings;
    const auto resolved = [](fs::path& path)
    {
        if (!fs::exists(path))
            throw MissingInput(path.string() + ": no such file or folder");
        if (to_json(Value(path.string())).find("\uFFFD") != std::string::npos || path.string().find('\n') != std::string::npos)
            throw UsageError(path.string() + ": its name has line breaks or is not UTF-8, as a pipeline file must be: rename it");
        path = fs::absolute(path / "").lexically_normal().parent_path();
    };
    resolved(settings.scan);
    if (settings.pictures.empty())
        throw UsageError("name a picture to paint after, or several; fresco comes with" + shipped_pictures());
    for (fs::path& picture : settings.pictures)
        if (fs::is_directory(picture))
            throw UsageError(picture.string() + ": a folder; name the pictures to paint after: " + shell_word(picture.string()) +
                             "/*.jpg");
        else
            resolved(picture);
    if (std::set<fs::path>(settings.pictures.begin(), settings.pictures.end()).size() < settings.pictures.size())
        throw UsageError("a picture is named twice; name each once");
    for (const Words& words : {arguments.sets, Words{arguments.out}})
        for (const std::string& word : words)
            if (word.find('\n') != std::string::npos)
                throw UsageError("--set and --out take no line breaks");
    if (!arguments.keep.empty())
        settings.chosen.set("keep", Value::List(arguments.keep.begin(), arguments.keep.end()));
    if (arguments.stylemesh == settings.weights.empty())
        throw UsageError(arguments.stylemesh ? "--stylemesh needs --weights FILE: fresco weights get vgg19 prints it"
                                             : "--weights is for --stylemesh");
    if (arguments.stylemesh)
        resolved(settings.weights);
    for (auto& [key, value] : settings.chosen.as_map())
        if (arguments.stylemesh && key == "texture.stroke_cm")
            key = "strokes.stroke_cm";  // These strokes are laid over its texture.
    if (arguments.out.empty())
        arguments.out = "out/" + (fs::is_directory(settings.scan) ? settings.scan.filename() : settings.scan.stem()).string() +
                        (settings.pictures.size() == 1 ? "-" + settings.pictures.front().stem().string() : "");
}

Words run_words(const Arguments& arguments, const std::string& fresco, bool preview)
{
    const fs::path out = arguments.out;
    Words words{fresco, "run", (out / "room.yaml").string(), "--out", (preview ? out / "preview" : out).string()};
    if (preview)
        words.emplace_back("--preview");
    for (const std::string& set : arguments.sets)
        words.insert(words.end(), {"--set", set});
    words.insert(words.end(), arguments.of_run.begin(), arguments.of_run.end());
    return words;
}

/// Says what is wrong with a pipeline file before it is written; the exit code. Where no layout fits the scan, with what is
/// there.
int check(const Arguments& arguments, const std::string& text)
{
    const FileDescriptor memory(memfd_create("room.yaml", MFD_CLOEXEC));
    const fs::path copy = fmt::format("/proc/{}/fd/{}", getpid(), memory.get());
    if (write(memory.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()))
        throw Error("room.yaml cannot be held in memory: " + std::string(std::strerror(errno)));
    Words words{own_folder() / "fresco", "check", fs::path(arguments.out) / "room.yaml", "--text", copy, "--json"};
    for (const std::string& set : arguments.sets)
        words.insert(words.end(), {"--set", set});
    std::string output;
    std::FILE* pipe = popen((command_text(words) + " 2>/dev/null").c_str(), "re");
    for (int c = 0; pipe != nullptr && (c = std::getc(pipe)) != EOF;)
        output += static_cast<char>(c);
    const int status = pipe != nullptr ? pclose(pipe) : -1;
    if (status == 0 || output.empty())
        return 0;  // fresco run says what it is.
    const Value found = parse_json(output, "fresco check");
    for (const Value& problem : found.at("problems").as_list())
    {
        std::string told = problem.at("text").as_string();
        if (const std::size_t at = told.find("no layout fits "); at != std::string::npos)
            told = told.substr(at) + "\n" + contents_of(arguments.settings.scan);
        fmt::print(stderr, "error: {}\n", told);
    }
    return WEXITSTATUS(status);
}

/// Writes the pipeline file, or leaves an edited one that was written for the same settings. The exit code. Throws
/// UsageError where it may not.
int prepare(const Arguments& arguments)
{
    const fs::path path = fs::path(arguments.out) / "room.yaml";
    const std::string again = command_text(run_words(arguments, fresco_word(), false));
    std::string text = pipeline_text(arguments.settings, kind_of(arguments.settings.scan));
    const RoomState state = state_of(path, text);
    if (state == RoomState::other)
        throw UsageError(
            path.string() +
            ": was edited, is for another scan, or fresco paint did not write it, and it does not match these settings: choose "
            "another folder with --out, remove the file, or run it as it is: " +
            again);
    if (state == RoomState::replaceable)
    {
        text = with_heading(text, again);
        if (const int exit_code = check(arguments, text); exit_code != 0)
            return exit_code;
        fs::create_directories(arguments.out);
        write_durable_file(path, text);
    }
    fmt::print(stderr, "{} {}; {}: {}\n", path.string(),
               state == RoomState::edited ? "was edited and is used as it is" : "written",
               arguments.preview ? "in full" : "again", again);
    return 0;
}

/// Throws Error if the program cannot be run.
[[noreturn]] void become(const Words& words)
{
    std::vector<char*> pointers;
    for (const std::string& word : words)
        pointers.push_back(const_cast<char*>(word.c_str()));
    pointers.push_back(nullptr);
    std::signal(SIGPIPE, SIG_DFL);
    execv(pointers.front(), pointers.data());
    throw Error(words.front() + ": cannot be run: " + std::strerror(errno));
}

/// The run's exit code, as a shell gives it. Passes on the signals that would end this program.
int run_and_wait(const Words& words)
{
    sigset_t heard, before;
    sigemptyset(&heard);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD})
        sigaddset(&heard, number);
    sigprocmask(SIG_BLOCK, &heard, &before);
    const pid_t own = getpid(), child = fork();
    if (child == 0)
    {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        sigprocmask(SIG_SETMASK, &before, nullptr);
        if (getppid() == own)
            become(words);
        _exit(1);
    }
    int status = 0;
    while (child > 0 && waitpid(child, &status, WNOHANG) == 0)
    {
        siginfo_t info = {};
        const int number = sigwaitinfo(&heard, &info);
        if (number > 0 && number != SIGCHLD && info.si_code <= 0)  // The terminal's own reach the run without this program.
            kill(child, number);
    }
    if (child < 0)
        throw Error(words.front() + ": cannot be run: " + std::strerror(errno));
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int paint_scan(Arguments& arguments)
{
    resolve(arguments);
    if (const int exit_code = prepare(arguments); exit_code != 0)
        return exit_code;
    const bool wants_sheet = arguments.preview && arguments.settings.pictures.size() > 1;
    const Words words = run_words(arguments, own_folder() / "fresco", arguments.preview);
    if (!wants_sheet)
        become(words);  // So that whoever stops this program stops the run.
    const int exit_code = run_and_wait(words);
    try
    {
        if (exit_code == 0)
            if (const fs::path sheet = write_sheet(fs::path(arguments.out) / "preview"); !sheet.empty())
                fmt::print(stderr, "{}\n", sheet.string());
    }
    catch (const Error& error)
    {
        fmt::print(stderr, "warning: no sheet of the pictures: {}\n", error.what());
    }
    return exit_code;
}

void add_options(CLI::App& app, Arguments& arguments)
{
    Settings& settings = arguments.settings;
    app.add_option("scan", settings.scan,
                   "A recording (its folder or file, in any layout), a model (GLB, glTF, OBJ, PLY, …) or a splat")
        ->required();
    app.add_option("pictures", settings.pictures, "Pictures to paint after; several make a painting each");
    const auto list = [&](const char* name, Words& values, const Words& known, const char* help)
    { app.add_option(name, values, help)->delimiter(',')->allow_extra_args(false)->check(CLI::IsMember(known)); };
    app.add_option("--out", arguments.out,
                   "Folder for room.yaml and all results (default: out/SCAN-PICTURE; with several pictures out/SCAN)");
    app.add_flag("--preview", arguments.preview,
                 "A quick look, with fewer frames, faces and texels; of several pictures with a sheet to choose from");
    const auto number =
        [&](const char* name, std::initializer_list<const char*> keys, const char* help, const CLI::Validator& known)
    {
        app.add_option_function<double>(
               name,
               [&settings, keys = Words(keys.begin(), keys.end())](double value)
               {
                   for (const std::string& key : keys)
                       settings.chosen.set(key, value);
               },
               help)
            ->check(known);
    };
    number("--stroke-cm", {"texture.stroke_cm"}, "Width of the brush strokes in centimeters (default: 3.5 in a room)",
           CLI::Range(0.1, 1000.0));
    number("--strength", {"strength.color", "strength.strokes"}, "0: photo, 1: painting (default: 1)", CLI::Range(0.0, 1.0));
    list("--keep", arguments.keep, {"floor", "ceiling", "walls", "furniture"},
         "Leave these as photographed: floor, ceiling, walls, furniture");
    number("--size", {"atlas.size_px"}, "Texels per side of the texture (default: 2048)", CLI::Range(64, 16384));
    list("--with", settings.with, exports(),
         "Also write: glb, usdz, obj, ply, page (to walk through), video, views (all frames)");
    app.add_flag("--stylemesh", arguments.stylemesh, "Paint by StyleMesh instead: hours");
    app.add_option("--weights", settings.weights, "StyleMesh's VGG-19: the file that 'fresco weights get vgg19' prints");
    app.add_option("--set", arguments.sets, "STAGE.OPTION=VALUE, as for fresco run; may be repeated")->allow_extra_args(false);
    app.footer("Without a picture, it lists those that come with fresco. Arguments after '--' go to fresco run: -- --cores 2");
}

}  // namespace

int main(int argc, char** argv)
{
    const std::vector<char*> all(argv, argv + argc);
    const auto own_end = std::ranges::find_if(all, [](const char* word) { return std::string_view(word) == "--"; });
    Arguments arguments;
    if (own_end != all.end())
        arguments.of_run.assign(own_end + 1, all.end());
    CLI::App app("Paint a scan after pictures: writes a pipeline file, room.yaml, and runs it", "fresco paint");
    add_options(app, arguments);
    return run_command(app, static_cast<int>(own_end - all.begin()), argv, [&] { return paint_scan(arguments); });
}
